// Keys that work everywhere on the page.
import { choose, doc } from "./document";
import { isHelping } from "./help";
import { redo, undo } from "./history";
import { chooseFile } from "./opening";
import { tool, type Tool } from "./placing";
import { isSaving } from "./save";
import { interrupt, pause, start, state } from "./searching";

const TOOL_KEYS: Record<string, Tool> = { v: "orbit", h: "highlight", s: "shading", r: "rim" };

/** Undone and redone steps may be those of a search that runs. */
export function goBack() {
  interrupt();
  undo();
}

export function goForward() {
  interrupt();
  redo();
}

function withControl(key: string, shift: boolean): boolean {
  if (key === "z") shift ? goForward() : goBack();
  else if (key === "y") goForward();
  else if (key === "s") isSaving.value = doc.value !== null;
  else if (key === "o") chooseFile();
  else return false;
  return true;
}

function alone(key: string, target: Element): boolean {
  const name = TOOL_KEYS[key];
  if (name) tool.value = name;
  else if (/^[1-9]$/.test(key)) {
    if (!doc.value?.lights[Number(key) - 1]) return false;
    choose(Number(key) - 1);
    document.querySelector<HTMLElement>(`[data-light="${Number(key) - 1}"]`)?.focus({ preventScroll: true });
  } else if (key === "?") isHelping.value = true;
  else if (key === " " && !target.closest("button, select, a, summary, label, dialog")) {
    if (state.value === "running") pause();
    else start();
  } else return false;
  return true;
}

export function beginKeys() {
  document.addEventListener("keydown", (event) => {
    if (event.defaultPrevented || event.altKey || !(event.target instanceof Element)) return;
    if (event.target.closest("dialog, input:not([type=range]):not([type=radio]):not([type=checkbox]), textarea")) return;
    const control = event.ctrlKey || event.metaKey;
    const key = event.key.toLowerCase();
    if (control ? withControl(key, event.shiftKey) : alone(key, event.target)) event.preventDefault();
  });
}
