// Works the wiper of a design's sheet in headless Chromium and prints what it shows, as JSON: node wiper.mjs CHROMIUM FILE
import { pathToFileURL } from "node:url";
import puppeteer from "puppeteer-core";

const [executablePath, file] = process.argv.slice(2);
const timeout = 60_000;
const args = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--host-resolver-rules=MAP * ~NOTFOUND"];
const browser = await puppeteer.launch({ executablePath, args, timeout, protocolTimeout: timeout });
try {
  const page = await browser.newPage();
  await page.setViewport({ width: 1280, height: 900 });
  await page.goto(pathToFileURL(file).href, { waitUntil: "load", timeout });
  // Where the pictures meet, percent, and the numbers of those on the page that are on its left and on its right.
  const state = () =>
    page.evaluate(() => {
      const wiper = document.querySelector(".wiper");
      const pictures = [...document.querySelectorAll(".pair > figure img")].map((image) => image.src);
      const line = wiper.querySelector(".wiped i").getBoundingClientRect();
      const stage = wiper.querySelector(".wiped").getBoundingClientRect();
      return {
        at: (100 * (line.left + line.width / 2 - stage.left)) / stage.width,
        shown: [...wiper.querySelectorAll("img")].map((image) => pictures.indexOf(image.src)),
      };
    });
  const states = [await state()];
  await page.$eval(".wiped", (stage) => stage.scrollIntoView({ block: "center" }));
  const { x, y, width, height } = await (await page.$(".wiped")).boundingBox();
  await page.mouse.move(x + 0.5 * width, y + 0.5 * height);
  await page.mouse.down();
  await page.mouse.move(x + 0.25 * width, y + 0.4 * height);
  await page.mouse.up();
  await page.mouse.move(x + 0.9 * width, y + 0.4 * height);
  states.push(await state());
  await page.focus(".wiper input");
  await page.keyboard.press("End");
  states.push(await state());
  const choices = await page.$$eval(".wiper option", (options) => options.map((option) => option.textContent));
  await page.select(".wiper select", await page.$eval(".wiper option:last-child", (option) => option.value));
  states.push(await state());
  await page.setJavaScriptEnabled(false);
  await page.reload({ waitUntil: "load", timeout });
  const withoutScripts = (await (await page.$(".wiper")).boundingBox()) === null;
  console.log(JSON.stringify({ states, choices, withoutScripts }));
} finally {
  await browser.close();
}
