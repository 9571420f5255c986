/** The tab is named after its content, and so is every printed page. */
import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";

const CHECKSUM_DIGITS = 12;

/** Of the tab, before the room's name. */
export const subject = signal("");

/** Until what is shown is left. */
export function useSubject(told: string): void {
  useEffect(() => {
    subject.value = told;
    return () => {
      subject.value = "";
    };
  }, [told]);
}

/** The request's, as far as it takes to tell it from others. */
export function checksum(sha256: string): string {
  return `SHA-256 ${sha256.slice(0, CHECKSUM_DIGITS)}`;
}

/** Header and footer of every printed page, and its number, as the margins of CSS have them. */
export function usePaper(header: string, footer: string, signed: string): void {
  useEffect(() => {
    const sheet = new CSSStyleSheet();
    const box = (place: string, content: string) => `@${place} { content: ${content}; font: 8px sans-serif; color: #333; }`;
    sheet.replaceSync(
      `@page { margin: 12mm 10mm; ${box("top-left", quoted(header))} ${box("bottom-left", quoted(footer))} ${box(
        "bottom-right",
        `${quoted(signed)} " · " counter(page) " / " counter(pages)`,
      )} }`,
    );
    document.adoptedStyleSheets = [...document.adoptedStyleSheets, sheet];
    return () => {
      document.adoptedStyleSheets = document.adoptedStyleSheets.filter((one) => one !== sheet);
    };
  }, [header, footer, signed]);
}

/** A string of CSS, whatever stands in it. */
export function quoted(text: string): string {
  return `"${text.replace(/[\\"\p{Cc}]/gu, (one) => `\\${one.codePointAt(0)?.toString(16)} `)}"`;
}
