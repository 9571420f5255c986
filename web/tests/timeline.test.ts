/** Lanes, conflicts and calendars of the timeline, against cases worked by hand and RFC 5545. */
import { expect, test } from "vitest";

import "./page";

const { around, conflictsOf, DAY_MS, lanesOf, rowsOf, ticksOf, zoomed } = await import("../src/rooms/timeline/lanes");
const { calendarOf, eventsIn } = await import("../src/rooms/timeline/calendar");
const { nameOfCarrier } = await import("../src/rooms/timeline/kept");
type Block = Parameters<typeof conflictsOf>[0][number];

const NOON_MS = Date.UTC(2015, 1, 27, 12);

function block(id: string, from_s: number, to_s: number, more: Partial<Block> = {}): Block {
  return {
    id,
    kind: "plan",
    to: `/plans/${id}`,
    name: id,
    owner: null,
    platform: "iss-hrc",
    carrier: "NORAD 25544",
    state: "done",
    revises: null,
    probability: null,
    start_ms: NOON_MS + 1000 * from_s,
    stop_ms: NOON_MS + 1000 * to_s,
    stretches: [],
    ...more,
  };
}

const ids = (found: ReturnType<typeof conflictsOf>) => found.map(({ one, other }) => `${one.id}${other.id}`);

test("plans of one platform at one time get in each other's way", () => {
  const [found] = conflictsOf([block("a", 0, 60), block("b", 50, 90)]);
  expect(found).toMatchObject({ start_ms: NOON_MS + 50_000, stop_ms: NOON_MS + 60_000 });
  expect(conflictsOf([block("a", 0, 60), block("b", 60, 90)])).toEqual([]); // one ends as the other begins
  expect(ids(conflictsOf([block("long", 0, 900), block("b", 60, 90), block("c", 100, 120)]))).toEqual(["longb", "longc"]);
});

test("no conflict: another platform or satellite, a plan that isn't flown, one that was replaced", () => {
  const a = block("a", 0, 60);
  for (const other of [
    { platform: "other" },
    { carrier: "NORAD 43013" },
    { state: "refused" },
    { state: "cancelled" },
    { revises: "a" },
  ]) {
    expect(conflictsOf([a, block("b", 0, 60, other)])).toEqual([]);
  }
  expect(ids(conflictsOf([a, block("b", 0, 60, { state: "running" })]))).toEqual(["ab"]);
  const revised = [block("c", 0, 60), block("d", 0, 60, { revises: "c" })];
  expect(ids(conflictsOf([a, ...revised]))).toEqual(["ad"]);
});

test("lanes are of a satellite's platform or of a person", () => {
  const blocks = [block("a", 10, 20, { owner: "night shift" }), block("b", 0, 5), block("c", 0, 5, { platform: "other" })];
  expect(lanesOf(blocks, "carrier", "nobody").map((lane) => [lane.name, lane.blocks.map((one) => one.id)])).toEqual([
    ["iss-hrc, NORAD 25544", ["b", "a"]],
    ["other, NORAD 25544", ["c"]],
  ]);
  expect(lanesOf(blocks, "owner", "nobody").map((lane) => lane.name)).toEqual(["night shift", "nobody"]);
});

test("blocks and their names don't lie over each other", () => {
  const blocks = [block("a", 0, 10), block("b", 5, 15), block("c", 20, 30), block("d", 60, 70)];
  expect(rowsOf(blocks, [0, 0, 0, 0])).toEqual([0, 1, 0, 0]);
  expect(rowsOf(blocks, [30_000, 0, 0, 0])).toEqual([0, 1, 1, 0]); // a name of 30 s
});

test("ticks are whole times of day, no more than fit", () => {
  const day = ticksOf([NOON_MS, NOON_MS + DAY_MS], 10);
  expect(day.map((one) => new Date(one.at_ms).getUTCHours())).toEqual([12, 15, 18, 21, 0, 3, 6, 9, 12]);
  for (const days of [40, 400, 4000, 400_000]) {
    expect(ticksOf([NOON_MS, NOON_MS + days * DAY_MS], 12).length).toBeLessThanOrEqual(13);
  }
  expect(ticksOf([NOON_MS + 1, NOON_MS + 1000], 10)).toEqual([{ at_ms: NOON_MS + 1000, step_ms: 1000 }]);
});

test("a zoom leaves the instant below the pointer where it is", () => {
  const [from, to] = zoomed([NOON_MS, NOON_MS + 1000_000], NOON_MS + 250_000, 2);
  expect([from - NOON_MS, to - NOON_MS]).toEqual([125_000, 625_000]);
  const [least, most] = zoomed([0, 30_000], 0, 1e6);
  expect(most - least).toBe(20_000);
  expect(around([])).toBeNull();
});

test("a calendar of lines that end with CRLF, of 75 octets at most, its text escaped", () => {
  const made = calendarOf(
    [
      "BEGIN:VEVENT\r\nUID:a\r\nEND:VEVENT\r\n",
      { uid: "w", start_ms: NOON_MS, stop_ms: NOON_MS + 500, summary: `Łódź; ${"ż".repeat(60)}`, description: "a, b\nc" },
    ],
    NOON_MS,
  );
  expect(made.endsWith("END:VCALENDAR\r\n")).toBe(true);
  const lines = made.slice(0, -2).split("\r\n");
  for (const line of lines) expect(new TextEncoder().encode(line).length).toBeLessThanOrEqual(75);
  const text = made.replace(/\r\n /g, "");
  expect(text).toContain(`SUMMARY:Łódź\\; ${"ż".repeat(60)}\r\n`);
  expect(text).toContain("DESCRIPTION:a\\, b\\nc\r\n");
  expect(text).toContain("DTSTART:20150227T120000Z\r\nDTEND:20150227T120001Z\r\n");
  expect(eventsIn(made)).toHaveLength(2);
  expect(eventsIn(made)[0]).toBe("BEGIN:VEVENT\r\nUID:a\r\nEND:VEVENT\r\n");
});

test.each([
  [{ source: "tle", line1: "1 25544U 98067A   15058.48161588", line2: "2 25544  51.6478" }, "NORAD 25544"],
  [{ source: "tle", content: "ISS (ZARYA)\n1 00005U 58002B   15058.48161588\n2 00005  51.6478" }, "NORAD 5"],
  [{ source: "omm", content: { OBJECT_NAME: "ISS", NORAD_CAT_ID: 25544 } }, "NORAD 25544"],
  [{ source: "oem", content: "CCSDS_OEM_VERS = 2.0\nOBJECT_NAME = ISS (ZARYA)\nOBJECT_ID = 1998-067-A" }, "ISS (ZARYA)"],
  [{ source: "state_vector", epoch: "2015-02-27T12:00:00Z" }, ""],
])("the satellite of %o", (orbit, name) => {
  expect(nameOfCarrier(orbit as never)).toBe(name);
});
