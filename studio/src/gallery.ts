// Alternatives: other lights that are as good, each with a small picture.
import { signal } from "@preact/signals";
import { doc, look } from "./document";
import { change } from "./history";
import type { Light } from "./messages";
import { say } from "./notices";
import { interrupt } from "./searching";
import { listen, send, type Picture } from "./socket";

export type Alternative = { index: number; lights: Light[]; score: number; image: ImageData | null };

const COUNT = 8;

export const alternatives = signal<Alternative[]>([]);
export const seeking = signal(false);

let request = 0;
/** Thumbnails that came before what they show. */
const early = new Map<number, ImageData>();

export function beginGallery() {
  listen("alternative", ({ id, index, lights, score }) => {
    if (id !== request) return;
    const others = alternatives.value.filter((other) => other.index !== index);
    const next = { index, lights, score, image: early.get(index) ?? null };
    alternatives.value = [...others, next].sort((a, b) => a.score - b.score);
  });
  listen("alternatives_done", ({ id, count }) => {
    if (id !== request) return;
    seeking.value = false;
    say(`${count} alternatives.`);
  });
}

/** Asks for other lights of the document as it stands. */
export function seek() {
  const document = doc.value;
  if (!document) return;
  interrupt();
  early.clear();
  alternatives.value = [];
  request = send({ type: "alternatives", count: COUNT, size: document.size, ...look(document) });
  seeking.value = request !== 0;
}

/** Takes a small picture of the server's. */
export function pictured({ id, index, image }: Picture) {
  if (id !== request) return;
  early.set(index, image);
  alternatives.value = alternatives.value.map((other) => (other.index === index ? { ...other, image } : other));
}

export function adopt({ lights }: Alternative, position: number) {
  interrupt();
  change(`Alternative ${position + 1}`, (document) => ({ ...document, lights }));
}

/** A search for alternatives that failed has come to its end. */
export function seekFailed(id: number | null) {
  if (id === request) seeking.value = false;
}

export function forget() {
  request = 0;
  seeking.value = false;
  early.clear();
  alternatives.value = [];
}
