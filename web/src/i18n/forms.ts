/** Numbers, times and durations as they are written, the same in every room. */
import { language } from "./language";

/** "17:36:20" of "2015-02-27T17:36:20.000Z"; UTC always, as the tables are. */
export function clock(iso: string | number): string {
  return new Date(iso).toISOString().slice(11, 19);
}

/** "17:36:20", and "17:34:26.6" between whole seconds: an instant of a table's row, which must not be rounded. */
export function rowClock(iso: string | number): string {
  return new Date(Math.round(new Date(iso).getTime() / 100) * 100).toISOString().slice(11, 21).replace(/\.0$/, "");
}

/** "27 Feb 2015"; UTC. */
export function day(iso: string | number): string {
  return date(iso, { day: "numeric", month: "short", year: "numeric" });
}

/** "27 Feb"; UTC. */
export function dayOfYear(iso: string | number): string {
  return date(iso, { day: "numeric", month: "short" });
}

function date(iso: string | number, parts: Intl.DateTimeFormatOptions): string {
  const locale = language.value === "en" ? "en-GB" : language.value;
  return new Intl.DateTimeFormat(locale, { ...parts, timeZone: "UTC" }).format(new Date(iso)).replace(/\u202f|\u00a0/g, " ");
}

/** "27 Feb 2015 17:36:20–17:37:50 UTC", with a second day where it ends on another. */
export function period(start: string, stop: string): string {
  const [first, last] = [day(start), day(stop)];
  return `${first} ${rowClock(start)}–${first === last ? "" : `${last} `}${rowClock(stop)} UTC`;
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
  if (value !== 0 && Math.abs(value) < 1e-3) {
    const [whole, power] = value.toExponential(count - 1).split("e");
    return `${number(Number(whole), count - 1)}e${power}`;
  }
  return (value + 0).toLocaleString(language.value, {
    maximumSignificantDigits: count,
    useGrouping: false,
  });
}

/** With just so many decimals; what rounds to nothing has no sign. */
export function fixed(value: number | null | undefined, decimals: number): string {
  if (value == null || !Number.isFinite(value)) return "–";
  const rounded = Number(value.toFixed(decimals)) + 0;
  const form = { minimumFractionDigits: decimals, maximumFractionDigits: decimals, useGrouping: false };
  return rounded.toLocaleString(language.value, form).replace("-", "−");
}

export function percent(share: number | null | undefined, decimals = 1): string {
  if (share == null) return "–";
  const least = 10 ** -(decimals + 2);
  if (share > 1 - least && share < 1) return `> ${number((1 - least) * 100, decimals)} %`;
  return `${number(share * 100, decimals)} %`;
}

/** A margin's share of its limit; of small ones two digits, since "0 %" is no figure. */
export function marginTold(share: number | null): string {
  return share !== null && Math.abs(share) < 0.01 ? `${digits(share * 100, 2)} %` : percent(share, 0);
}

/** An angle of so few arcseconds that it is the computation's alone says no more than that. */
export function arcsecTold(value: number): string {
  return value < 1e-3 ? `< ${number(1e-3, 3)}` : digits(value, 2);
}

/** A member of one of the service's lists in the page's words; as the service says it where it has none yet. */
export function named(texts: Record<string, string>, name: string): string {
  return texts[name] ?? name;
}
