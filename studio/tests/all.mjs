// Drives the page of a built klieg in headless Chromium: node all.mjs CHROMIUM KLIEG MODEL FOLDER [NAME]
// MODEL is a model beside scenes/pair.glb, FOLDER where screenshots and downloads go, NAME a part of the tests' names.
import { writeFile } from "node:fs/promises";
import { writeBall } from "./ball.mjs";
import * as care from "./care.mjs";
import * as hands from "./hands.mjs";
import * as compare from "./compare.mjs";
import * as saying from "./saying.mjs";
import { browse, serve } from "./support.mjs";
import * as units from "./units.mjs";
import * as work from "./work.mjs";

const [chromium, program, model, folder, wanted = ""] = process.argv.slice(2);
// Unoptimised builds draw slowly, shadows and many samples above all.
const config = `${folder}/studio.toml`;
await writeFile(config, "[picture]\nsamples = 1\n");
const quick = ["--device", "cpu", "--config", config];
const plain = [...quick, "--shadows", "off"];
const small = [...plain, "--size", "256x256"];
const shadowed = [...quick, "--size", "64x64"];
const browser = await browse(chromium);
const server = await serve(program, [model, ...small]);
const ball = await serve(program, [await writeBall(folder), ...plain]);
const tests = Object.entries({ ...units, ...hands, ...compare, ...work, ...saying, ...care }).filter(([name]) => name.includes(wanted));
let failed = 0;
try {
  for (const [name, test] of tests) {
    const begin = Date.now();
    try {
      const said = await test({ browser, server, ball, program, model, shadowed, folder });
      console.log(`ok    ${name}, ${((Date.now() - begin) / 1000).toFixed(1)} s${said ? `: ${said}` : ""}`);
    } catch (error) {
      failed += 1;
      console.log(`FAILED ${name}: ${error.stack}`);
      const pages = await browser.pages();
      await pages.at(-1)?.screenshot({ path: `${folder}/${name}.png` });
      for (const page of pages.slice(1)) await page.close();
    }
  }
} finally {
  await browser.close();
  await server.stop();
  await ball.stop();
}
if (failed > 0 || tests.length === 0) {
  console.log(`${failed} of ${tests.length} tests failed`);
  process.exit(1);
}
