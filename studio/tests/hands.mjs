// By hand: the first picture, drags on the dome, clicks on the model, keys, undo.
import assert from "node:assert/strict";
import { ALIKE, atRest, calm, difference, directions, drag, middle, open, pause, picture, score, WAIT } from "./support.mjs";

const LIT = 8;

export async function theModelStandsLit({ browser, server }) {
  const { page, errors } = await open(browser, server.address);
  const begin = Date.now();
  await page.waitForFunction(() => document.querySelector(".frame canvas")?.width > 1, { timeout: 30_000, polling: 20 });
  const first = Date.now() - begin;
  await calm(page);
  const seen = await picture(page);
  const lit = seen.filter((value) => value > LIT).length / seen.length;
  assert.ok(lit > 0.05, `${(100 * lit).toFixed(1)} % of the picture is lit`);
  assert.ok((await score(page)) > 0);
  assert.deepEqual(errors, []);
  await page.close();
  return `first picture ${first} ms after the page`;
}

export async function draggingALightChangesFAndThePicture({ browser, server }) {
  const { page, errors } = await open(browser, server.address);
  await calm(page);
  const before = [await score(page), await picture(page), await directions(page)];
  await drag(page, await middle(page, '[data-light="0"]'), [-60, 90]);
  await atRest(page);
  const after = [await score(page), await picture(page), await directions(page)];
  assert.notEqual(before[0], after[0]);
  assert.ok(difference(before[1], after[1]) > ALIKE, "the picture has changed");
  assert.notEqual(before[2][0], after[2][0]);
  assert.deepEqual(before[2].slice(1), after[2].slice(1));

  await page.keyboard.down("Control");
  await page.keyboard.press("z");
  await page.keyboard.up("Control");
  await atRest(page);
  assert.deepEqual(await directions(page), before[2]);
  assert.equal(await score(page), before[0]);
  assert.ok(difference(before[1], await picture(page)) < ALIKE, "undone, the picture is as before");
  assert.deepEqual(errors, []);
  await page.close();
}

export async function keysMoveFinelyAndScrollingChangesTheIntensity({ browser, server }) {
  const { page } = await open(browser, server.address);
  await calm(page);
  const angle = () => page.$eval('[data-light="0"]', (handle) => Number(handle.getAttribute("aria-valuenow")));
  const typed = (label) => page.$eval(`[aria-label="${label}, typed"]`, (entry) => Number.parseFloat(entry.value));
  await page.focus('[data-light="0"]');
  const before = await typed("Azimuth");
  await page.keyboard.press("ArrowRight");
  assert.ok(Math.abs((await typed("Azimuth")) - before - 2) < 0.11);
  await page.keyboard.down("Shift");
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.up("Shift");
  assert.ok(Math.abs((await typed("Azimuth")) - before - 1.75) < 0.11, `${before} ${await angle()}`);

  const intensity = () => page.$eval(".light.chosen .light-row output", (output) => Number(output.textContent));
  const dim = await intensity();
  const [x, y] = await middle(page, ".disc");
  await page.mouse.move(x, y);
  await page.mouse.wheel({ deltaY: -100 });
  await page.waitForFunction((old) => Number(document.querySelector(".light.chosen .light-row output").textContent) > old, {}, dim);
  await page.close();
}

/** Where the picture is brightest, in shares of its size. */
const brightest = (page) =>
  page.$eval(".frame .picture[role=application] > canvas", (element) => {
    const { width, height } = element;
    const { data } = element.getContext("2d").getImageData(0, 0, width, height);
    let most = 0;
    for (let at = 0; at < data.length; at += 4) most = Math.max(most, data[at] + data[at + 1] + data[at + 2]);
    let [x, y, count] = [0, 0, 0];
    for (let at = 0; at < data.length; at += 4) {
      if (data[at] + data[at + 1] + data[at + 2] < most - 6) continue;
      [x, y, count] = [x + ((at / 4) % width) + 0.5, y + Math.floor(at / 4 / width) + 0.5, count + 1];
    }
    return [x / count / width, y / count / height];
  });

/** A smooth, shiny ball is lit by one light, whose highlight is asked for at several pixels. */
export async function aHighlightLandsWhereItIsAskedFor({ browser, ball }) {
  const { page, errors } = await open(browser, ball.address);
  await calm(page);
  // One light alone, and not so strong that its highlight is a plateau.
  while ((await page.$$(".light")).length > 1) await page.click(".light:last-child [aria-label^='Remove']");
  await page.click('.segments [value="highlight"]');
  const box = await (await page.$(".picture[role=application]")).boundingBox();
  const off = [];
  for (const [across, down] of [[0.5, 0.5], [0.42, 0.4], [0.6, 0.45], [0.47, 0.62]]) {
    const before = await directions(page);
    await page.mouse.click(box.x + across * box.width, box.y + down * box.height);
    const moved = (old) => document.querySelector('[data-light="0"]').getAttribute("aria-valuetext") !== old;
    await page.waitForFunction(moved, { timeout: WAIT }, before[0]);
    await pause(200);
    await atRest(page);
    const [x, y] = await brightest(page);
    off.push(512 * Math.hypot(x - across, y - down));
  }
  assert.ok(Math.max(...off) <= 3, `the highlight is off by ${off.map((pixels) => pixels.toFixed(1))} pixels of 512`);
  await page.mouse.click(box.x + 3, box.y + 3);
  await page.waitForSelector(".ping.missed", { timeout: 5000 });
  assert.deepEqual(errors, []);
  await page.close();
  return `off by ${off.map((pixels) => pixels.toFixed(2)).join(", ")} pixels`;
}

export async function theModelTurnsAndItsLightsStay({ browser, server }) {
  const { page } = await open(browser, server.address);
  await calm(page);
  const before = [await picture(page), await directions(page)];
  await drag(page, await middle(page, ".picture[role=application]"), [120, 30]);
  await atRest(page);
  assert.ok(difference(before[0], await picture(page)) > ALIKE);
  assert.notDeepEqual(await directions(page), before[1]);
  await page.focus(".picture[role=application]");
  await page.keyboard.press("Home");
  await atRest(page);
  await page.waitForFunction((old) => document.querySelector('[data-light="0"]').getAttribute("aria-valuetext") === old, { timeout: 5000 }, before[1][0]);
  await atRest(page);
  assert.ok(difference(before[0], await picture(page)) < ALIKE, "back at the first view, the light is as before");
  await page.close();
}

export async function lightsAreAddedLockedAndRemoved({ browser, server }) {
  const { page, errors } = await open(browser, server.address);
  await calm(page);
  const before = await picture(page);
  const count = (await directions(page)).length;
  await page.click('[aria-label="Add a light"]');
  await atRest(page);
  assert.equal((await directions(page)).length, count + 1);
  assert.ok(difference(before, await picture(page)) > 0.01, "it is seen, if only at the edges");
  // The new light is the chosen one.
  await page.select(".editor .choice:nth-of-type(2) select", "spot");
  await page.waitForSelector('[aria-label="Cone, typed"]');
  await page.focus(`[data-light="${count}"]`);
  await page.keyboard.press("l");
  assert.match((await directions(page))[count], /locked/);
  await page.keyboard.press("Delete");
  await atRest(page);
  assert.equal((await directions(page)).length, count);
  assert.ok(difference(before, await picture(page)) < ALIKE);
  assert.deepEqual(errors, []);
  await page.close();
}
