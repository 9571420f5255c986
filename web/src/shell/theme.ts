/** Light, dark or as the system is. */
import { effect, signal } from "@preact/signals";

export const THEMES = ["system", "light", "dark"] as const;
export type Theme = (typeof THEMES)[number];

const KEPT = "slewtrack.theme";
const dark = window.matchMedia("(prefers-color-scheme: dark)");
export const theme = signal<Theme>(kept());
const systemIsDark = signal(dark.matches);

function kept(): Theme {
  const given = localStorage.getItem(KEPT);
  return THEMES.find((one) => one === given) ?? "system";
}

/** Whether dark is what is shown now. */
export function isDark(): boolean {
  return theme.value === "dark" || (theme.value === "system" && systemIsDark.value);
}

dark.addEventListener("change", () => {
  systemIsDark.value = dark.matches;
});
effect(() => {
  localStorage.setItem(KEPT, theme.value);
  document.documentElement.dataset.theme = isDark() ? "dark" : "light";
});
