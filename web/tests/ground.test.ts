/** Lines and circles on the map, against spherical geometry that is known. */
import { geoDistance } from "d3-geo";
import { expect, test } from "vitest";

import "./page";

const { circleOf, groundTrack } = await import("../src/rooms/planning/passes");
const { middleOf, ringOf, wrap } = await import("../src/map/places");
const { footprintAt, linesOf } = await import("../src/rooms/viewer/ground");
type Window = Parameters<typeof groundTrack>[0];
type View = Parameters<typeof footprintAt>[0];

const EARTH_KM = 6371;
const DEG = 180 / Math.PI;

/** Seen from a place at an elevation, a carrier so high is so far away along the ground and in line. */
function seen(height_km: number, elevation_deg: number) {
  const elevation = elevation_deg / DEG;
  const nadir = Math.asin((EARTH_KM / (EARTH_KM + height_km)) * Math.cos(elevation));
  const away = Math.PI / 2 - elevation - nadir;
  return { away_deg: away * DEG, range_km: ((EARTH_KM + height_km) * Math.sin(away)) / Math.cos(elevation) };
}

test.each([
  [0, 90],
  [60, -115],
  [-85, 179.9],
])("a track lies under the carrier, seen from %f, %f", (latitude_deg, longitude_deg) => {
  const { away_deg, range_km } = seen(420, 20);
  const point = (azimuth_deg: number, at: string) => ({ azimuth_deg, elevation_deg: 20, at });
  const [first, middle, last] = groundTrack({
    place: { latitude_deg, longitude_deg },
    sky: {
      rise: point(0, "2015-02-27T17:00:00Z"),
      culmination: point(120, "2015-02-27T17:00:01Z"),
      set: point(240, "2015-02-27T17:00:02Z"),
    },
    through: { at: ["2015-02-27T17:00:00Z"], range_km: [range_km] },
  } as unknown as Window);
  for (const found of [first, middle, last]) {
    expect(geoDistance([longitude_deg, latitude_deg], found ?? [0, 0]) * DEG).toBeCloseTo(away_deg, 9);
  }
  if (latitude_deg + away_deg < 90) expect(wrap((first?.[0] ?? 0) - longitude_deg)).toBeCloseTo(0, 9);
  if (latitude_deg + away_deg < 90) expect(first?.[1]).toBeCloseTo(latitude_deg + away_deg, 9);
});

test("the circle is as far as the least elevation lets see", () => {
  const { range_km } = seen(420, 65);
  const window = { place: {}, closest: { range_km, elevation_deg: 65 } } as unknown as Window;
  expect(circleOf(window, 20)).toBeCloseTo(seen(420, 20).away_deg, 9);
  expect(circleOf({ ...window, place: null }, 20)).toBeNull();
});

test("the middle of places isn't on the other side of the date line", () => {
  expect(middleOf([])).toBeNull();
  expect(
    middleOf([
      [170, 10],
      [-170, -10],
    ]),
  ).toEqual({ at: [-180, 0], wide_deg: 20, high_deg: 20 });
  expect(wrap(540)).toBe(-180);
});

test("a ring is wound as d3 wants it and closed, however it was given", () => {
  const [one, two, three] = [
    [0, 0],
    [10, 0],
    [10, 10],
  ] as [number, number][];
  if (!one || !two || !three) throw new Error("three places");
  for (const given of [
    [one, two, three],
    [three, two, one],
    [one, two, three, one],
  ]) {
    const ring = ringOf(given);
    expect(ring[0]).toEqual(ring[ring.length - 1]);
    expect(ring.length).toBe(4);
    const area = ring.slice(1).reduce((sum, [x, y], k) => sum + (ring[k]?.[0] ?? 0) * y - x * (ring[k]?.[1] ?? 0), 0);
    expect(area).toBeLessThan(0); // clockwise
  }
});

test("a line breaks where a point is unknown, a footprint is none where a corner misses the Earth", () => {
  const trace = { longitude_deg: [0, 1, null, 3, 4, null, 6], latitude_deg: [0, 0, 0, 0, 0, 0, 0] };
  expect(linesOf(trace)).toEqual([
    [
      [0, 0],
      [1, 0],
    ],
    [
      [3, 0],
      [4, 0],
    ],
  ]);
  const footprint = {
    longitude_deg: [
      [0, 1, 1, 0],
      [0, null, 1, 0],
    ],
    latitude_deg: [
      [0, 0, 1, 1],
      [0, 0, 1, 1],
    ],
  };
  const view = { footprint } as unknown as View;
  expect(footprintAt(view, 0)).toEqual([
    [0, 1],
    [1, 1],
    [1, 0],
    [0, 0],
    [0, 1],
  ]);
  expect(footprintAt(view, 1)).toEqual([]);
});
