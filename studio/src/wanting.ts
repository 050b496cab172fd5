// What light is wanted, and what the server makes of it: weights, targets, and how large lights are.
import { computed, signal } from "@preact/signals";
import { doc } from "./document";
import { change } from "./history";
import type { Document, Intent } from "./messages";
import { complain } from "./notices";
import { interrupt } from "./searching";
import { ask, Gone } from "./socket";

export const NOTHING: Intent = { brightness: 0, contrast: 0, mood: "natural", below: true };

/** What was said last, until the server has answered. */
const said = signal<Intent | null>(null);

export const intent = computed<Intent>(() => said.value ?? doc.value?.intent ?? NOTHING);

/** Whether nothing in particular is wanted. */
export const isPlain = computed(() => {
  const { brightness, contrast, mood, below } = intent.value;
  const { focus = [], dim = [] } = doc.value ?? {};
  const alike = focus.length === 0 && dim.length === 0;
  return alike && brightness === 0 && contrast === 0 && mood === "natural" && below;
});

/** How an object of the model is to be lit: as all others, before them, or not at all. */
export type Wish = "plain" | "focus" | "dim";

export const wishFor = (name: string): Wish =>
  doc.value?.dim.includes(name) ? "dim" : doc.value?.focus.includes(name) ? "focus" : "plain";

const WISHES = { plain: "as all others", focus: "before all others", dim: "dim" };

export function wish(name: string, kind: Wish) {
  interrupt();
  const without = (names: string[]) => names.filter((other) => other !== name);
  change(`${name} ${WISHES[kind]}`, (document) => ({
    ...document,
    focus: kind === "focus" ? [...without(document.focus), name] : without(document.focus),
    dim: kind === "dim" ? [...without(document.dim), name] : without(document.dim),
  }));
}

/**
 * Says what is wanted besides; the document follows, with other `values` of it, in one step of the history. Steps of the same
 * `merge` that follow each other closely become one.
 */
export async function want(more: Partial<Intent>, label: string, merge: string | null = null, values: Partial<Document> = {}) {
  const document = doc.value;
  if (!document) return;
  interrupt();
  const from = document.intent;
  const to: Intent = { ...intent.value, ...more };
  said.value = to;
  try {
    const answer = await ask({ type: "steer", from, to, lights: document.lights });
    // Another document may stand by now.
    if (answer.type !== "steered" || said.value !== to || doc.value?.intent !== from) return;
    interrupt();
    const { weights, targets, sizes } = answer;
    const sized = (lights: typeof document.lights) => lights.map((light, index) => ({ ...light, size: sizes[index] ?? light.size }));
    change(label, (now) => ({ ...now, ...values, intent: to, weights, targets, lights: sized(now.lights) }), merge);
  } catch (error) {
    if (!(error instanceof Gone)) complain(error);
  } finally {
    if (said.value === to) said.value = null;
  }
}
