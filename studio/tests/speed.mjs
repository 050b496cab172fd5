// How soon the page of a built klieg answers: node speed.mjs CHROMIUM KLIEG MODEL [OPTION ...]
// Options are those of `klieg studio`. KLIEG_STUDIO_MOVES is the number of moves over which memory is watched (10,000).
import { browse, calm, circle, memory, middle, open, pause, quantile, serve, WAIT } from "./support.mjs";

/** Fineness of a picture in its header: drawn small, as it is judged, at rest. */
const FULL = 1;

const [chromium, program, model, ...options] = process.argv.slice(2);
const moves = Number(process.env.KLIEG_STUDIO_MOVES ?? 10_000);

/** Notes in the page what it asks for, and which pictures come, before the page takes them. */
function notePictures() {
  window.pictures = [];
  window.asked = {};
  const Socket = window.WebSocket;
  window.WebSocket = class extends Socket {
    constructor(address) {
      super(address);
      window.asked.address = address;
      this.addEventListener("message", ({ data }) => {
        if (!(data instanceof ArrayBuffer)) return;
        const head = new DataView(data);
        const [width, , kind, , fineness, micros] = [2, 3, 4, 5, 6, 7].map((word) => head.getUint32(4 * word, true));
        if (kind === 0) window.pictures.push({ at: performance.now(), width, fineness, drawn: micros / 1000 });
      });
    }
    send(text) {
      const request = JSON.parse(text);
      window.asked[request.type] = request;
      super.send(text);
    }
  };
}

/** What a change brings until `done`, a function in the page, says yes: pictures with milliseconds after its beginning. */
async function picturesOf(page, act, done = () => true) {
  const begin = await page.evaluate(() => {
    window.pictures = [];
    return performance.now();
  });
  await act();
  await page.waitForFunction(done, { timeout: WAIT });
  const seen = await page.evaluate(() => window.pictures);
  return seen.map((picture) => ({ ...picture, at: picture.at - begin }));
}

/** Pictures a second that the server draws for a page that shows nothing, each with its first light changed a little. */
function bareRate({ address, open, draw }, seconds) {
  const link = new WebSocket(address);
  link.binaryType = "arraybuffer";
  let [id, count, begin] = [10, 0, 0];
  const next = () => {
    const lights = draw.lights.map((light, index) => (index > 0 ? light : { ...light, diffuse: light.diffuse * (1 + 0.001 * (id % 9)) }));
    link.send(JSON.stringify({ ...draw, id: id++, at_rest: false, lights }));
  };
  return new Promise((resolve, reject) => {
    link.onclose = ({ code, reason }) => reject(new Error(`the server ends with ${code}: ${reason}`));
    link.onopen = () => link.send(JSON.stringify({ ...open, id: id++ }));
    link.onmessage = ({ data }) => {
      const now = performance.now();
      if (typeof data === "string") {
        const { type, quality } = JSON.parse(data);
        if (type === "opened") next();
        if (type !== "judged") return;
        if (begin === 0 && quality === 1) begin = now;
        if (begin > 0) count += 1;
        if (begin > 0 && now > begin + 1000 * seconds) resolve((1000 * (count - 1)) / (now - begin));
        else if (begin > 0) next();
      }
    };
  });
}

/** Drags a light in circles as a hand does: a move every 16 ms, whatever the page makes of it. */
async function hand(page, moves) {
  const [x, y] = await middle(page, '[data-light="0"]');
  const disc = await middle(page, ".disc");
  await page.mouse.move(x, y);
  await page.mouse.down();
  const sent = [];
  const begin = performance.now();
  for (let move = 0; move < moves; move++) {
    sent.push(page.mouse.move(disc[0] + 60 * Math.cos(move / 18), disc[1] + 60 * Math.sin(move / 18)));
    await pause(16);
  }
  await Promise.all(sent);
  const time = performance.now() - begin;
  await page.mouse.up();
  return time;
}

const sorted = (values) => [...values].sort((a, b) => a - b);
const spread = (values) => `median ${quantile(sorted(values), 0.5).toFixed(0)}, p95 ${quantile(sorted(values), 0.95).toFixed(0)} ms`;

const browser = await browse(chromium);
const server = await serve(program, [model, ...options]);
try {
  const begin = performance.now();
  const { page, errors } = await open(browser, server.address, { before: notePictures });
  await page.waitForSelector(".frame .picture[role=application] > canvas", { timeout: WAIT });
  console.log(`page with a picture after ${(performance.now() - begin).toFixed(0)} ms`);
  await calm(page);

  for (let round = 0; round < 3; round++) {
    await page.evaluate(() => performance.clearMeasures());
    let time = 0;
    const seen = await picturesOf(page, async () => {
      time = await hand(page, 200);
    });
    const waits = await page.evaluate(() => performance.getEntriesByName("drag").map(({ duration }) => duration));
    const full = seen.filter(({ fineness }) => fineness >= FULL);
    console.log(
      `drag of a light: ${((1000 * seen.length) / time).toFixed(1)} pictures/s, of which whole ${((1000 * full.length) / time).toFixed(1)}; ` +
        `pointer to picture ${spread(waits)}; drawn in ${spread(seen.map(({ drawn }) => drawn))}`,
    );
    await calm(page);
  }

  const turns = [];
  for (let turn = 0; turn < 7; turn++) {
    await page.focus(".picture[role=application]");
    const judged = () => window.pictures.some(({ fineness }) => fineness >= 1);
    const seen = await picturesOf(page, () => page.keyboard.press("ArrowLeft"), judged);
    const size = Math.max(...seen.map(({ width }) => width));
    turns.push([seen[0], seen.find(({ width }) => width === size), seen.find(({ fineness }) => fineness >= FULL)]);
    await calm(page);
  }
  const [first, sized, judged] = [0, 1, 2].map((which) => spread(turns.map((turn) => turn[which].at)));
  console.log(`new view: first picture ${first}; in full size ${sized}; with all directions of its shadow table ${judged}`);

  const asked = await page.evaluate(() => window.asked);
  const bare = await browser.newPage();
  await bare.setBypassCSP(true);
  await bare.goto(new URL("icon.svg", server.address).href);
  console.log(`for a page that shows nothing: ${(await bare.evaluate(bareRate, asked, 4)).toFixed(1)} pictures/s`);
  await bare.close();

  if (moves > 0) {
    const client = await page.createCDPSession();
    await circle(page, 200, 4);
    const before = await memory(client);
    await circle(page, moves, 4);
    console.log(`memory of the page: ${before.toFixed(1)} MB, ${(await memory(client)).toFixed(1)} MB after ${moves} more moves`);
  }
  if (errors.length > 0) throw new Error(errors.join("\n"));
} finally {
  await browser.close();
  await server.stop();
}
