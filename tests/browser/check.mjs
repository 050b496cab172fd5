// Opens a page from disk in headless Chromium and prints what is wrong with it, and the values that
// it shows, as JSON: node check.mjs CHROMIUM FILE
import { pathToFileURL } from "node:url";
import puppeteer from "puppeteer-core";

const [executablePath, file] = process.argv.slice(2);
const address = pathToFileURL(file).href;
// Containers have no sandbox for root and little shared memory; nothing may be fetched from outside.
const args = [
  "--no-sandbox",
  "--disable-dev-shm-usage",
  "--disable-gpu",
  "--host-resolver-rules=MAP * ~NOTFOUND",
];
const timeout = 60_000;
const browser = await puppeteer.launch({ executablePath, args, timeout, protocolTimeout: timeout });
try {
  const report = { errors: [], requests: [], pictures: 0, broken: [], layouts: [], values: [] };
  const page = await browser.newPage();
  page.on("console", (message) => {
    if (message.type() === "error") report.errors.push(message.text());
  });
  page.on("pageerror", (error) => report.errors.push(String(error)));
  page.on("request", (request) => {
    const url = request.url();
    if (url !== address && !/^(data|blob|about):/.test(url)) report.requests.push(url);
  });
  await page.goto(address, { waitUntil: "load", timeout });

  const pictures = await page.evaluate(async () => {
    const sources = [...document.querySelectorAll("img, svg image")].map((element) =>
      element instanceof HTMLImageElement ? element.currentSrc || element.src : element.href.baseVal
    );
    const loads = async (source) => {
      const picture = new Image();
      picture.src = source;
      return picture.decode().then(() => picture.naturalWidth > 0, () => false);
    };
    const loaded = await Promise.all(sources.map(loads));
    return { count: sources.length, broken: sources.filter((_, index) => !loaded[index]) };
  });
  report.pictures = pictures.count;
  report.broken = pictures.broken.map((source) => source.slice(0, 80));

  for (const scheme of ["light", "dark"]) {
    await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
    for (const width of [390, 1280]) {
      await page.setViewport({ width, height: 900 });
      const layout = await page.evaluate(() => {
        const root = document.documentElement;
        return {
          scrolls: root.scrollWidth > root.clientWidth,
          content: root.scrollWidth,
          background: getComputedStyle(document.body).backgroundColor,
        };
      });
      report.layouts.push({ scheme, width, ...layout });
    }
  }
  report.values = await page.evaluate(() =>
    [...document.querySelectorAll("[data-value]")].map((element) => [
      element.getAttribute("data-value"),
      element.textContent.trim(),
    ])
  );
  report.requests = [...new Set(report.requests)];
  console.log(JSON.stringify(report));
} finally {
  await browser.close();
}
