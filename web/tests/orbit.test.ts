/** Orbits as they are pasted: their kind, and when they hold. */
import { readFileSync } from "node:fs";

import { expect, test, vi } from "vitest";

// A source that the page has never heard of stands in the schema.
vi.mock("../src/api/lists", async (original) => {
  const lists = await original<typeof import("../src/api/lists")>();
  return { ...lists, ORBIT_SOURCES: [...lists.ORBIT_SOURCES, "keplerian", "ocm"] };
});

const { orbitOf, reachOf, searchStart, textOf } = await import("../src/api/orbit");
type Orbit = NonNullable<ReturnType<typeof orbitOf>>;

const { orbit: example } = JSON.parse(readFileSync("../examples/las_vegas_2015.json", "utf8")) as { orbit: Orbit };
const TLE = textOf(example);

test("elements of two lines hold from their epoch", () => {
  const read = orbitOf(`ISS (ZARYA)\r\n${TLE}\n`);
  expect(read?.source).toBe("tle");
  expect(reachOf(read as Orbit)).toEqual(reachOf(example));
  const epoch = new Date(reachOf(example)?.from_ms ?? 0);
  expect(epoch.toISOString().slice(0, 7)).toBe("2015-02");
});

test.each([
  ["oem", "CCSDS_OEM_VERS = 2.0\nSTART_TIME = 2015-02-27T17:00:00\nSTOP_TIME = 2015-058T18:00:00.5"],
  ["opm", "CCSDS_OPM_VERS = 2.0\nEPOCH = 2015-02-27T17:00:00"],
  ["omm", '<ndm><omm id="CCSDS_OMM_VERS"><EPOCH>2015-02-27T17:00:00</EPOCH></omm></ndm>'],
  ["omm", '[{"EPOCH": "2015-02-27T17:00:00", "MEAN_MOTION": 15.5}]'],
  ["ocm", "CCSDS_OCM_VERS = 3.0\nEPOCH = 2015-02-27T17:00:00"],
  ["keplerian", '{"source": "keplerian", "epoch": "2015-02-27T17:00:00Z", "semi_major_axis_km": 6790}'],
])("%s is known by its text", (source, text) => {
  const read = orbitOf(text);
  expect(read?.source).toBe(source);
  expect(reachOf(read as Orbit)?.from_ms).toBe(Date.UTC(2015, 1, 27, 17));
});

test("an ephemeris ends", () => {
  const read = orbitOf("CCSDS_OEM_VERS = 2.0\nSTART_TIME = 2015-02-27T17:00:00\nSTOP_TIME = 2015-058T18:00:00.5");
  expect(reachOf(read as Orbit)?.to_ms).toBe(Date.UTC(2015, 1, 27, 18, 0, 0, 500));
});

test("what the field shows of an orbit may be pasted again", () => {
  const state = { source: "state", epoch: "2015-02-27T17:00:00Z", frame: "GCRF" } as unknown as Orbit;
  expect(orbitOf(textOf(state))).toEqual(state);
});

test.each(["", "an orbit", "{}", '{"source": "rumour"}', "CCSDS_AEM_VERS = 1.0", "[1]", "null"])("no orbit: %s", (text) => {
  expect(orbitOf(text)).toBeNull();
});

test("windows are looked for from now on where the orbit holds now, else from its epoch on", () => {
  const from_ms = reachOf(example)?.from_ms ?? 0;
  const day_ms = 86_400_000;
  const inMinutes = (ms: number) => Math.ceil(ms / 60_000) * 60_000;
  expect(searchStart(example, from_ms + 3 * day_ms)).toBe(inMinutes(from_ms + 3 * day_ms));
  expect(searchStart(example, from_ms + 300 * day_ms)).toBe(inMinutes(from_ms));
});
