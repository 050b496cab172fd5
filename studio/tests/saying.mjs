// What light is wanted, said on the page.
import assert from "node:assert/strict";
import { mkdir, rm } from "node:fs/promises";
import { dirname, join } from "node:path";
import { arrived, atRest, calm, open, picture, score, serve, violations, WAIT } from "./support.mjs";

const label = (page) => page.$eval(".steps [aria-current] span", (step) => step.textContent);
const told = (page, text) => page.waitForFunction((wanted) => document.querySelector(".steps [aria-current] span")?.textContent === wanted, { timeout: WAIT }, text);
const mood = (page) => page.$eval('.moods :checked', (input) => input.value);
const brightness = (page) => page.$eval('[aria-label="Brightness"]', (input) => input.getAttribute("aria-valuetext"));
const aim = (page) => page.$eval(".target.mean", (mark) => Number.parseFloat(mark.style.left));
/** The weight of a term; those without one are not listed. */
const weight = (page, term) => page.evaluate((name) => Number(document.querySelector(`[aria-label="Weight of ${name}"]`)?.value ?? 0), term);

/** Searches to the end. */
async function search(page) {
  await page.click(".controls .primary");
  await page.waitForSelector('[data-search="running"]', { timeout: WAIT });
  await page.waitForSelector('[data-search="finished"]', { timeout: WAIT });
  await atRest(page);
}

/** Moves the slider of brightness by so many steps, with keys. */
async function brighten(page, steps) {
  await page.focus('[aria-label="Brightness"]');
  for (let step = 0; step < Math.abs(steps); step++) await page.keyboard.press(steps < 0 ? "ArrowLeft" : "ArrowRight");
}

const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

export async function whatIsWantedMovesTargetsAndLights({ browser, program, model, shadowed, folder }) {
  const server = await serve(program, [model, ...shadowed, "--generations", "30"]);
  const { page, errors } = await open(browser, server.address);
  try {
    await calm(page);
    const before = [await score(page), await aim(page), await weight(page, "Edges")];
    assert.equal(await mood(page), "natural");
    assert.equal(await page.$(".target.spread"), null);
    await page.click('.moods [value="dramatic"]');
    await told(page, "Dramatic mood");
    await atRest(page);
    assert.ok((await aim(page)) < before[1] - 5, "a darker mean is aimed at");
    assert.ok(await page.$(".target.spread"), "and a spread");
    assert.notEqual(await score(page), before[0]);
    assert.equal(await weight(page, "Edges"), 0);
    await page.click(".wanted [type=checkbox]");
    await told(page, "No light from below");
    for (const scheme of ["light", "dark"]) {
      await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
      assert.deepEqual(await violations(page), [], scheme);
    }
    const moody = await score(page);
    await search(page);
    assert.ok((await score(page)) < moody, "a search finds such light");

    // A weight that is set by hand stays until something else is wanted.
    await page.focus('[aria-label="Weight of Detail"]');
    await page.keyboard.press("PageUp");
    const byHand = await weight(page, "Detail");
    await page.click(".wanted .button");
    await told(page, "Nothing in particular wanted");
    assert.ok((await weight(page, "Detail")) < byHand);
    assert.deepEqual([await aim(page), await weight(page, "Edges")], before.slice(1));

    const seen = {};
    for (const [steps, text] of [[2, "+1"], [-4, "−1"]]) {
      await brighten(page, steps);
      await told(page, `Brightness ${text}`);
      assert.equal(await brightness(page), text);
      await search(page);
      seen[text] = mean(await picture(page));
    }
    assert.ok(seen["+1"] > seen["−1"] + 5, `${seen["+1"]} and ${seen["−1"]} of 255`);

    const saved = await session(page, join(folder, "wanted"));
    while ((await brightness(page)) !== "+1") await page.click('[aria-label="Undo"]');
    assert.match(await label(page), /^Search|Brightness/);
    const [chooser] = await Promise.all([page.waitForFileChooser(), page.click('[aria-label="Open a model or a session"]')]);
    await chooser.accept([saved]);
    await told(page, "Opened");
    assert.equal(await brightness(page), "−1");
    await page.reload();
    await atRest(page);
    assert.equal(await brightness(page), "−1");
    assert.deepEqual(errors, []);
    return `mean of the picture ${seen["−1"].toFixed(0)} and ${seen["+1"].toFixed(0)} of 255`;
  } finally {
    await page.close();
    await server.stop();
  }
}

/** Saves the session; gives its file. */
async function session(page, downloads) {
  await rm(downloads, { recursive: true, force: true });
  await mkdir(downloads);
  const client = await page.createCDPSession();
  await client.send("Browser.setDownloadBehavior", { behavior: "allow", downloadPath: downloads });
  await page.click('[aria-label="Save"]');
  await page.click('[data-save="session"]');
  await page.waitForSelector("dialog[open]", { hidden: true, timeout: WAIT });
  return join(downloads, await arrived(downloads, []));
}

export async function thePageBeginsWithWhatTheCommandLineWants({ browser, program, model, shadowed }) {
  const server = await serve(program, [model, ...shadowed, "--mood", "soft", "--brightness", "0.5", "--no-below"]);
  const { page, errors } = await open(browser, server.address);
  try {
    await calm(page);
    assert.deepEqual([await mood(page), await brightness(page)], ["soft", "+0.5"]);
    assert.ok(await page.$eval(".wanted [type=checkbox]", (box) => box.checked));
    await page.focus('.moods [value="soft"]');
    await page.keyboard.press("ArrowRight");
    await told(page, "Natural mood");
    await page.click('[aria-label="Undo"]');
    assert.equal(await mood(page), "soft");
    assert.deepEqual(errors, []);
  } finally {
    await page.close();
    await server.stop();
  }
}

export async function anObjectIsLitBeforeAllOthersAndAnotherStaysDim({ browser, program, model, shadowed }) {
  const pair = join(dirname(model), "pair.glb");
  const server = await serve(program, [pair, ...shadowed, "--focus", "amphora"]);
  const { page, errors } = await open(browser, server.address);
  try {
    await calm(page);
    const said = () => page.$eval(".objects .note", (note) => note.textContent);
    assert.match(await said(), /amphora first/);
    await page.click(".objects .link");
    const kinds = () => page.$$eval(".objects select", (selects) => selects.map(({ value }) => value).sort().join());
    assert.equal(await kinds(), "focus,plain");
    const before = await score(page);
    const choose = (kind, to) => page.evaluate((from, value) => {
      const select = [...document.querySelectorAll(".objects select")].find((other) => other.value === from);
      select.value = value;
      select.dispatchEvent(new Event("change", { bubbles: true }));
    }, kind, to);
    await choose("plain", "dim");
    assert.equal(await kinds(), "dim,focus");
    await atRest(page);
    const dim = await score(page);
    assert.notEqual(dim, before);
    assert.deepEqual(await violations(page), []);
    await choose("focus", "plain");
    assert.equal(await kinds(), "dim,plain");
    await page.click('[aria-label="Undo"]');
    await page.click('[aria-label="Undo"]');
    await atRest(page);
    assert.deepEqual([await kinds(), await score(page)], ["focus,plain", before]);
    await page.click(".wanted .button");
    await told(page, "Nothing in particular wanted");
    assert.deepEqual([await kinds(), await said()], ["plain,plain", "2 objects count alike"]);
    assert.deepEqual(errors, []);
  } finally {
    await page.close();
    await server.stop();
  }
}
