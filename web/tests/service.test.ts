/** The service's warnings and refusals have their sentences in Russian, figures and names taken over. */
import { readFileSync } from "node:fs";

import { expect, test } from "vitest";

import "./page";
import { tellerBy } from "../src/i18n/patterns";
import { service } from "../src/i18n/ru/service";
import patterns from "../src/i18n/ru/service.json";

const ANSWERS: unknown = JSON.parse(readFileSync("../app/http/openapi/data/answers.json", "utf8"));
const HOLE = /\{\w+\}|<\w+>/g;
const FIGURE = /\d[\d.:TZ-]*/g;

/** Texts of the worked answers that the page shows as they are. */
function textsIn(value: unknown): string[] {
  if (Array.isArray(value)) return value.flatMap(textsIn);
  if (typeof value !== "object" || value === null) return [];
  return Object.entries(value).flatMap(([name, member]) => [
    ...(name === "warnings" && Array.isArray(member) ? (member as string[]) : []),
    ...(name === "assumed" && Array.isArray(member) ? member.map((one: { detail: string }) => one.detail) : []),
    ...(name === "contributions" && Array.isArray(member)
      ? member.flatMap((one: { cause: string; better: string }) => [one.cause, one.better])
      : []),
    ...textsIn(member),
  ]);
}

const shown = [...new Set(textsIn(ANSWERS))];

test("the worked answers have warnings and causes", () => {
  expect(shown.length).toBeGreaterThan(5);
});

test.each(shown)("in Russian: %s", (text) => {
  const told = service.told(text);
  expect(told).toMatch(/[а-яё]/);
  for (const figure of text.match(FIGURE) ?? []) expect(told).toContain(figure);
});

test.each(Object.entries(patterns))("the same holes stand in both: %s", (english, told) => {
  expect(told).toMatch(/[а-яё]|^\{field\}/);
  const holes = english.match(HOLE) ?? [];
  expect(new Set(holes).size).toBe(holes.length);
  for (const hole of told.match(HOLE) ?? []) expect(holes).toContain(hole);
});

test("of several sentences all are told, or none", () => {
  const late = "alpha needs 12.300 s to slew but 4.000 s are available";
  const way = "earliest feasible start 2015-02-27T17:36:20.0Z, keeping the stop";
  expect(service.told(`${late}; begin the session later or start the slew nearer to it; ${way}`)).toBe(
    "оси alpha на разворот нужно 12.300 с, а есть 4.000 с; начните сеанс позже или разворот ближе к нему; " +
      "самое раннее осуществимое начало 2015-02-27T17:36:20.0Z с тем же концом",
  );
  expect(service.told(`${late}; nobody wrote this down`)).toBe(`${late}; nobody wrote this down`);
});

test("a reason within a sentence is told with it, names in it stay", () => {
  expect(
    service.told(
      "session 1: from 2015-02-27T17:30:00Z the target can't be seen; at 2015-02-27T17:31:00Z the carrier stands at " +
        "4.20 deg elevation in the target's sky, below the 10 deg asked for",
    ),
  ).toContain("на высоте 4.20°, ниже заданных 10°");
  expect(service.told("there is no telemetry of orbit")).toBe("телеметрии оси orbit нет");
});

test.each([
  "the straight slew enters the Sun's cone by 12.30 deg and no way around the Sun's cone was found in 40.0 s; " +
    "give the slew more time or the cone a smaller half angle",
  "no motion within the limits leads around mask 1 in 40.0 s; give the slew more time, or begin it with other angles, " +
    "or choose other times",
  "following the target needs 7.13 deg/s of alpha at 2015-02-27T17:37:00.2Z, more than the 3 deg/s it has; as near as " +
    "the limits allow, the target is 1.234 deg off at 2015-02-27T17:37:01.0Z, outside the circle of 0.400 deg inside the frame",
  "content: OEM line 12: REF_FRAME 'MARS' is not supported; convert to one of EME2000, GCRF, ICRF, ITRF, TEME",
  "content: AEM line 3: the quaternion's length is 1.2, not 1",
  "the OEM says nothing between 2015-02-27T17:44:00.000Z and 2015-02-28T00:00:00.000Z; it covers " +
    "2015-02-27T17:28:00.000Z to 2015-02-27T17:44:00.000Z",
  "while it is in sight it stands farther off nadir than the 40 deg of smallsat-120kg",
  "session 1: the target stands 41.2 deg off nadir at 2015-02-27T17:37:00.2Z, more than the 40 deg of smallsat-120kg; " +
    "choose other times",
  "session 2: the body needs about 41.2 s to turn by 60.12 deg, but 30.0 s are available, in which no slew fits (about the " +
    "Euler axis it would take 1.8 of the acceleration limit); begin the session later or start the slew nearer to it",
  "tracker 1: at 2015-02-27T17:37:00.2Z the body stands 3.2 deg nearer to the Sun than allowed, on its way or idling; " +
    "choose another time, attitude or exclusion",
  "session 1: star_trackers stands 2.1 deg nearer to Sun, Moon and the Earth's limb than allowed at 2015-02-27T17:37:00.2Z; choose " +
    "other times, or another roll",
  "3 rows of the attitude are no unit quaternions and were left out",
])("refusals of detours, keyholes, bodies and messages in Russian: %s", (text) => {
  const told = service.told(text);
  expect(told).not.toBe(text);
  expect(told).not.toMatch(/ (the|is|at|of|not) /);
  for (const figure of text.match(FIGURE) ?? []) expect(told).toContain(figure);
});

test("signs of patterns are no signs of expressions", () => {
  expect(tellerBy({ "costs 1.5 $ (a+b?) for {n}": "стоит {n}" })("costs 1.5 $ (a+b?) for 3")).toBe("стоит 3");
});
