/** A calendar (iCalendar, RFC 5545) of what a timeline shows. */
import { send } from "../../api/client";
import { inTurn } from "./kept";
import type { Block } from "./lanes";

export interface Event {
  uid: string;
  start_ms: number;
  stop_ms: number;
  summary: string;
  description: string;
}

const OCTETS_MAX = 75;
const encoder = new TextEncoder();

/** events: of plans as the service wrote them, "BEGIN:VEVENT" to "END:VEVENT"; others as values. */
export function calendarOf(events: readonly (string | Event)[], stamp_ms: number): string {
  const lines = ["BEGIN:VCALENDAR", "VERSION:2.0", "PRODID:-//slewtrack//timeline//EN", "CALSCALE:GREGORIAN"];
  const told = events.map((one) => (typeof one === "string" ? one : eventOf(one, stamp_ms).map(folded).join("")));
  return `${lines.join("\r\n")}\r\n${told.join("")}END:VCALENDAR\r\n`;
}

/** The events of a calendar, as they are written. */
export function eventsIn(calendar: string): string[] {
  return calendar.match(/BEGIN:VEVENT\r\n[\s\S]*?END:VEVENT\r\n/g) ?? [];
}

/** Sessions of plans that are made, by the service's own export: the same ids as those of one plan. */
export async function sessionsOf(blocks: readonly Block[], until: AbortSignal): Promise<string[]> {
  const events: string[] = [];
  await inTurn(blocks, async ({ id }) => {
    const given = { id, query: { format: "ics" }, headers: { Accept: "*/*" }, signal: until };
    events.push(...eventsIn(await (await send("GET", "/v1/plans/{id}/table", given)).text()));
  });
  return events.sort((one, other) => startIn(one).localeCompare(startIn(other)));
}

/** What it holds isn't anybody's time: it shows as free. */
function eventOf({ uid, start_ms, stop_ms, summary, description }: Event, stamp_ms: number): string[] {
  return [
    "BEGIN:VEVENT",
    `UID:${uid}@slewtrack`,
    `DTSTAMP:${second(stamp_ms)}`,
    `DTSTART:${second(start_ms)}`,
    `DTEND:${second(1000 * Math.ceil(stop_ms / 1000))}`,
    `SUMMARY:${escaped(summary)}`,
    `DESCRIPTION:${escaped(description)}`,
    "TRANSP:TRANSPARENT",
    "END:VEVENT",
  ];
}

function startIn(event: string): string {
  return /DTSTART:(\S+)/.exec(event)?.[1] ?? "";
}

function second(ms: number): string {
  return `${new Date(ms).toISOString().slice(0, 19).replace(/[-:]/g, "")}Z`;
}

function escaped(text: string): string {
  return text
    .replace(/[\\;,]/g, (one) => `\\${one}`)
    .replace(/\r?\n/g, "\\n")
    .replace(/\p{Cc}/gu, " ");
}

/** In lines of at most 75 octets, of which none ends within a character. */
function folded(line: string): string {
  const parts = [""];
  let octets = 0;
  for (const character of line) {
    const more = encoder.encode(character).length;
    if (octets + more > OCTETS_MAX) {
      parts.push(" ");
      octets = 1;
    }
    parts[parts.length - 1] += character;
    octets += more;
  }
  return `${parts.join("\r\n")}\r\n`;
}
