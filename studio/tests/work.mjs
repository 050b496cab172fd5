// The search, files, several tabs, and a server that goes and comes.
import assert from "node:assert/strict";
import { mkdir, readFile, rm } from "node:fs/promises";
import { join } from "node:path";
import { ALIKE, arrived, atRest, calm, difference, directions, drag, middle, open, pause, picture, score, serve, WAIT } from "./support.mjs";

const state = (page) => page.$eval("[data-search]", (element) => element.dataset.search);

export async function aSearchRunsPausesAndGoesOn({ browser, server }) {
  const { page, errors } = await open(browser, server.address);
  await calm(page);
  // A poor light to begin with: the key from below.
  await drag(page, await middle(page, '[data-light="0"]'), [0, 110]);
  await atRest(page);
  const poor = await score(page);
  await page.click(".controls .primary");
  await page.waitForFunction(() => document.querySelector(".curve .line"), { timeout: WAIT });
  await page.waitForFunction((before) => Number(document.querySelector("[data-score]").textContent) < before - 1e-3, { timeout: WAIT }, poor);
  if ((await state(page)) === "running") await page.click('[aria-label="Pause the search"]');
  await atRest(page);
  const found = [await score(page), await directions(page)];
  await pause(400);
  assert.deepEqual(await directions(page), found[1], "a search that waits moves no light");

  const step = await page.$eval(".controls .soft", (element) => Number.parseInt(element.textContent.replaceAll(",", ""), 10));
  if ((await state(page)) === "paused") {
    await page.click('[aria-label="Step one generation"]');
    await page.waitForFunction((old) => Number.parseInt(document.querySelector(".controls .soft").textContent.replaceAll(",", ""), 10) !== old, { timeout: WAIT }, step);
  }
  await calm(page);
  await drag(page, await middle(page, '[data-light="1"]'), [40, -30]);
  const text = await page.$eval(".controls .primary", (element) => element.textContent);
  assert.match(text, /Go on from here|Search again/);
  await page.click('[aria-label="Undo"]');
  await page.click('[aria-label="Undo"]');
  assert.deepEqual(errors, []);
  await page.close();
}

export async function aSessionIsSavedAndOpenedAgain({ browser, server, folder }) {
  const { page, errors } = await open(browser, server.address);
  await calm(page);
  await drag(page, await middle(page, '[data-light="0"]'), [30, 60]);
  await atRest(page);
  const before = [await score(page), await directions(page), await picture(page)];
  const downloads = join(folder, "downloads");
  await rm(downloads, { recursive: true, force: true });
  await mkdir(downloads);
  const client = await page.createCDPSession();
  await client.send("Browser.setDownloadBehavior", { behavior: "allow", downloadPath: downloads });
  const files = {};
  for (const [kind, magic] of [["glb", "glTF"], ["png", "\x89PNG"], ["rig", "{"], ["session", "glTF"]]) {
    await page.click('[aria-label="Save"]');
    if (kind === "png") await page.$eval("dialog input[type=number]", (input) => {
      input.value = "256";
      input.dispatchEvent(new Event("input", { bubbles: true }));
    });
    await page.click(`[data-save="${kind}"]`);
    await page.waitForSelector("dialog[open]", { hidden: true, timeout: WAIT });
    files[kind] = join(downloads, await arrived(downloads, Object.values(files)));
    const head = (await readFile(files[kind])).subarray(0, magic.length).toString("latin1");
    assert.equal(head, magic, kind);
  }
  await page.click('[aria-label="Undo"]');
  await pause(100);
  const [chooser] = await Promise.all([page.waitForFileChooser(), page.click('[aria-label="Open a model or a session"]')]);
  await chooser.accept([files.session]);
  await page.waitForFunction(() => document.querySelector(".scene-name b").textContent.includes("session"), { timeout: WAIT });
  await calm(page);
  assert.equal(await score(page), before[0]);
  assert.deepEqual(await directions(page), before[1]);
  assert.ok(difference(await picture(page), before[2]) < ALIKE);
  assert.deepEqual(errors, []);
  await page.close();
}

export async function aFileThatIsNoModelIsRefusedInWords({ browser, server, folder }) {
  const { page } = await open(browser, server.address);
  await calm(page);
  const drop = (name, text) =>
    page.evaluate((file, content) => {
      const data = new DataTransfer();
      data.items.add(new File([content], file));
      document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
    }, name, text);
  const told = () => page.waitForSelector(".notice.fault p", { timeout: WAIT }).then((element) => element.evaluate((p) => p.textContent));
  await drop("notes.txt", "no model");
  assert.match(await told(), /notes\.txt is no model/);
  await page.click('[aria-label="Close this message"]');
  await drop("bad.glb", "no model");
  assert.match(await told(), /bad\.glb/);
  assert.ok((await directions(page)).length > 0, "the document stays");
  await page.close();
  void folder;
}

export async function tabsHaveTheirOwnDocuments({ browser, server }) {
  const [one, other] = [await open(browser, server.address), await open(browser, server.address)];
  await one.page.bringToFront();
  await calm(one.page);
  const before = await directions(one.page);
  await other.page.bringToFront();
  await calm(other.page);
  await drag(other.page, await middle(other.page, '[data-light="0"]'), [50, 50]);
  await atRest(other.page);
  assert.deepEqual(await directions(one.page), before);
  assert.notDeepEqual(await directions(other.page), before);
  assert.deepEqual([...one.errors, ...other.errors], []);
  await one.page.close();
  await other.page.close();
}

export async function aTabThatIsLoadedAgainGoesOn({ browser, server }) {
  const { page, errors } = await open(browser, server.address);
  await calm(page);
  await drag(page, await middle(page, '[data-light="0"]'), [45, 40]);
  await atRest(page);
  const before = [await score(page), await directions(page)];
  await page.reload();
  await atRest(page);
  assert.deepEqual([await score(page), await directions(page)], before);
  assert.equal(await state(page), "idle", "no search begins by itself");
  assert.deepEqual(errors, []);
  await page.close();
}

export async function aWrongTokenIsRefused({ browser, server }) {
  const wrong = new URL(server.address);
  wrong.searchParams.set("token", "wrong");
  for (const address of [wrong.href, `${wrong.origin}/`]) {
    const { page } = await open(browser, address);
    await page.waitForSelector(".refused", { timeout: WAIT });
    assert.equal(await page.$(".desk"), null);
    await page.close();
  }
}

export async function aServerThatComesBackGetsTheDocument({ browser, program, model, shadowed }) {
  const token = { KLIEG_STUDIO_TOKEN: "a-token-for-the-browser-tests" };
  const first = await serve(program, [model, ...shadowed], token);
  const { port } = new URL(first.address);
  const { page } = await open(browser, first.address);
  let second;
  try {
    await calm(page);
    await drag(page, await middle(page, '[data-light="0"]'), [-40, 70]);
    await atRest(page);
    const before = [await score(page), await directions(page)];
    await first.stop();
    await page.waitForSelector("[data-lost]", { timeout: WAIT });
    second = await serve(program, [model, ...shadowed, "--port", port], token);
    await page.waitForSelector("[data-lost]", { hidden: true, timeout: WAIT });
    await atRest(page);
    assert.deepEqual(await directions(page), before[1]);
    await drag(page, await middle(page, '[data-light="0"]'), [40, -70]);
    await atRest(page);
    assert.notDeepEqual(await directions(page), before[1]);
    await page.click('[aria-label="Undo"]');
    await atRest(page);
    assert.equal(await score(page), before[0]);
  } finally {
    await page.close();
    await first.stop();
    await second?.stop();
  }
}
