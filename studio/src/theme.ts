// Light and dark: as the system has it, or as it was chosen here.
import { computed, effect, signal } from "@preact/signals";

export type Theme = "auto" | "light" | "dark";

const KEY = "klieg-studio-theme";

const system = window.matchMedia("(prefers-color-scheme: dark)");
const systemDark = signal(system.matches);

export const theme = signal<Theme>("auto");
/** Whether the page is dark. */
export const dark = computed(() => (theme.value === "auto" ? systemDark.value : theme.value === "dark"));

/** The other scheme than the system's, or the system's again. */
export const nextTheme = () => {
  theme.value = theme.value !== "auto" ? "auto" : dark.value ? "light" : "dark";
};

export function beginTheme() {
  system.addEventListener("change", ({ matches }) => {
    systemDark.value = matches;
  });
  try {
    const stored = localStorage.getItem(KEY);
    if (stored === "light" || stored === "dark") theme.value = stored;
  } catch {
    // A browser that keeps nothing follows the system.
  }
  effect(() => {
    document.documentElement.dataset.theme = theme.value;
    try {
      localStorage.setItem(KEY, theme.value);
    } catch {
      // As above.
    }
  });
}
