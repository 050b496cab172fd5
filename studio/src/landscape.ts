// The landscape of F: how good the chosen light would be in every direction.
import { effect, signal } from "@preact/signals";
import { chosen, doc, look } from "./document";
import type { Document, Mapped } from "./messages";
import { connection, listen, send } from "./socket";

/** Cells along a side of the map, while things change and once they stand still. */
const CELLS = { moving: 25, still: 49 };
/** Least time between two maps, and stillness after which the finer one is asked for, milliseconds. */
const PAUSE = { moving: 120, still: 450 };
/** The map waits this many times as long as the last one took, so that pictures and searches have most of the machine. */
const SHARE = 2;
const PATIENCE = 10_000;

export const landscape = signal<Mapped | null>(null);
/** Whether the map is of the lights as they stand. */
export const outdated = signal(false);
/** Whether a map is wanted at all. */
export const wanted = signal(true);

let inFlight = 0;
let sentAt = 0;
/** From when on another map may be asked for. */
let due = 0;
let timer = 0;
let coarse = "";
let fine = "";
let latest: { document: Document; index: number; key: string; changed: number } | null = null;

/** What the map depends on: all but where the chosen light stands, and what only people see. */
function keyOf(document: Document, index: number): string {
  const lights = document.lights.map((light, other) => {
    const { locked: _, ...seen } = light;
    return other === index ? { ...seen, direction: null } : seen;
  });
  const { camera, weights, targets, intent, focus, dim, size, scene } = document;
  return JSON.stringify([index, lights, camera, weights, targets, intent.below, focus, dim, size, scene]);
}

export function beginMapping() {
  effect(() => {
    if (connection.value === "open") forget();
  });
  effect(() => {
    const document = doc.value;
    if (!document || !wanted.value || document.lights.length === 0) {
      latest = null;
      landscape.value = null;
      return;
    }
    const key = keyOf(document, chosen.value);
    const changed = key === latest?.key ? latest.changed : performance.now();
    latest = { document, index: chosen.value, key, changed };
    outdated.value = key !== coarse && key !== fine;
    pump();
  });
  listen("mapped", (answer) => {
    if (answer.id !== inFlight) return;
    inFlight = 0;
    const now = performance.now();
    due = Math.max(sentAt + PAUSE.moving, now + SHARE * (now - sentAt));
    if (answer.light === latest?.index) landscape.value = answer;
    outdated.value = latest?.key !== coarse && latest?.key !== fine;
    pump();
  });
}

function forget() {
  inFlight = 0;
  coarse = fine = "";
  pump();
}

/** Asks for the next map, if one is due. */
function pump() {
  clearTimeout(timer);
  if (!latest || latest.key === fine || connection.peek() !== "open") return;
  const now = performance.now();
  const later = (time: number) => {
    timer = window.setTimeout(pump, Math.max(1, time - now));
  };
  if (inFlight && now < sentAt + PATIENCE) return later(sentAt + PATIENCE);
  if (now < due) return later(due);
  if (latest.key !== coarse) return request(CELLS.moving);
  if (now < latest.changed + PAUSE.still) return later(latest.changed + PAUSE.still);
  request(CELLS.still);
}

function request(cells: number) {
  if (!latest) return;
  const { document, index, key } = latest;
  inFlight = send({ type: "map", light: index, columns: cells, rows: cells, size: document.size, ...look(document) });
  sentAt = performance.now();
  if (cells === CELLS.still) fine = key;
  coarse = key;
}

/** A map that failed is not asked for again until something changes. */
export function mapFailed(id: number | null) {
  if (id !== null && id === inFlight) inFlight = 0;
}
