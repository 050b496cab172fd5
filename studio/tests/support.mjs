// What the browser's tests share: klieg's server, a page, and how to look at it.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { once } from "node:events";
import { readdir, readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { join } from "node:path";
import puppeteer from "puppeteer-core";

export const WAIT = 90_000;

/** Starts `klieg studio` and gives its address. Extra environment is the server's. */
export async function serve(program, options, environment = {}) {
  const server = spawn(program, ["studio", ...options, "--no-open"], {
    env: { ...process.env, ...environment },
    stdio: ["ignore", "pipe", "inherit"],
  });
  const address = await new Promise((resolve, reject) => {
    let text = "";
    server.stdout.on("data", (data) => {
      text += data;
      const match = /studio: (http:\S+)/.exec(text);
      if (match) resolve(match[1]);
    });
    server.on("error", reject);
    server.on("exit", (code) => reject(new Error(`klieg studio ended with ${code}: ${text}`)));
  });
  const stop = async () => {
    if (server.exitCode !== null || server.signalCode !== null) return;
    const ended = once(server, "exit");
    server.kill("SIGTERM");
    await ended;
  };
  return { address, stop };
}

export async function browse(executablePath) {
  const args = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"];
  return puppeteer.launch({ executablePath, args, timeout: 60_000, protocolTimeout: 300_000 });
}

/** Opens the page in a tab, after `before` has run there; what goes wrong in it is gathered in `errors`. */
export async function open(browser, address, { width = 1280, height = 800, before = () => {} } = {}) {
  const page = await browser.newPage();
  await page.evaluateOnNewDocument(before);
  const errors = [];
  page.on("pageerror", (error) => errors.push(String(error)));
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("request", (request) => {
    const { protocol, hostname } = new URL(request.url());
    if (hostname !== "127.0.0.1" && !["data:", "blob:"].includes(protocol)) errors.push(`asks for ${request.url()}`);
  });
  await page.setViewport({ width, height });
  await page.goto(address, { waitUntil: "domcontentloaded" });
  return { page, errors };
}

const canvas = ".frame .picture[role=application] > canvas";

/** Waits until the picture of the document stands as it is judged; the final one may take long. */
export const atRest = (page) => page.waitForSelector('.stage[aria-busy="false"]', { timeout: WAIT });

/** Waits until no search runs, pausing the one that does, and the picture stands. */
export async function calm(page) {
  await page.waitForSelector("[data-search]", { timeout: WAIT });
  await page.$eval("[data-search]", (element) => {
    const button = document.querySelector('[aria-label="Pause the search"]');
    if (element.dataset.search === "running") button.click();
  });
  await page.waitForFunction(() => document.querySelector("[data-search]").dataset.search !== "running", { timeout: WAIT });
  await atRest(page);
}

export const score = (page) => page.$eval("[data-score]", (element) => Number(element.textContent));

/** Mean luminance of the picture in 32 by 32 blocks, 0 to 255, whatever its quality. */
export const picture = (page) =>
  page.$eval(canvas, (element) => {
    const { width, height } = element;
    const { data } = element.getContext("2d").getImageData(0, 0, width, height);
    const [sums, counts] = [new Array(1024).fill(0), new Array(1024).fill(0)];
    for (let pixel = 0; pixel < width * height; pixel++) {
      const [x, y] = [pixel % width, Math.floor(pixel / width)];
      const block = 32 * Math.floor((32 * y) / height) + Math.floor((32 * x) / width);
      sums[block] += 0.2126 * data[4 * pixel] + 0.7152 * data[4 * pixel + 1] + 0.0722 * data[4 * pixel + 2];
      counts[block] += 1;
    }
    return sums.map((sum, block) => sum / counts[block]);
  });

/** Above this two pictures differ, however fine each of them is. */
export const ALIKE = 1;

/** Mean absolute difference of two pictures, 0 to 255. */
export const difference = (a, b) => a.reduce((sum, value, index) => sum + Math.abs(value - b[index]), 0) / a.length;

/** The middle of an element, page pixels. */
export async function middle(page, selector) {
  const box = await (await page.waitForSelector(selector, { timeout: WAIT })).boundingBox();
  return [box.x + box.width / 2, box.y + box.height / 2];
}

/** Presses at a point, moves in steps, and lets go. */
export async function drag(page, [x, y], [right, down], steps = 12) {
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let step = 1; step <= steps; step++) {
    await page.mouse.move(x + (right * step) / steps, y + (down * step) / steps);
    await new Promise((resolve) => setTimeout(resolve, 16));
  }
  await page.mouse.up();
}

export const directions = (page) =>
  page.$$eval(".handle", (handles) => handles.map((handle) => handle.getAttribute("aria-valuetext")));

export const pause = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** The value below which a share of sorted values lies. */
export const quantile = (sorted, share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];

/** Moves a light in circles for a while, as a hand does. The moves do not wait for pictures. */
export async function circle(page, moves, milliseconds = 16) {
  const [x, y] = await middle(page, '[data-light="0"]');
  const disc = await middle(page, ".disc");
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let move = 0; move < moves; move++) {
    const angle = move / 9;
    await page.mouse.move(disc[0] + 60 * Math.cos(angle), disc[1] + 60 * Math.sin(angle));
    if (milliseconds) await pause(milliseconds);
  }
  await page.mouse.up();
  await atRest(page);
}

/** Memory after garbage collection, MB; bytes of pictures are counted apart from the heap. */
export async function memory(client) {
  await client.send("HeapProfiler.collectGarbage");
  const { usedSize, backingStorageSize = 0 } = await client.send("Runtime.getHeapUsage");
  return (usedSize + backingStorageSize) / 1e6;
}

/** The name of the file that is new and complete in a folder. */
export async function arrived(folder, known) {
  for (const end = Date.now() + WAIT; Date.now() < end; await pause(30)) {
    const names = (await readdir(folder)).filter((name) => !name.endsWith(".crdownload") && !known.includes(join(folder, name)));
    if (names.length > 0) return names[0];
  }
  throw new Error("no file was saved");
}

const axe = await readFile(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** Violations of axe-core's rules, in words. */
export async function violations(page) {
  // Colours on their way from one scheme to the other have no contrast yet.
  await page.evaluate(async () => {
    const frame = () => new Promise(requestAnimationFrame);
    await frame();
    await frame();
    const ends = (animation) => animation.effect.getComputedTiming().endTime < Infinity;
    await Promise.allSettled(document.getAnimations().filter(ends).map(({ finished }) => finished));
  });
  // The page's policy forbids scripts from elsewhere, so the rules run in a world of their own.
  const client = await page.createCDPSession();
  const { frameTree } = await client.send("Page.getFrameTree");
  const { executionContextId: contextId } = await client.send("Page.createIsolatedWorld", { frameId: frameTree.frame.id });
  await client.send("Runtime.evaluate", { expression: axe, contextId });
  const { result } = await client.send("Runtime.evaluate", {
    contextId,
    awaitPromise: true,
    returnByValue: true,
    expression: `axe.run(document, { resultTypes: ["violations"] }).then(({ violations, passes }) => ({
      faults: violations.map(({ id, nodes }) => id + ": " + nodes.map(({ target, failureSummary }) => target + " " + failureSummary).slice(0, 3).join("; ")),
      passes: passes.length }))`,
  });
  assert.ok(result.value.passes > 15, "the rules were run");
  return result.value.faults;
}
