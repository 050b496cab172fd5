// The pictures: which is asked for next, and what has come. At most one is on its way; while things move, only the newest
// state is drawn after it.
import { computed, effect, signal } from "@preact/signals";
import { doc, look } from "./document";
import { judgedAs } from "./history";
import type { Document, Judged, Light } from "./messages";
import { say } from "./notices";
import { connection, listen, send, type Picture } from "./socket";

export type Side = "main" | "other";
/** A picture on the page. */
export type Shown = { image: ImageData; quality: number; milliseconds: number };

/** Stillness after which the final picture is asked for, milliseconds. */
const REST = 220;
/** Time after which a picture that has not come is given up, milliseconds: one in motion, and a final one. */
const PATIENCE = { moving: 10_000, rest: 120_000 };
/** Most pixels of a final picture. */
const MOST_PIXELS = 1_300_000;
/** Quality of final pictures. */
const FINAL = 2;

const SIDES: Side[] = ["main", "other"];

export const pictures = { main: signal<Shown | null>(null), other: signal<Shown | null>(null) };
export const judged = { main: signal<Judged | null>(null), other: signal<Judged | null>(null) };
/** The lights that the picture is compared with. */
export const otherLights = signal<Light[] | null>(null);
/** Width of the picture on the screen, device pixels. */
export const shownWidth = signal(0);
/** Whether the final picture of the document stands. */
export const standing = signal(false);
/** Pictures of the last second. */
export const rate = signal(0);

type Wanted = { document: Document | null; drawn: Document | null; rested: Document | null; changed: number };

const nothing = (): Wanted => ({ document: null, drawn: null, rested: null, changed: 0 });
const wanted: Record<Side, Wanted> = { main: nothing(), other: nothing() };
/** The draws whose pictures are still of interest. */
const asked = new Map<number, { side: Side; document: Document; moved: number }>();
let flight: { id: number; atRest: boolean; since: number } | null = null;
let timer = 0;
let moved = 0;
const shownAt: number[] = [];

/** Size of the final picture: as many pixels as the window shows, within bounds. */
const restSize = computed<[number, number] | null>(() => {
  if (!doc.value) return null;
  const [width, height] = doc.value.size;
  const most = Math.sqrt((MOST_PIXELS * width) / height);
  const across = Math.round(Math.min(most, Math.max(width, shownWidth.value)));
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
    if (draw.side === "main" && answer.quality > 0) settled(draw.document, answer.score);
  });
}

/** What was on its way when the connection was lost will not come. */
function drawAnew() {
  flight = null;
  asked.clear();
  for (const side of SIDES) wanted[side].drawn = wanted[side].rested = null;
  standing.value = false;
  pump();
}

function redrawFinal() {
  for (const side of SIDES) wanted[side].rested = null;
  standing.value = false;
  pump();
}

function want(side: Side, document: Document | null) {
  const state = wanted[side];
  if (same(state.document, document)) return;
  state.document = document;
  state.changed = performance.now();
  standing.value = false;
  if (!document) pictures[side].value = judged[side].value = null;
  pump();
}

/** Whether both look the same: the compared lights stand still while those of the document are dragged. */
function same(a: Document | null, b: Document | null) {
  if (!a || !b) return a === b;
  const keys = ["camera", "lights", "weights", "targets", "size", "scene"] as const;
  return keys.every((key) => a[key] === b[key]);
}

const isDirty = (side: Side) => wanted[side].document !== null && wanted[side].document !== wanted[side].drawn;

/** Sends the next draw, if one is due. */
function pump() {
  clearTimeout(timer);
  if (connection.peek() !== "open") return;
  const dirty = SIDES.find(isDirty);
  const now = performance.now();
  // A final picture may take long; whatever moves meanwhile is drawn at once.
  if (flight && !(flight.atRest && dirty)) {
    const patience = flight.since + (flight.atRest ? PATIENCE.rest : PATIENCE.moving) - now;
    if (patience > 0) {
      timer = window.setTimeout(pump, patience);
      return;
    }
  }
  if (dirty) return draw(dirty, false);
  const restless = SIDES.find((side) => wanted[side].document !== wanted[side].rested);
  if (!restless) return;
  const wait = Math.max(wanted.main.changed, wanted.other.changed) + REST - now;
  if (wait <= 0) draw(restless, true);
  else timer = window.setTimeout(pump, wait + 1);
}

function draw(side: Side, atRest: boolean) {
  const { document } = wanted[side];
  if (!document) return;
  const rest = atRest ? restSize.peek() : null;
  const id = send({ type: "draw", size: document.size, at_rest: atRest, rest, ...look(document) });
  if (!id) return;
  wanted[side].drawn = document;
  if (atRest) wanted[side].rested = document;
  for (const [old, { side: drawn }] of asked) if (drawn === side) asked.delete(old);
  asked.set(id, { side, document, moved: side === "main" ? moved : 0 });
  if (side === "main") moved = 0;
  flight = { id, atRest, since: performance.now() };
}

/** Takes a picture of the server's. */
export function drawn({ id, image, quality, milliseconds }: Picture) {
  const draw = asked.get(id);
  if (!draw) return;
  pictures[draw.side].value = { image, quality, milliseconds };
  if (draw.moved) measure(draw.moved);
  draw.moved = 0;
  count();
  if (flight?.id !== id || (flight.atRest && quality < FINAL)) return;
  const { atRest } = flight;
  flight = null;
  standing.value = atRest && SIDES.every((side) => wanted[side].document === wanted[side].rested);
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
  if (id === null || !asked.delete(id)) return;
  if (flight?.id === id) flight = null;
  pump();
}
