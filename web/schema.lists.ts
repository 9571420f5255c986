/** Lists and fields that the page takes from the service's schema: `node schema.lists.ts` writes src/api/lists.ts and fields.ts. */
import { readFileSync, writeFileSync } from "node:fs";

import { fieldsOf, type Node, type ObjectSchema } from "./schema.fields.ts";

/** Whose fields the page's forms are made of. */
export const FORMS = ["PlanRequest", "OpportunityConditions", "CampaignTarget", "ImagingPlanRequest"];

interface Schema {
  components: { schemas: Record<string, ObjectSchema> };
  paths: Record<string, { get: { parameters: { name: string; schema: { enum?: string[] } }[] } }>;
}

/** Each list by its name, in the schema's order. */
export function listsOf({ components: { schemas }, paths }: Schema): Record<string, string[]> {
  const member = (schema: string, name: string): Node => schemas[schema]?.properties[name] ?? {};
  const forms = (schema: string, name: string) => Object.entries(member(schema, name).discriminator?.mapping ?? {});
  const formats = (path: string) => paths[path]?.get.parameters.find(({ name }) => name === "format")?.schema.enum ?? [];
  const hasOwn = (ref: string, name: string) => name in (schemas[ref.replace(/^.*\//, "")]?.properties ?? {});
  // Windows of imaging modes are those of their scans: the form puts them together.
  const searched = forms("OpportunityTarget", "target").filter(([, ref]) => !hasOwn(ref, "geometry"));
  return {
    ORBIT_SOURCES: forms("PlanRequest", "orbit").map(([source]) => source),
    SEARCHED_MODES: searched.map(([mode]) => mode),
    EARTH_FIXED_MODES: searched.filter(([, ref]) => hasOwn(ref, "min_elevation_deg")).map(([mode]) => mode),
    PLAN_FORMATS: formats("/v1/plans/{id}/table"),
    JOB_STATES: member("JobResponse", "state").enum ?? [],
    CONFLICTS: member("PlanRequest", "on_conflict").enum ?? [],
  };
}

if (import.meta.main) {
  const schema = JSON.parse(readFileSync("openapi.json", "utf8")) as Schema;
  const lists = Object.entries(listsOf(schema));
  const empty = lists.find(([, list]) => list.length === 0);
  if (empty) throw new Error(`the schema has nothing for ${empty[0]}: schema.lists.ts looks in the wrong place`);
  const text = lists.map(([name, list]) => `export const ${name} = ${JSON.stringify(list)} as const;\n`).join("");
  writeFileSync("src/api/lists.ts", `/** Lists of the service's schema, written by schema.lists.ts. */\n${text}`);
  const fields = JSON.stringify(fieldsOf(schema.components.schemas, FORMS));
  writeFileSync(
    "src/api/fields.ts",
    `/** Fields of the service's requests, written by schema.lists.ts. */\nimport type { Book } from "../parts/fields/shape";\n\nexport const FIELDS: Book = ${fields};\n`,
  );
}
