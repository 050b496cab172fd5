// Lights beside other lights: presets under the wiper and side by side, alternatives, history.
import assert from "node:assert/strict";
import { ALIKE, atRest, calm, difference, directions, open, picture, WAIT } from "./support.mjs";

const other = ".under > canvas, .picture.still > canvas";
const drawn = (page) => page.waitForFunction((selector) => document.querySelector(selector)?.width > 1, { timeout: WAIT }, other);

export async function aPresetIsComparedAndTaken({ browser, server }) {
  const { page, errors } = await open(browser, server.address);
  await calm(page);
  const before = await directions(page);
  await page.select(".compare select", "three-point");
  await drawn(page);
  await atRest(page);
  assert.match(await page.$eval(".score .better, .score .worse", (text) => text.textContent), /[−+]0\.\d+ (better|worse)/);
  assert.ok((await page.$$(".meter b")).length > 3, "terms show the compared values");
  const cut = () => page.$eval(".under", (under) => getComputedStyle(under).clipPath);
  const half = await cut();
  await page.focus(".wiper");
  for (let press = 0; press < 4; press++) await page.keyboard.press("ArrowRight");
  assert.notEqual(await cut(), half);
  assert.equal(await page.$eval(".wiper", (wiper) => wiper.getAttribute("aria-valuenow")), "60");

  await page.click('[aria-label="Side by side"]');
  await drawn(page);
  assert.equal((await page.$$(".frame")).length, 2);
  await page.$$eval(".compare .button", (buttons) => buttons.find((button) => button.textContent === "Use these").click());
  await atRest(page);
  assert.equal((await directions(page)).length, 3);
  await page.click('[aria-label="End the comparison"]');
  assert.equal((await page.$$(".frame")).length, 1);
  const taken = await picture(page);
  await page.$$eval(".steps button", (steps) => steps.at(-1).click());
  await atRest(page);
  assert.deepEqual((await directions(page)).length, before.length);
  assert.ok(difference(taken, await picture(page)) > ALIKE, "the history's first step stands again");
  assert.deepEqual(errors, []);
  await page.close();
}

export async function alternativesAreShownAndTaken({ browser, server }) {
  const { page, errors } = await open(browser, server.address);
  await calm(page);
  const before = await directions(page);
  await page.click(".strip > .button");
  const seen = () => [...document.querySelectorAll(".thumbnail canvas")].filter(({ width }) => width > 1).length >= 2;
  await page.waitForFunction(seen, { timeout: WAIT });
  // The first ones may be the lights that it began with.
  await page.click(".strip li:last-child .thumbnail");
  await atRest(page);
  assert.notDeepEqual(await directions(page), before);
  await page.click('[aria-label="Undo"]');
  assert.deepEqual(await directions(page), before);
  assert.deepEqual(errors, []);
  await page.close();
}

/** Both pictures become final, also where the one is asked for while the other is made, and no coarser one takes their place. */
export async function finalPicturesComeAndStay({ browser, ball }) {
  const { page, errors } = await open(browser, ball.address);
  await calm(page);
  await page.select(".compare select", "headlight");
  await drawn(page);
  const qualities = () => [...document.querySelectorAll(".frame canvas")].map((canvas) => canvas.dataset.quality).join();
  await page.waitForFunction(`(${qualities})() === "2,2"`, { timeout: WAIT });
  await page.setViewport({ width: 1280, height: 720 });
  const seen = new Set();
  for (let look = 0; look < 20; look++) {
    seen.add(await page.evaluate(qualities));
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  assert.deepEqual([...seen], ["2,2"]);
  assert.deepEqual(errors, []);
  await page.close();
}
