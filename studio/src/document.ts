// The document: what is edited, kept in the history, saved and sent to the server.
import { computed, signal } from "@preact/signals";
import { angles } from "./math";
import type { Document, Light, Look, Opened, SceneInfo } from "./messages";

export type Edit = (document: Document) => Document;

/** What the server said at the beginning; null before. */
export const opened = signal<Opened | null>(null);
export const scene = signal<SceneInfo | null>(null);
export const doc = signal<Document | null>(null);
/** The file that the scene came from, kept to hand it over again to a server that has lost it. */
export const file = signal<File | null>(null);

const chosenIndex = signal(0);

/** Index of the light that is worked on. */
export const chosen = computed(() => Math.min(chosenIndex.value, (doc.value?.lights.length ?? 1) - 1));

export const choose = (index: number) => {
  chosenIndex.value = index;
};

export const chosenLight = computed<Light | null>(() => doc.value?.lights[chosen.value] ?? null);

/** The part of a document that the server judges. */
export const look = ({ camera, lights, weights, targets, intent, focus, dim }: Document): Look => ({ camera, lights, weights, targets, intent, focus, dim });

/** Where a scene begins: at what a session kept, at the file's own lights, or at klieg's first ones. */
export function beginning(info: SceneInfo, { defaults }: Opened): Document {
  if (info.document) return { ...info.document, scene: info.id };
  const { camera, size } = info;
  const { weights, targets, intent, focus, dim } = defaults;
  const lights = info.lights.length > 0 ? info.lights : defaults.lights;
  return { scene: info.id, size, page: null, camera, lights, weights, targets, intent, focus, dim };
}

/** An edit of one light. */
export const ofLight =
  (index: number, change: (light: Light) => Light): Edit =>
  (document) => ({
    ...document,
    lights: document.lights.map((light, other) => (other === index ? change(light) : light)),
  });

/** Degrees of the chosen light, for people. */
export const chosenAngles = computed(() => chosenLight.value && angles(chosenLight.value.direction));

/** A size of about the same area with another shape, in even numbers. */
export function shaped([width, height]: [number, number], [across, down]: [number, number]): [number, number] {
  const unit = Math.sqrt((width * height) / (across * down));
  return [2 * Math.round((unit * across) / 2), 2 * Math.round((unit * down) / 2)];
}
