/** The language of the page, and its forms of number. */
import { signal } from "@preact/signals";

export const LANGUAGES = { en: "English", ru: "Русский" } as const;
export type Language = keyof typeof LANGUAGES;

export const language = signal<Language>("en");

/** "3 windows", in a language's forms of number. */
export function counted(count: number, one: string, few: string, many: string): string {
  const form = new Intl.PluralRules(language.value).select(count);
  return `${count} ${form === "one" ? one : form === "few" ? few : many}`;
}
