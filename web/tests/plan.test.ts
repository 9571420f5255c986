/** A plan under its identity, and the judgement of it. */
import { afterEach, expect, test } from "vitest";

import "./page";

import example from "../../examples/las_vegas_2015.json";

const { language } = await import("../src/i18n/language");
const { fileNameOf, identityOf } = await import("../src/rooms/plan/identity");
const { checksum, quoted } = await import("../src/parts/paper");
const { gradeOf, isAtLimit, leastExclusion, leastMargin } = await import("../src/rooms/plan/verdict");
type Plan = Parameters<typeof gradeOf>[0];
type Request = NonNullable<Parameters<typeof identityOf>[1]>;

const asked = example as unknown as Request;
const at = "2015-02-27T17:36:20.000Z";
const margin = (limit: number, left: number) => ({ limit, extreme: limit - left, margin: left, unit: "deg", t_s: 0, at });

function plan(probability: number | null, margins: object, passed = true): Plan {
  return {
    id: "01a20e39-7bd2-70b0-bb90-61875908cde4",
    revision: 1,
    summary: {
      name: "Las Vegas",
      platform: "iss-hrc",
      targets: ["Las Vegas"],
      start: at,
      stop: "2015-02-27T17:37:50.000Z",
      probability_in_frame: probability,
      sessions: [],
    },
    verification: { passed },
    provenance: { input_sha256: "b2d69c13e09bd137848dc3aadc1b1c82" },
    margins: { alpha: margins },
    keep_out: [],
    masks: [],
    exclusions: [],
  } as unknown as Plan;
}

afterEach(() => {
  language.value = "en";
});

test("a plan is told from any other: when, by what, on which orbit and attitude, which revision", () => {
  const told = identityOf(plan(0.95, {}), asked);
  expect(told).toEqual([
    "27 Feb 2015 17:36:20–17:37:50 UTC",
    "iss-hrc",
    "TLE of 27 Feb 2015 11:33 (6 h old)",
    "LVLH -4/-2/1",
    "revision 1",
  ]);
  expect(checksum(plan(0.95, {}).provenance.input_sha256)).toBe("SHA-256 b2d69c13e09b");
  expect(identityOf(plan(0.95, {}), null)).not.toContain("LVLH -4/-2/1");
});

test("elements that are younger than the plan, and ephemerides, are told as such", () => {
  const later = { ...asked, orbit: { source: "state", epoch: "2015-02-27T18:06:20Z" } } as unknown as Request;
  expect(identityOf(plan(1, {}), later)[2]).toBe("STATE of 27 Feb 2015 18:06 (0.5 h after the start)");
  const oem = "CCSDS_OEM_VERS = 2.0\nSTART_TIME = 2015-02-27T00:00:00\nSTOP_TIME = 2015-02-28T00:00:00";
  const ephemeris = { ...asked, orbit: { source: "oem", content: oem } } as unknown as Request;
  expect(identityOf(plan(1, {}), ephemeris)[2]).toBe("OEM 27 Feb 2015 00:00–28 Feb 2015 00:00");
});

test("a file's name says what, when and which revision", () => {
  expect(fileNameOf(plan(1, {}))).toBe("Las_Vegas_20150227T173620Z_r1_5908cde4");
});

test("a name can't break out of the paper's header", () => {
  expect(quoted('a "b" \\ c\n')).toBe('"a \\22 b\\22  \\5c  c\\a "');
});

test.each([
  ["bad", 0.99, { rate: margin(3, 2) }, false],
  ["good", 0.99, { rate: margin(3, 2), angle_max: margin(175, 158) }, true],
  ["good", 0.9, { rate: margin(3, 0) }, true],
  ["good", null, {}, true],
  ["warn", 0.178, { rate: margin(3, 2) }, true],
  ["warn", 0.99, { angle_min: margin(-175, 0.035) }, true],
] as const)("a plan is judged %s", (grade, probability, margins, passed) => {
  expect(gradeOf(plan(probability, margins, passed))).toBe(grade);
});

test("a slew at its rate limit is at the limit; an angle on its stop isn't", () => {
  const least = (margins: object) => {
    const one = leastMargin(plan(1, margins));
    return one && isAtLimit(one);
  };
  expect(least({ rate: margin(3, 1.8e-8) })).toBe(true);
  expect(least({ angle_min: margin(-175, 0.035) })).toBe(false);
  expect(least({ rate: margin(3, 1) })).toBe(false);
  expect(least({ rate: margin(3, 0), angle_min: margin(-175, 0.035) })).toBe(false); // what the verdict warns of is told
});

test("the exclusion that is kept by least is told, and on it a plan is doubtful", () => {
  const kept = (...margins: (number | null)[]) => ({
    ...plan(1, {}),
    exclusions: margins.map((margin_deg, number) => ({ name: `${number}`, margin_deg, at: margin_deg === null ? null : at })),
  });
  expect(leastExclusion(kept(40, null, 12.5))).toEqual({ name: "2", margin_deg: 12.5, at });
  expect(leastExclusion(kept(null))).toBeNull();
  expect(gradeOf(kept(40, null, 12.5))).toBe("good");
  expect(gradeOf(kept(40, 1e-5))).toBe("warn");
});
