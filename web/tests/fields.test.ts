/** Fields of the form: they come from the schema, have words in both languages, and lose nothing. */
import { readFileSync } from "node:fs";

import { expect, test } from "vitest";
import { fieldsOf, type ObjectSchema } from "../schema.fields";
import { FORMS } from "../schema.lists";
import { FIELDS } from "../src/api/fields";
import { fields as EN } from "../src/i18n/en/fields";
import { fields as RU } from "../src/i18n/ru/fields";
import {
  begin,
  beginUnion,
  type FieldSpec,
  faultOf,
  faultsOf,
  numberOf,
  type Shape,
  stepsOf,
  unknownIn,
} from "../src/parts/fields/shape";

const schemas = () =>
  (JSON.parse(readFileSync("openapi.json", "utf8")) as { components: { schemas: Record<string, ObjectSchema> } }).components
    .schemas;
const example = JSON.parse(readFileSync("../examples/las_vegas_2015.json", "utf8")) as Record<string, unknown>;
const EVERY: [string, string, FieldSpec][] = Object.entries(FIELDS).flatMap(([schema, fields]) =>
  Object.entries(fields).map(([name, field]): [string, string, FieldSpec] => [schema, name, field]),
);
const session = (target: object) => ({
  ...example,
  sessions: [{ target, start: "2015-02-27T17:36:20Z", stop: "2015-02-27T17:37:50Z" }],
});

test("the form has every field of the schema that it was built with", () => {
  expect(FIELDS).toEqual(fieldsOf(schemas(), FORMS));
  for (const name of ["PlanRequest", "GroundPathTarget", "KeepOut", "FieldMask", "AxisDrive", "HorizonCamera"]) {
    expect(Object.keys(FIELDS[name] ?? {})).toEqual(Object.keys(schemas()[name]?.properties ?? {}));
  }
});

test("a field that is new in the schema is in the form, with unit, range and default", () => {
  const changed = schemas();
  const cone = changed.KeepOut?.properties;
  if (cone)
    cone.margin_deg = { type: "number", minimum: 0, maximum: 45, default: 1, "x-unit": "deg", description: "Spare. Unit: deg." };
  const expected = { shape: { kind: "number", least: 0, most: 45, unit: "deg" }, text: "Spare.", unless: 1 };
  expect(fieldsOf(changed, FORMS).KeepOut?.margin_deg).toEqual(expected);
});

test.each(EVERY.filter(([, , { shape }]) => shape.kind !== "constant"))(
  "%s.%s has a Russian label",
  (schema, name, { shape }) => {
    // What tells kinds apart is chosen by kind.
    const isByPanel = ["on_conflict"].includes(name);
    expect(RU.labels[`${schema}.${name}`] ?? RU.labels[name] ?? (isByPanel ? "" : undefined)).toBeDefined();
    if (shape.kind === "choice" && schema !== "PlanRequest") {
      for (const one of shape.of) expect(RU.values[one] ?? one.toUpperCase()).toBe(RU.values[one] ?? one);
    }
    if (shape.kind === "union") for (const one of Object.keys(shape.of)) expect(RU.values[one]).toBeDefined();
    if (shape.kind === "number" && shape.unit) expect(RU.units[shape.unit] ?? EN.units[shape.unit]).toBeDefined();
  },
);

test("Russian has no words for fields that are gone", () => {
  const known = new Set(EVERY.flatMap(([schema, name]) => [name, `${schema}.${name}`]));
  expect(Object.keys({ ...RU.labels, ...RU.texts, ...EN.labels, ...EN.texts }).filter((name) => !known.has(name))).toEqual([]);
});

test.each(EVERY)("what is begun of %s.%s is nothing that the schema refuses", (_, __, { shape, example }) => {
  const begun = begin(FIELDS, shape, example);
  const fields = { Root: { one: { shape, text: "", isRequired: true } } };
  const faults = faultsOf({ ...FIELDS, ...fields }, "Root", { one: begun });
  // A text may be empty at first: nobody can make up a message.
  expect(faults.filter(({ fault }) => fault.kind !== "missing")).toEqual([]);
});

test("the packaged example is without fault, and its faults are told by path", () => {
  expect(faultsOf(FIELDS, "PlanRequest", example)).toEqual([]);
  const wrong = session({ mode: "ground", latitude_deg: 95, longitude_deg: "east" });
  expect(faultsOf(FIELDS, "PlanRequest", wrong)).toEqual([
    { path: "sessions.0.target.latitude_deg", fault: { kind: "range", least: -90, most: 90, unit: "deg" } },
    { path: "sessions.0.target.longitude_deg", fault: { kind: "number" } },
  ]);
  const cones = { ...example, slew: { keep_out: [{ half_angle_deg: 25, direction_lvlh: [0, "x", 1] }, {}] } };
  expect(faultsOf(FIELDS, "PlanRequest", cones).map(({ path }) => path)).toEqual([
    "slew.keep_out.0.direction_lvlh.1",
    "slew.keep_out.1.half_angle_deg",
  ]);
});

test("members that the form has no fields for are named", () => {
  expect(unknownIn(FIELDS, "PlanRequest", example)).toEqual([]);
  const strange = {
    ...session({ mode: "ground", latitude_deg: 1, longitude_deg: 2, datum: "NAD27" }),
    slew: { keep_out: [{ half_angle_deg: 2, colour: 1 }], lead: { max_duration_s: 5, since: 1 } },
    initial_state: { angles_deg: { alpha: 1 } },
    weather: "fine",
  };
  expect(unknownIn(FIELDS, "PlanRequest", strange).sort()).toEqual([
    "sessions.0.target.datum",
    "slew.keep_out.0.colour",
    "slew.lead.since",
    "weather",
  ]);
  expect(unknownIn(FIELDS, "PlanRequest", session({ mode: "comet" }))).toEqual(["sessions.0.target"]);
});

test("a platform written out is looked at by its kind", () => {
  const { kind, name, agility, camera } = begin(FIELDS, { kind: "object", of: "BodyPlatform" }) as Record<string, unknown>;
  const platform = { kind: kind ?? "body", name, agility, camera, off_nadir_max_deg: 95 };
  expect(unknownIn(FIELDS, "PlanRequest", { ...example, platform })).toEqual([]);
  expect(faultsOf(FIELDS, "PlanRequest", { ...example, platform })).toEqual([
    { path: "platform.off_nadir_max_deg", fault: { kind: "range", least: 0.1, most: 90, unit: "deg" } },
  ]);
});

test("a path is told in steps, entries of lists by numbers from 1", () => {
  const request = session({ mode: "ground_path", points: [{}, {}], speed_m_s: 1 });
  expect(stepsOf(FIELDS, "PlanRequest", request, "sessions.0.target.points.1.latitude_deg")).toEqual([
    { name: "sessions", number: 1 },
    { name: "target" },
    { name: "points", number: 2 },
    { name: "latitude_deg" },
  ]);
});

test.each([
  ["1.5", 1.5],
  [" 0,25 ", 0.25],
  ["−4", -4],
  ["1e3", 1000],
  ["", undefined],
  ["1.5 km", "1.5 km"],
])("typed %s is %s, and what is no number stays to be mended", (typed, value) => {
  expect(numberOf(typed)).toBe(value);
});

test("a value of a union begins with what it can't be without", () => {
  const target = FIELDS.Session?.target?.shape as Extract<Shape, { kind: "union" }>;
  expect(Object.keys(beginUnion(FIELDS, target, "ground_path"))).toEqual(["mode", "points", "speed_m_s"]);
  expect(beginUnion(FIELDS, target, "body").mode).toBe("body");
  expect(faultOf({ kind: "instant" }, "yesterday")).toEqual({ kind: "instant" });
});
