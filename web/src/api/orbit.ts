/** An orbit as it was pasted or dropped: the kind of its text, and when it holds. */
import type { Schemas } from "./client";
import { ORBIT_SOURCES } from "./lists";

export type Orbit = Schemas["PlanRequest"]["orbit"];

const DAY_MS = 86_400_000;
// The service warns of elements after 3 days and refuses them at 30.
const FRESH_DAYS = 14;

const KINDS = ORBIT_SOURCES.join("|");
// A CCSDS message names its kind, as KVN or as XML; an OMM may be JSON as well.
const MESSAGE = new RegExp(`CCSDS_(${KINDS})_VERS|<(${KINDS})[\\s>]`, "i");

/** The orbit that a text holds: a message, or what a request has as JSON; null for what is none that the service knows. */
export function orbitOf(text: string): Orbit | null {
  const content = text.trim();
  const member = jsonOf(content) as Orbit | null;
  if (ORBIT_SOURCES.some((source) => source === member?.source)) return member;
  if (/^1 [0-9A-Z]{5}.*\r?\n\s*2 [0-9A-Z]{5}/im.test(content)) return { source: "tle", content };
  const [, kvn, xml] = MESSAGE.exec(content) ?? [];
  const kind = kvn ?? xml ?? (content.includes('"MEAN_MOTION"') ? "omm" : null);
  return kind ? ({ source: kind.toLowerCase(), content } as Orbit) : null;
}

function jsonOf(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    return null;
  }
}

/** What stands in the text field for an orbit. */
export function textOf(orbit: Orbit): string {
  const { content, line1, line2 } = orbit as { content?: unknown; line1?: string; line2?: string };
  if (typeof content === "string") return content;
  if (line1 && line2) return `${line1}\n${line2}`;
  return JSON.stringify(content ?? orbit, null, 1);
}

export interface Reach {
  /** Of elements or a state their epoch, of an ephemeris its first instant; ms since 1970. */
  from_ms: number;
  /** The last instant of an ephemeris. */
  to_ms: number | null;
}

/** When an orbit holds; null where its text doesn't say so in a way we read. */
export function reachOf(orbit: Orbit): Reach | null {
  if ("epoch" in orbit && typeof orbit.epoch === "string") return { from_ms: Date.parse(orbit.epoch), to_ms: null };
  const text = textOf(orbit);
  const line = /^1 [0-9A-Z]{5}.*$/m.exec(text)?.[0];
  if (line) {
    const year = Number(line.slice(18, 20));
    const day = Number(line.slice(20, 32));
    const from_ms = Date.UTC(year < 57 ? 2000 + year : 1900 + year, 0) + (day - 1) * DAY_MS;
    return Number.isFinite(from_ms) ? { from_ms, to_ms: null } : null;
  }
  if (orbit.source === "oem") {
    const first = timesAfter(text, "START_TIME").sort((a, b) => a - b)[0];
    const last = timesAfter(text, "STOP_TIME").sort((a, b) => b - a)[0];
    return first === undefined ? null : { from_ms: first, to_ms: last ?? null };
  }
  const epoch = timesAfter(text, "EPOCH")[0];
  return epoch === undefined ? null : { from_ms: epoch, to_ms: null };
}

/** What an ephemeris covers of a span, by its usable times where it has some; null for nothing of it. */
export function covered(orbit: Orbit, [from_ms, to_ms]: readonly [number, number]): [number, number] | null {
  const reach = reachOf(orbit);
  if (!reach || reach.to_ms === null) return [from_ms, to_ms];
  const text = textOf(orbit);
  const first = Math.max(reach.from_ms, ...timesAfter(text, "USEABLE_START_TIME").slice(0, 1));
  const last = Math.min(reach.to_ms, ...timesAfter(text, "USEABLE_STOP_TIME").slice(-1));
  const both: [number, number] = [Math.max(from_ms, first), Math.min(to_ms, last)];
  return both[0] < both[1] ? both : null;
}

/** From when on to look for windows: now, where the orbit still holds then. */
export function searchStart(orbit: Orbit, now_ms: number): number {
  const known = reachOf(orbit);
  if (!known) return upToMinute(now_ms);
  const holdsNow =
    known.to_ms === null
      ? Math.abs(now_ms - known.from_ms) < FRESH_DAYS * DAY_MS
      : now_ms > known.from_ms && now_ms < known.to_ms;
  return upToMinute(holdsNow ? now_ms : known.from_ms);
}

function upToMinute(ms: number): number {
  return Math.ceil(ms / 60_000) * 60_000;
}

/** Of a CCSDS message, as KVN, XML or JSON; its times are UTC, calendar or day of year. */
function timesAfter(text: string, keyword: string): number[] {
  const times: number[] = [];
  for (const found of text.matchAll(new RegExp(`${keyword}\\W+(\\d{4}-[\\dT:.-]+)`, "g"))) {
    const time = calendar(found[1] ?? "");
    if (Number.isFinite(time)) times.push(time);
  }
  return times;
}

function calendar(text: string): number {
  const byDay = /^(\d{4})-(\d{3})T(.+)$/.exec(text);
  if (!byDay) return Date.parse(`${text}Z`);
  const midnight = Date.parse(`${byDay[1]}-01-01T${byDay[3]}Z`);
  return midnight + (Number(byDay[2]) - 1) * DAY_MS;
}
