/** Targets as they are typed, and as the field shows them. */
import { expect, test } from "vitest";

import {
  durationOf,
  easySpeed,
  groundOf,
  kindOf,
  lengthOf,
  middleOf,
  starOf,
  type Target,
  textOf,
  withPoints,
} from "../src/rooms/planning/target";
import { targetTold } from "../src/rooms/planning/told";

const ground = (latitude_deg: number, longitude_deg: number, height_m = 0) => ({
  mode: "ground",
  latitude_deg,
  longitude_deg,
  height_m,
});

test.each([
  ["36.11, -115.17", ground(36.11, -115.17)],
  ["36.11 N 115.17 W", ground(36.11, -115.17)],
  ["36.11° s; 115.17° e", ground(-36.11, 115.17)],
  ["36.11, -115.17, 610 m", ground(36.11, -115.17, 610)],
  [" +1 -2 -3.5 ", ground(1, -2, -3.5)],
  ["Las Vegas, Nevada, US", { mode: "place", name: "Las Vegas, Nevada, US" }],
  ["46 3 25 N 14 30 36 E", ground(46.0569444, 14.51)],
  ["46°03′25″N, 14°30′36″E, 295", ground(46.0569444, 14.51, 295)],
  ["N 33 52.2 W 151 12.6", ground(33.87, -151.21)],
  ["14.51 E 46.05 N", ground(46.05, 14.51)],
  ["−33.87, 151.21", ground(-33.87, 151.21)],
  ["46 3 14 30", { mode: "place", name: "46 3 14 30" }],
  ["36.11", { mode: "place", name: "36.11" }],
  ["  ", null],
])("on the ground: %s", (text, target) => {
  expect(groundOf(text)).toEqual(target);
});

test.each([
  ["Vega", { mode: "star", name: "Vega" }],
  ["HIP 91262", { mode: "star", hip: 91262 }],
  ["91262", { mode: "star", hip: 91262 }],
  ["269.45, −4.74", { mode: "star", ra_deg: 269.45, dec_deg: -4.74 }],
  ["", null],
])("among the stars: %s", (text, target) => {
  expect(starOf(text)).toEqual(target);
});

test.each(["36.11, -115.17, 610", "Oslo"])("the field shows what it takes: %s", (text) => {
  expect(textOf(groundOf(text) as Target)).toBe(text);
});

test("a station is told by its place", () => {
  const target: Target = { mode: "station", latitude_deg: 78.23, longitude_deg: 15.4, height_m: 480 };
  expect(textOf(target)).toBe("78.23, 15.4, 480");
  expect(targetTold(target)).toBe("Station, 78.23, 15.4, 480");
});

test("a mode that the form doesn't make is told by its name", () => {
  const target = { mode: "ground_offset" } as unknown as Target;
  expect(kindOf(target)).toBe("ground_offset");
  expect(textOf(target)).toBe("ground_offset");
});

test("a path takes a minute until it is given a speed, which then stays", () => {
  const point = (latitude_deg: number, longitude_deg: number) => ({ latitude_deg, longitude_deg, height_m: 0 });
  const [one, other, last] = [point(0, 179.5), point(0, -179.5), point(1, -179.5)];
  const degree_m = (Math.PI * 6_371_000) / 180;
  expect(lengthOf([one, other, last])).toBeCloseTo(2 * degree_m, 3);
  expect(middleOf([one, other])).toEqual(point(0, 180));
  expect(middleOf([one])).toEqual(one);
  expect(middleOf([])).toBeNull();
  const path = withPoints(withPoints(null, [one]), [one, other]);
  expect(path.speed_m_s).toBe(easySpeed([one, other]));
  expect(durationOf(path)).toBeCloseTo(60, 0);
  expect(withPoints({ ...path, speed_m_s: 200 }, [one, other, last]).speed_m_s).toBe(200);
});
