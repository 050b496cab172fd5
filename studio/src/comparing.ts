// What the picture is compared with, and how.
import { effect, signal } from "@preact/signals";
import { doc } from "./document";
import { otherLights } from "./drawing";
import { change } from "./history";
import type { Answer, Light } from "./messages";
import { complain, say } from "./notices";
import { interrupt } from "./searching";
import { ask, Gone } from "./socket";

export type Manner = "wiper" | "beside";

/** Name of what is compared: a preset's, or `kept`, the lights that were set aside; null for nothing. */
export const compared = signal<string | null>(null);
export const manner = signal<Manner>("wiper");
/** Where the wiper stands, 0 left to 1 right. */
export const wiper = signal(0.5);
/** The lights that were set aside. */
export const kept = signal<Light[] | null>(null);

export function beginComparing() {
  effect(() => {
    if (!doc.value) compared.value = otherLights.value = null;
  });
}

/** Compares with lights of a name. */
export async function compareWith(name: string | null) {
  compared.value = name;
  if (name === null) otherLights.value = null;
  else if (name === "kept") otherLights.value = kept.value;
  else otherLights.value = (await preset(name)) ?? null;
  if (!otherLights.value) compared.value = null;
}

async function preset(name: string): Promise<Light[] | null> {
  try {
    const answer: Answer = await ask({ type: "preset", name });
    return answer.type === "rig" ? answer.lights : null;
  } catch (error) {
    if (!(error instanceof Gone)) complain(error);
    return null;
  }
}

/** Sets the lights aside, to compare with them. */
export function keep() {
  if (!doc.value) return;
  kept.value = doc.value.lights;
  void compareWith("kept");
  say("The lights are set aside.");
}

/** Takes the compared lights as those of the document. */
export function take(title: string) {
  const lights = otherLights.value;
  if (!lights) return;
  interrupt();
  change(title, (document) => ({ ...document, lights }));
}
