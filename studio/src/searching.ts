// The search: what it is told, and how it goes.
import { signal } from "@preact/signals";
import { doc, look } from "./document";
import { commit, edit } from "./history";
import type { Action, Light, Progress } from "./messages";
import { say } from "./notices";
import { listen, send } from "./socket";

export type State = "idle" | "running" | "paused" | "finished";
/** A point of the curve; `fresh` begins a new line, as scores of other pictures or lights cannot be compared. */
export type Point = { evaluations: number; best: number; fresh: boolean };

const MOST_POINTS = 600;
/** No F is above this. */
const WORST = 1e6;

export const state = signal<State>("idle");
export const progress = signal<Progress | null>(null);
export const curve = signal<Point[]>([]);
/** Whether lights were moved by hand since the search was last told something. */
export const touched = signal(false);

/** Number of the last request. */
let request = 0;
/** Evaluations of the runs before this one. */
let before = 0;
let small = false;
/** Whether the last that was asked for is one generation. */
let stepping = false;

export function beginSearching() {
  listen("progress", (answer) => {
    // A search that was told something else may have had an answer on its way.
    if (answer.id !== request || state.value === "idle") return;
    // A step begins as every search does.
    if (stepping && answer.running) return;
    follow(answer);
  });
}

function follow(answer: Progress) {
  const points = curve.value;
  const last = points.at(-1);
  const again = answer.evaluations < (progress.value?.evaluations ?? 0);
  if (again) before = last?.evaluations ?? 0;
  // The best of a search only falls, unless it is judged anew in other pictures.
  const fresh = !last || again || small !== answer.small || answer.best > last.best + 1e-6;
  small = answer.small;
  const point = { evaluations: before + answer.evaluations, best: answer.best, fresh };
  // Before the first generation there is no best one.
  if (answer.best < WORST) curve.value = thinned([...points, point]);
  progress.value = answer;
  show(answer.lights);
  if (answer.finished) end();
  else if (!answer.running) {
    state.value = "paused";
    if (!touched.value) commit(stepping ? "Search, a step" : "Search, paused", "search");
  }
}

/** Shows the best lights; what is locked and who is who stay the page's. */
function show(lights: Light[]) {
  if (touched.value) return;
  edit((document) => {
    const same = lights.length === document.lights.length;
    return { ...document, lights: same ? lights.map((light, i) => ({ ...light, locked: document.lights[i]!.locked })) : lights };
  });
}

function end() {
  state.value = "finished";
  commit("Search");
  say(`The search has ended. F ${progress.value?.best.toFixed(4) ?? ""}`);
}

/** Keeps every other point of a long curve, and all where a line begins. */
function thinned(points: Point[]): Point[] {
  if (points.length <= MOST_POINTS) return points;
  return points.filter((point, index) => point.fresh || index % 2 === 0 || index === points.length - 1);
}

function tell(action: Action) {
  const document = doc.value;
  if (!document) return;
  request = send({ type: "search", action, size: document.size, optimizer: null, seed: null, ...look(document) });
}

export function start() {
  if (state.value !== "paused") clear();
  touched.value = false;
  stepping = false;
  state.value = "running";
  tell("start");
  say("The search runs.");
}

export function step() {
  if (state.value !== "paused") clear();
  touched.value = false;
  stepping = true;
  state.value = "paused";
  tell("step");
}

/** Waits, and makes a step of the history of what was found. */
export function pause() {
  if (state.value !== "running") return;
  state.value = "paused";
  stepping = false;
  tell("pause");
  commit("Search, paused", "search");
  say("The search waits.");
}

export function stop() {
  if (state.value === "idle") return;
  tell("stop");
  state.value = "idle";
  commit("Search");
}

/** To be called before anything is changed by hand: the search waits, and goes on from there when told to. */
export function interrupt() {
  pause();
  if (state.value === "paused") touched.value = true;
}

/** Another scene or a new connection: there is no search. */
export function forget() {
  if (state.value === "running") commit("Search, broken off");
  state.value = "idle";
  touched.value = false;
}

function clear() {
  curve.value = [];
  progress.value = null;
  before = 0;
}
