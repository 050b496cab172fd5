// The pictures: which is asked for next, and what has come. At most one is on its way; while things move, only the newest
// state is drawn after it.
import { computed, effect, signal } from "@preact/signals";
import { doc, look } from "./document";
import { judgedAs } from "./history";
import type { Document, Fineness, Judged, Light } from "./messages";
import { say } from "./notices";
import { connection, listen, send, type Picture } from "./socket";

export type Side = "main" | "other";
/** A picture on the page. */
export type Shown = { image: ImageData; quality: number; milliseconds: number };

/** Stillness after which a picture of that quality is asked for, milliseconds. */
const STILL: Record<Fineness, number> = { 0: 0, 1: 80, 2: 220 };
/** Time after which a picture of that quality that has not come is given up, milliseconds. */
const PATIENCE: Record<Fineness, number> = { 0: 10_000, 1: 120_000, 2: 300_000 };
/** Most pixels of a final picture. */
const MOST_PIXELS = 1_300_000;
/** Steps in which its width follows the window's, pixels. */
const COARSENESS = 64;
const FULL = 1;
const FINAL = 2;

const SIDES: Side[] = ["main", "other"];

export const pictures = { main: signal<Shown | null>(null), other: signal<Shown | null>(null) };
export const judged = { main: signal<Judged | null>(null), other: signal<Judged | null>(null) };
/** The lights that the picture is compared with. */
export const otherLights = signal<Light[] | null>(null);
/** Width of the picture on the screen, device pixels. */
export const shownWidth = signal(0);
/** Whether the picture of the document stands as it is judged. */
export const standing = signal(false);
/** Pictures of the last second. */
export const rate = signal(0);

/** What a side shall show, of which document pictures have come (of quality 0: have been asked for), and which is seen. */
type Wanted = {
  document: Document | null;
  shown: Record<Fineness, Document | null>;
  seen: { document: Document; quality: Fineness } | null;
  changed: number;
};

const nothing = (): Wanted => ({ document: null, shown: { 0: null, 1: null, 2: null }, seen: null, changed: 0 });
const wanted: Record<Side, Wanted> = { main: nothing(), other: nothing() };
/** The draws whose pictures are still of interest. */
const asked = new Map<number, { side: Side; document: Document; moved: number }>();
/** The last draw, until a picture of the quality that it was for has come. */
let flight: { id: number; quality: Fineness; since: number } | null = null;
let timer = 0;
let moved = 0;
const shownAt: number[] = [];

/** Size of the final picture: about as many pixels as the window shows, within bounds. */
const restSize = computed<[number, number] | null>(() => {
  if (!doc.value) return null;
  const [width, height] = doc.value.size;
  const most = Math.sqrt((MOST_PIXELS * width) / height);
  const across = Math.round(Math.min(most, Math.max(width, COARSENESS * Math.ceil(shownWidth.value / COARSENESS))));
  return [across, Math.round((across * height) / width)];
});

/** Remembers when the pointer moved, so that the time until the picture stands can be measured. */
export function pointerMoved(event: Event) {
  moved = event.timeStamp;
}

/** Begins to draw whatever the document becomes. */
export function beginDrawing() {
  effect(() => want("main", doc.value));
  effect(() => want("other", doc.value && otherLights.value && { ...doc.value, lights: otherLights.value }));
  effect(() => {
    if (connection.value === "open") drawAnew();
  });
  effect(() => {
    if (restSize.value) redrawFinal();
  });
  listen("judged", (answer) => {
    const draw = asked.get(answer.id);
    if (!draw) return;
    judged[draw.side].value = answer;
    if (answer.quality < FULL) return;
    wanted[draw.side].shown[FULL] = draw.document;
    if (draw.side === "main") settled(draw.document, answer.score);
    standing.value = !lacking(0) && !lacking(FULL);
    if (flight?.id === answer.id && flight.quality === FULL) flight = null;
    pump();
  });
}

/** What was on its way when the connection was lost will not come. */
function drawAnew() {
  flight = null;
  asked.clear();
  for (const side of SIDES) wanted[side].shown = nothing().shown;
  standing.value = false;
  pump();
}

function redrawFinal() {
  for (const side of SIDES) wanted[side].shown[FINAL] = null;
  pump();
}

function want(side: Side, document: Document | null) {
  const state = wanted[side];
  if (same(state.document, document)) return;
  state.document = document;
  state.changed = performance.now();
  standing.value = false;
  if (!document) pictures[side].value = judged[side].value = state.seen = null;
  pump();
}

/** Whether both look the same: the compared lights stand still while those of the document are dragged. */
function same(a: Document | null, b: Document | null) {
  if (!a || !b) return a === b;
  const keys = ["camera", "lights", "weights", "targets", "focus", "dim", "size", "scene"] as const;
  return keys.every((key) => a[key] === b[key]);
}

/** The first side without a picture of that quality of what it shall show. */
const lacking = (quality: Fineness) =>
  SIDES.find((side) => wanted[side].document && wanted[side].document !== wanted[side].shown[quality]);

/** Sends the next draw, if one is due: what has changed first, then whole pictures, then final ones. */
function pump() {
  clearTimeout(timer);
  if (connection.peek() !== "open") return;
  const now = performance.now();
  const quality = ([0, FULL, FINAL] as const).find((level) => lacking(level));
  if (quality === undefined) return;
  const later = (time: number) => {
    timer = window.setTimeout(pump, Math.max(1, time - now));
  };
  // Fine pictures may take long; whatever moves meanwhile is drawn at once.
  if (flight && !(flight.quality > 0 && quality === 0)) {
    const patience = flight.since + PATIENCE[flight.quality];
    if (now < patience) return later(patience);
  }
  const still = Math.max(wanted.main.changed, wanted.other.changed) + STILL[quality];
  if (now < still) later(still);
  else draw(lacking(quality)!, quality);
}

function draw(side: Side, quality: Fineness) {
  const { document, shown } = wanted[side];
  if (!document) return;
  const atRest = quality === FINAL;
  const rest = atRest ? restSize.peek() : null;
  const id = send({ type: "draw", size: document.size, at_rest: atRest, rest, ...look(document) });
  if (!id) return;
  if (shown[0] !== document) wanted[side].shown = { 0: document, 1: null, 2: null };
  for (const [old, { side: drawn }] of asked) if (drawn === side) asked.delete(old);
  asked.set(id, { side, document, moved: side === "main" ? moved : 0 });
  if (side === "main") moved = 0;
  flight = { id, quality, since: performance.now() };
}

/** Takes a picture of the server's. */
export function drawn({ id, image, quality, milliseconds }: Picture) {
  const draw = asked.get(id);
  if (!draw) return;
  const { side, document } = draw;
  const state = wanted[side];
  // A finer picture of the same stays.
  if (state.seen?.document !== document || quality >= state.seen.quality) {
    pictures[side].value = { image, quality, milliseconds };
    state.seen = { document, quality };
  }
  if (quality === FINAL) state.shown[FINAL] = document;
  if (draw.moved) measure(draw.moved);
  draw.moved = 0;
  count();
  // A whole picture is there for its judgement, which follows.
  if (flight?.id === id && flight.quality !== FULL && quality >= flight.quality) flight = null;
  pump();
}

/** Takes down, once the picture stands, how long after the pointer's movement that was. */
function measure(start: number) {
  requestAnimationFrame(() => {
    if (performance.getEntriesByName("drag").length > 1000) performance.clearMeasures("drag");
    performance.measure("drag", { start });
  });
}

function count() {
  const now = performance.now();
  shownAt.push(now);
  while (shownAt[0]! < now - 1000) shownAt.shift();
  rate.value = shownAt.length;
}

let speaking = 0;

function settled(document: Document, score: number) {
  judgedAs(document, score);
  clearTimeout(speaking);
  speaking = window.setTimeout(() => say(`F ${score.toFixed(4)}`), 600);
}

/** A draw that failed stands in nobody's way. */
export function drawFailed(id: number | null) {
  const draw = id === null ? undefined : asked.get(id);
  if (!draw || id === null) return;
  asked.delete(id);
  // It is not asked for again until something changes.
  const { side, document } = draw;
  wanted[side].shown = { 0: document, 1: document, 2: document };
  if (flight?.id === id) flight = null;
  pump();
}
