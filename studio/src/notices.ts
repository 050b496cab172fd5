// What the page says: faults, and F for those who do not see it.
import { signal } from "@preact/signals";

/** A fault that stays until it is closed. */
export const fault = signal<string | null>(null);
/** What screen readers say next. */
export const spoken = signal("");
/** What the page is busy with, in words. */
export const busy = signal<string | null>(null);

export function complain(error: unknown) {
  fault.value = error instanceof Error ? error.message : String(error);
}

export function say(text: string) {
  spoken.value = text;
}
