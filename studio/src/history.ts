// All that was done to the document, to be undone.
import { computed, signal } from "@preact/signals";
import { doc, type Edit } from "./document";
import type { Document } from "./messages";

export type Entry = { label: string; document: Document; score: number | null; merge: string | null; time: number };

const LONGEST = 200;
/** Edits of the same kind within this time are one step, milliseconds. */
const TOGETHER = 1200;

export const entries = signal<Entry[]>([]);
export const cursor = signal(-1);

export const canUndo = computed(() => cursor.value > 0);
export const canRedo = computed(() => cursor.value < entries.value.length - 1);

/** Forgets everything and begins with a document. */
export function begin(document: Document, label: string) {
  doc.value = document;
  entries.value = [{ label, document, score: null, merge: null, time: 0 }];
  cursor.value = 0;
}

/** Changes the document without a step of its own, as while something is dragged. */
export function edit(change: Edit) {
  if (doc.value) doc.value = change(doc.value);
}

/** Makes a step of what has changed. Steps of the same `merge` that follow each other closely become one. */
export function commit(label: string, merge: string | null = null) {
  const document = doc.value;
  const current = entries.value[cursor.value];
  if (!document || !current || current.document === document) return;
  const now = performance.now();
  const same = merge !== null && current.merge === merge && now - current.time < TOGETHER;
  const kept = entries.value.slice(0, same ? cursor.value : cursor.value + 1);
  const next = [...kept, { label, document, score: null, merge, time: now }].slice(-LONGEST);
  entries.value = next;
  cursor.value = next.length - 1;
}

export function change(label: string, change: Edit, merge: string | null = null) {
  edit(change);
  commit(label, merge);
}

/** Goes to a step of the list. */
export function jump(index: number) {
  const entry = entries.value[index];
  if (!entry) return;
  // A step that was judged before the next one was begun would be lost otherwise.
  cursor.value = index;
  doc.value = entry.document;
}

export const undo = () => jump(cursor.value - 1);
export const redo = () => jump(cursor.value + 1);

/** Takes down how good the picture of a document is. */
export function judgedAs(document: Document, score: number) {
  const index = entries.value.findIndex((entry) => entry.document === document);
  const entry = entries.value[index];
  if (!entry || entry.score === score) return;
  entries.value = entries.value.with(index, { ...entry, score });
}
