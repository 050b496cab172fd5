// Moving the camera. Lights stay where they are in the scene, or go with the camera.
import { signal } from "@preact/signals";
import { doc, scene } from "./document";
import { edit } from "./history";
import { intoAxes } from "./light";
import { axes, clamp, scaled, sum, wrapped } from "./math";
import type { Camera, Document } from "./messages";
import { ask, Gone } from "./socket";
import { complain } from "./notices";

const DISTANCE = { least: 0.2, most: 50 };

/** Whether lights go with the camera. */
export const lightsFollow = signal(false);

/** The document, seen by another camera. */
function seenBy(document: Document, camera: Camera): Document {
  if (lightsFollow.peek()) return { ...document, camera };
  const [from, to] = [axes(document.camera), axes(camera)];
  return { ...document, camera, lights: document.lights.map((light) => intoAxes(light, from, to)) };
}

function move(change: (camera: Camera) => Camera) {
  edit((document) => seenBy(document, { ...change(document.camera), named: null }));
}

/** Turns about the target, degrees. */
export function orbit(right: number, up: number) {
  move((camera) => ({
    ...camera,
    azimuth: wrapped(camera.azimuth + right),
    elevation: clamp(camera.elevation + up, -89.5, 89.5),
  }));
}

/** Nearer by a factor below 1, farther by one above. */
export function zoom(factor: number) {
  move((camera) => ({ ...camera, distance: clamp(camera.distance * factor, DISTANCE.least, DISTANCE.most) }));
}

/** Moves the target, in picture heights to the right and upwards. */
export function pan(right: number, up: number) {
  const radius = scene.value?.radius ?? 1;
  move((camera) => {
    const [x, y] = axes(camera);
    const height = 2 * camera.distance * radius * Math.tan((camera.yfov * Math.PI) / 360);
    const shift = sum(scaled(x, -right * height), scaled(y, -up * height));
    return { ...camera, target: sum(camera.target, shift) };
  });
}

/** Looks through another camera; `follow` tells the lights in its axes. */
export async function lookThrough(camera: Camera): Promise<boolean> {
  const document = doc.value;
  if (!document) return false;
  if (lightsFollow.value) {
    edit((now) => ({ ...now, camera }));
    return true;
  }
  try {
    const { camera: from, lights } = document;
    const answer = await ask({ type: "follow", from, to: camera, lights });
    if (answer.type === "rig") edit((now) => ({ ...now, camera, lights: answer.lights }));
    return answer.type === "rig";
  } catch (error) {
    if (!(error instanceof Gone)) complain(error);
    return false;
  }
}

/** Back to the scene's first view. */
export const home = () => (scene.value ? lookThrough(scene.value.camera) : Promise.resolve(false));
