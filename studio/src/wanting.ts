// What light is wanted, and what the server makes of it: weights, targets, and how large lights are.
import { computed, signal } from "@preact/signals";
import { doc } from "./document";
import { change } from "./history";
import type { Intent } from "./messages";
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
  return brightness === 0 && contrast === 0 && mood === "natural" && below;
});

/** Says what is wanted besides; the document follows in one step of the history, of which those of a `merge` are one. */
export async function want(more: Partial<Intent>, label: string, merge: string | null = null) {
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
    change(label, (now) => ({ ...now, intent: to, weights, targets, lights: sized(now.lights) }), merge);
  } catch (error) {
    if (!(error instanceof Gone)) complain(error);
  } finally {
    if (said.value === to) said.value = null;
  }
}
