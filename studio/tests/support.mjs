// What the browser's tests share: klieg's server, a page, and how to look at it.
import { spawn } from "node:child_process";
import { once } from "node:events";
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
    server.kill("SIGKILL");
    await ended;
  };
  return { address, stop };
}

export async function browse(executablePath) {
  const args = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1"];
  return puppeteer.launch({ executablePath, args, timeout: 60_000, protocolTimeout: 120_000 });
}

/** Opens the page in a tab; what goes wrong in it is gathered in `errors`. */
export async function open(browser, address, { width = 1280, height = 800 } = {}) {
  const page = await browser.newPage();
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

/** Waits until no search runs, pausing the one that does. */
export async function calm(page) {
  await page.waitForSelector("[data-search]", { timeout: WAIT });
  const running = await page.$eval("[data-search]", (element) => element.dataset.search === "running");
  if (running) await page.click('[aria-label="Pause the search"]');
  await page.waitForFunction(() => document.querySelector("[data-search]").dataset.search !== "running", { timeout: WAIT });
  await atRest(page);
}

export const score = (page) => page.$eval("[data-score]", (element) => Number(element.textContent));

/** Luminance of the picture on 64 by 64 points, 0 to 255; 0 where there is nothing. */
export const picture = (page) =>
  page.$eval(canvas, (element) => {
    const { width, height } = element;
    const { data } = element.getContext("2d").getImageData(0, 0, width, height);
    return Array.from({ length: 4096 }, (_, index) => {
      const x = Math.floor((((index % 64) + 0.5) * width) / 64);
      const y = Math.floor(((Math.floor(index / 64) + 0.5) * height) / 64);
      const at = 4 * (y * width + x);
      return ((0.2126 * data[at] + 0.7152 * data[at + 1] + 0.0722 * data[at + 2]) * data[at + 3]) / 255;
    });
  });

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
