// Clicks on the model: where a light's highlight, brightest shading or rim shall fall, and what the camera turns about.
import { signal } from "@preact/signals";
import { chosen, doc, ofLight, scene } from "./document";
import { edit } from "./history";
import { axes, scaled, sum, toWorld } from "./math";
import type { What } from "./messages";
import { complain, say } from "./notices";
import { ask, Gone } from "./socket";

export type Tool = "orbit" | What;
/** A point of the picture: shares of its width and height from the left and the top. */
export type Point = [number, number];

export const TOOLS: { tool: Tool; title: string; hint: string }[] = [
  { tool: "orbit", title: "Orbit", hint: "Drag to orbit, scroll to zoom, Shift-drag to pan" },
  { tool: "highlight", title: "Highlight", hint: "Click where the chosen light's highlight shall fall" },
  { tool: "shading", title: "Shading", hint: "Click where the chosen light's shading shall be brightest" },
  { tool: "rim", title: "Rim", hint: "Click the edge that the chosen light shall graze from behind" },
];

export const tool = signal<Tool>("orbit");
/** Where a light was placed last; `hit` tells whether there was an object. */
export const placed = signal<{ point: Point; hit: boolean } | null>(null);

let busy = false;
let next: { point: Point; what: What; done: () => void } | null = null;

/** Places the chosen light. Only the newest point waits while one is on its way; `done` is called once it stands. */
export async function place(point: Point, what: What, done: () => void = () => {}) {
  if (busy) {
    next = { point, what, done };
    return;
  }
  busy = true;
  try {
    await placeNow(point, what);
    done();
  } catch (error) {
    if (!(error instanceof Gone)) complain(error);
  } finally {
    busy = false;
  }
  const following = next;
  next = null;
  if (following) await place(following.point, following.what, following.done);
}

async function placeNow(point: Point, what: What) {
  const document = doc.value;
  const light = chosen.value;
  if (!document?.lights[light]) return;
  const { size, camera, lights } = document;
  const answer = await ask({ type: "place", light, what, pixel: pixelOf(point, size), size, camera, lights });
  placed.value = { point, hit: answer.type === "placed" };
  if (answer.type !== "placed") return say("There is no object at this place.");
  edit(ofLight(answer.light, (old) => ({ ...answer.lit, locked: old.locked })));
}

const pixelOf = ([x, y]: Point, [width, height]: [number, number]): Point => [x * width, y * height];

/** Turns the camera's target to what is seen at a point. */
export async function lookAt(point: Point): Promise<boolean> {
  const document = doc.value;
  const info = scene.value;
  if (!document || !info) return false;
  const { size, camera } = document;
  try {
    const answer = await ask({ type: "pick", pixel: pixelOf(point, size), size, camera });
    if (answer.type !== "picked" || !answer.position) return false;
    const { position } = answer;
    const target = sum(info.center, scaled(toWorld(position, axes(camera)), info.radius));
    edit((now) => ({ ...now, camera: { ...now.camera, target, named: null } }));
    return true;
  } catch (error) {
    if (!(error instanceof Gone)) complain(error);
    return false;
  }
}
