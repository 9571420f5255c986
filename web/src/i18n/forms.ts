/** Numbers, times and durations as they are written, the same in every room. */
import { language } from "./language";

/** "17:36:20" of "2015-02-27T17:36:20.000Z"; UTC always, as the tables are. */
export function clock(iso: string | number): string {
  return new Date(iso).toISOString().slice(11, 19);
}

/** "2015-02-27 17:36:20 UTC". */
export function instant(iso: string | number): string {
  return `${new Date(Math.round(new Date(iso).getTime() / 1000) * 1000).toISOString().slice(0, 19).replace("T", " ")} UTC`;
}

/** RFC 3339, as requests have it: to tenths of a second, where the 0.2 s grid needs them. */
export function rfc3339(ms: number): string {
  return new Date(ms).toISOString().replace(/\.?0+Z$/, "Z");
}

/** With at most so many decimals; "–" for what isn't there. */
export function number(value: number | null | undefined, decimals = 1): string {
  if (value == null || !Number.isFinite(value)) return "–";
  return value.toLocaleString(language.value, {
    maximumFractionDigits: decimals,
    useGrouping: false,
  });
}

/** With so many significant digits. */
export function digits(value: number | null | undefined, count = 3): string {
  if (value == null || !Number.isFinite(value)) return "–";
  if (value !== 0 && Math.abs(value) < 1e-3) return value.toExponential(count - 1);
  return value.toLocaleString(language.value, {
    maximumSignificantDigits: count,
    useGrouping: false,
  });
}

export function percent(share: number | null | undefined, decimals = 1): string {
  if (share == null) return "–";
  const least = 10 ** -(decimals + 2);
  if (share > 1 - least && share < 1) return `> ${number((1 - least) * 100, decimals)} %`;
  return `${number(share * 100, decimals)} %`;
}

/** A member of one of the service's lists in the page's words; as the service says it where it has none yet. */
export function named(texts: Record<string, string>, name: string): string {
  return texts[name] ?? name;
}
