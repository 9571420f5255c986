/** The lists that the page takes from the service's schema: `node schema.lists.ts` writes src/api/lists.ts. */
import { readFileSync, writeFileSync } from "node:fs";

interface Schema {
  components: { schemas: Record<string, { properties: Record<string, Member> }> };
  paths: Record<string, { get: { parameters: { name: string; schema: { enum?: string[] } }[] } }>;
}
interface Member {
  enum?: string[];
  discriminator?: { mapping: Record<string, string> };
}

/** Each list by its name, in the schema's order. */
export function listsOf({ components: { schemas }, paths }: Schema): Record<string, string[]> {
  const member = (schema: string, name: string): Member => schemas[schema]?.properties[name] ?? {};
  const forms = (schema: string, name: string) => Object.entries(member(schema, name).discriminator?.mapping ?? {});
  const formats = (path: string) => paths[path]?.get.parameters.find(({ name }) => name === "format")?.schema.enum ?? [];
  const searched = forms("OpportunityTarget", "target");
  const hasOwn = (ref: string, name: string) => name in (schemas[ref.replace(/^.*\//, "")]?.properties ?? {});
  return {
    ORBIT_SOURCES: forms("PlanRequest", "orbit").map(([source]) => source),
    SEARCHED_MODES: searched.map(([mode]) => mode),
    EARTH_FIXED_MODES: searched.filter(([, ref]) => hasOwn(ref, "min_elevation_deg")).map(([mode]) => mode),
    PLAN_FORMATS: formats("/v1/plans/{id}/table"),
    SESSION_FORMATS: formats("/v1/spacecraft/plans/{id}/table"),
    JOB_STATES: member("JobResponse", "state").enum ?? [],
    CONFLICTS: member("PlanRequest", "on_conflict").enum ?? [],
    OBJECTIVES: member("ImagingPlanRequest", "objective").enum ?? [],
  };
}

if (import.meta.main) {
  const lists = Object.entries(listsOf(JSON.parse(readFileSync("openapi.json", "utf8")) as Schema));
  const empty = lists.find(([, list]) => list.length === 0);
  if (empty) throw new Error(`the schema has nothing for ${empty[0]}: schema.lists.ts looks in the wrong place`);
  const text = lists.map(([name, list]) => `export const ${name} = ${JSON.stringify(list)} as const;\n`).join("");
  writeFileSync("src/api/lists.ts", `/** Lists of the service's schema, written by schema.lists.ts. */\n${text}`);
}
