/** Targets as they are typed, and as the field shows them. */
import { expect, test } from "vitest";

import { groundOf, kindOf, starOf, type Target, textOf } from "../src/rooms/planning/target";

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
  ["36.11", { mode: "place", name: "36.11" }],
  ["  ", null],
])("on the ground: %s", (text, target) => {
  expect(groundOf(text)).toEqual(target);
});

test.each([
  ["Vega", { mode: "star", name: "Vega" }],
  ["HIP 91262", { mode: "star", hip: 91262 }],
  ["91262", { mode: "star", hip: 91262 }],
  ["", null],
])("among the stars: %s", (text, target) => {
  expect(starOf(text)).toEqual(target);
});

test.each(["36.11, -115.17, 610", "Oslo"])("the field shows what it takes: %s", (text) => {
  expect(textOf(groundOf(text) as Target)).toBe(text);
});

test("a mode that the form doesn't make is told by its name", () => {
  const target = { mode: "ground_offset" } as unknown as Target;
  expect(kindOf(target)).toBe("other");
  expect(textOf(target)).toBe("ground_offset");
});
