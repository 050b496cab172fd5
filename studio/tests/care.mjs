// What does not show at once: accessibility, layouts, latency, memory.
import assert from "node:assert/strict";
import { atRest, calm, circle, memory, open, pause, quantile, violations } from "./support.mjs";

export async function axeFindsNothing({ browser, server }) {
  const { page } = await open(browser, server.address);
  await calm(page);
  await page.select(".compare select", "headlight");
  await page.waitForSelector(".wiper");
  await page.click('.segments [value="rim"]');
  await page.click('.panel-head [aria-pressed="false"]');
  await page.click('[aria-expanded][class="link"]');
  for (const scheme of ["light", "dark"]) {
    await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
    await pause(250);
    assert.deepEqual(await violations(page), [], scheme);
    await page.click('[aria-label="Save"]');
    await page.waitForSelector("dialog[open]");
    assert.deepEqual(await violations(page), [], `${scheme}, dialog`);
    await page.keyboard.press("Escape");
    await page.waitForSelector("dialog[open]", { hidden: true });
  }
  await page.close();
}

export async function nothingIsCutOffFrom390To3840Pixels({ browser, server, folder }) {
  const { page, errors } = await open(browser, server.address);
  await calm(page);
  for (const [width, height] of [[390, 844], [768, 1024], [1280, 800], [3840, 2160]]) {
    await page.setViewport({ width, height });
    await pause(80);
    await atRest(page);
    for (const scheme of ["light", "dark"]) {
      await page.emulateMediaFeatures([{ name: "prefers-color-scheme", value: scheme }]);
      const wrong = await page.evaluate(() => {
        const root = document.documentElement;
        const faults = root.scrollWidth > root.clientWidth ? ["the page scrolls sideways"] : [];
        const seen = document.querySelector(".picture[role=application]").getBoundingClientRect();
        if (Math.min(seen.width, seen.height) < 250) faults.push(`the picture is ${seen.width} by ${seen.height}`);
        for (const element of document.querySelectorAll("button, select, .handle, output, h2, .segments label")) {
          const { left, right, width } = element.getBoundingClientRect();
          if (width > 0 && (left < -1 || right > root.clientWidth + 1)) faults.push(`${element.className || element.tagName} at ${left}..${right}`);
        }
        return faults;
      });
      assert.deepEqual(wrong, [], `${width}, ${scheme}`);
      await page.screenshot({ path: `${folder}/studio-${width}-${scheme}.png` });
    }
  }
  assert.deepEqual(errors, []);
  await page.close();
}

export async function allIsReachedByKeysAlone({ browser, server }) {
  const { page } = await open(browser, server.address);
  await calm(page);
  // So that there is something to undo.
  await page.focus('[data-light="0"]');
  await page.keyboard.press("ArrowLeft");
  const wanted = ["Undo", "Save", "orbit", "picture", "handle", "Intensity of", "Lock", "Weight of", "Target for", "Start the search|Go on|Search again", "Find"];
  const seen = [];
  let ends = 0;
  for (let count = 0; count < 160; count++) {
    await page.keyboard.press("Tab");
    const at = await page.evaluate(() => {
      const element = document.activeElement;
      const outline = getComputedStyle(element.closest("label") ?? element).outlineStyle;
      const own = getComputedStyle(element).outlineStyle;
      return { name: [element.getAttribute("aria-label"), element.className, element.value, element.textContent.slice(0, 40)].join(" "), ring: outline !== "none" || own !== "none", body: element === document.body };
    });
    // Behind the last stop comes the first.
    if (at.body && ++ends === 2) break;
    if (at.body) continue;
    assert.ok(at.ring, `the focus is seen on ${at.name}`);
    seen.push(at.name);
  }
  for (const name of wanted) assert.ok(seen.some((text) => new RegExp(name).test(text)), `${name} among ${seen.length} stops`);
  await page.close();
}

/** Follows the draws of a page: how many are sent at once without a picture yet, at most. */
async function watch(page) {
  const waiting = new Set();
  const seen = { most: 0 };
  const client = await page.createCDPSession();
  await client.send("Network.enable");
  client.on("Network.webSocketFrameSent", ({ response: { opcode, payloadData } }) => {
    const message = opcode === 1 ? JSON.parse(payloadData) : {};
    if (message.type === "draw") waiting.add(message.id);
    seen.most = Math.max(seen.most, waiting.size);
  });
  client.on("Network.webSocketFrameReceived", ({ response: { opcode, payloadData } }) => {
    if (opcode !== 2) return;
    // A newer request takes the place of older ones, whose pictures do not come.
    const answered = Buffer.from(payloadData.slice(0, 16), "base64").readUInt32LE(4);
    for (const id of waiting) if (id <= answered) waiting.delete(id);
  });
  return seen;
}

export async function aDragShowsItsPictureSoon({ browser, server }) {
  const { page, errors } = await open(browser, server.address);
  await calm(page);
  const draws = await watch(page);
  await page.evaluate(() => performance.clearMeasures());
  await circle(page, 100);
  const times = await page.evaluate(() => performance.getEntriesByName("drag").map(({ duration }) => duration).sort((a, b) => a - b));
  assert.ok(times.length > 20, `${times.length} pictures`);
  const [median, late] = [quantile(times, 0.5), quantile(times, 0.95)];
  // Slow machines draw slowly; what queues is later by far.
  assert.ok(draws.most >= 1 && draws.most <= 2, `${draws.most} draws at once`);
  assert.ok(median < 1000, `median ${median} ms`);
  assert.deepEqual(errors, []);
  await page.close();
  return `from pointer to picture: median ${median.toFixed(0)} ms, p95 ${late.toFixed(0)} ms, ${times.length} pictures of 100 moves`;
}

export async function memoryStaysFlat({ browser, server, drags = Number(process.env.KLIEG_STUDIO_MOVES ?? 240) }) {
  const { page, errors } = await open(browser, server.address);
  await calm(page);
  const client = await page.createCDPSession();
  await circle(page, 60, 4);
  const before = await memory(client);
  await circle(page, drags, 4);
  const after = await memory(client);
  assert.ok(after - before < 8, `${before.toFixed(1)} MB, then ${after.toFixed(1)} MB`);
  assert.deepEqual(errors, []);
  await page.close();
  return `${before.toFixed(1)} MB, ${after.toFixed(1)} MB after ${drags} more moves`;
}
