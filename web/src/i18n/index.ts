/** The page's words: English comes with the page, Russian is loaded when chosen. */
import { computed, signal } from "@preact/signals";

import { EN } from "./en";

/** What English says, in any language: a key that is missing or too many doesn't compile. */
export type Like<T> = {
  [K in keyof T]: T[K] extends string
    ? string
    : T[K] extends (...given: infer G) => string
      ? (...given: G) => string
      : Like<T[K]>;
};
export type Words = Like<typeof EN>;

export const LANGUAGES = { en: "English", ru: "Русский" } as const;
export type Language = keyof typeof LANGUAGES;

const KEPT = "slewtrack.language";
const loaded = signal<Words>(EN);
export const language = signal<Language>("en");
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

/** "3 windows", in a language's forms of number. */
export function counted(count: number, one: string, few: string, many: string): string {
  const form = new Intl.PluralRules(language.value).select(count);
  return `${count} ${form === "one" ? one : form === "few" ? few : many}`;
}
