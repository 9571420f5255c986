/** The page's words: English comes with the page, Russian is loaded when chosen. */
import { computed, signal } from "@preact/signals";

import { EN } from "./en";
import { type Language, language } from "./language";
import type { Words } from "./words";

const KEPT = "slewtrack.language";
const loaded = signal<Words>(EN);
/** Read `words.value.plan...` while rendering: it follows the language. */
export const words = computed(() => loaded.value);

export async function setLanguage(next: Language): Promise<void> {
  loaded.value = next === "ru" ? (await import("./ru")).RU : EN;
  language.value = next;
  document.documentElement.lang = next;
  localStorage.setItem(KEPT, next);
}

/** As chosen before, else as the browser is set. */
export async function loadLanguage(): Promise<void> {
  const kept = localStorage.getItem(KEPT) ?? navigator.language.slice(0, 2);
  if (kept === "ru") await setLanguage("ru");
}
