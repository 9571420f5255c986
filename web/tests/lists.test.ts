/** Lists of modes, sources and formats come from the schema and stand nowhere else in the page. */
import { globSync, readFileSync } from "node:fs";

import { expect, test } from "vitest";

import { listsOf } from "../schema.lists";
import * as LISTS from "../src/api/lists";

type Schema = Parameters<typeof listsOf>[0];
const schema = () => JSON.parse(readFileSync("openapi.json", "utf8")) as Schema;

test("the page holds the lists of the schema that it was built with", () => {
  expect({ ...LISTS }).toEqual(listsOf(schema()));
  for (const list of Object.values(LISTS)) expect(list.length).toBeGreaterThan(1);
});

test("what is new in the schema is in the lists", () => {
  const changed = schema();
  const { schemas } = changed.components;
  const forms = (name: string, member: string) => schemas[name]?.properties[member]?.discriminator?.mapping ?? {};
  forms("OpportunityTarget", "target").ground_offset = "#/components/schemas/GroundOffsetTarget";
  forms("OpportunityTarget", "target").barycentre = "#/components/schemas/BarycentreTarget";
  forms("PlanRequest", "orbit").keplerian = "#/components/schemas/KeplerianOrbit";
  schemas.GroundOffsetTarget = { properties: { min_elevation_deg: {} } };
  schemas.BarycentreTarget = { properties: {} };
  for (const { name, schema } of changed.paths["/v1/plans/{id}/table"]?.get.parameters ?? []) {
    if (name === "format") schema.enum?.push("tsv");
  }
  const lists = listsOf(changed);
  expect(lists.SEARCHED_MODES).toEqual([...LISTS.SEARCHED_MODES, "ground_offset", "barycentre"]);
  expect(lists.EARTH_FIXED_MODES).toEqual([...LISTS.EARTH_FIXED_MODES, "ground_offset"]);
  expect(lists.ORBIT_SOURCES).toEqual([...LISTS.ORBIT_SOURCES, "keplerian"]);
  expect(lists.PLAN_FORMATS).toEqual([...LISTS.PLAN_FORMATS, "tsv"]);
});

test("modes with a least elevation are those on the ground", () => {
  expect(LISTS.EARTH_FIXED_MODES).toContain("ground");
  expect(LISTS.EARTH_FIXED_MODES).not.toContain("star");
});

test.each(Object.entries(LISTS))("no other module spells %s", (_, list) => {
  const modules = globSync("src/**/*.{ts,tsx}").filter((path) => !/^src\/(i18n\/..\/|api\/(fields|lists|schema)\.ts)/.test(path));
  expect(modules.length).toBeGreaterThan(100);
  const spelling = modules.filter((path) => {
    const code = readFileSync(path, "utf8").replace(/\/\*[\s\S]*?\*\/|\/\/.*/g, "");
    const literals = code.match(/[[{][^[\]{};]*[\]}]/g) ?? [];
    return literals.some((one) => list.every((name) => new RegExp(`["']${name}["']|\\b${name}: `).test(one)));
  });
  expect(spelling).toEqual([]);
});
