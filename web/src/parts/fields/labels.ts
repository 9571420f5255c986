/** Words of a request's fields: the page's own, else made of the schema's name and text. */
import { FIELDS } from "../../api/fields";
import { words } from "../../i18n";
import { language } from "../../i18n/language";
import { type Fault, formOf, isMembers, type Members, type Shape, stepsOf } from "./shape";

const SUFFIX =
  /_(deg_s3|deg_s2|deg_s|deg2|deg|arcsec_s|arcsec|arcmin_s|km_s|m_s|km|kg_m2|kg|m2|m|s|hz|px|mas_yr|mas|per_s2|per_s|jyear|xyzw)$/;

export function labelOf(schema: string, name: string): string {
  const { labels } = words.value.fields;
  return labels[`${schema}.${name}`] ?? labels[name] ?? plainly(name.replace(SUFFIX, ""));
}

/** The service's own text where the page's language is the service's. */
export function hintOf(schema: string, name: string): string {
  const { texts } = words.value.fields;
  const own = texts[`${schema}.${name}`] ?? texts[name];
  return own ?? (language.value === "en" ? (FIELDS[schema]?.[name]?.text ?? "") : "");
}

/** A value of a list of the schema's: "minimum_time". */
export function valueLabel(value: string): string {
  return words.value.fields.values[value] ?? plainly(value);
}

export function unitOf(shape: Shape): string {
  if (shape.kind === "vector" || shape.kind === "list" || shape.kind === "map") {
    const of = shape.kind === "vector" ? shape.of[0] : shape.of;
    return of ? unitOf(of) : "";
  }
  if (shape.kind !== "number" || !shape.unit) return "";
  return words.value.fields.units[shape.unit] ?? shape.unit;
}

export function faultTold(fault: Fault): string {
  const text = words.value.fields;
  if (fault.kind !== "range") return text.faults[fault.kind];
  const unit = words.value.fields.units[fault.unit ?? ""] ?? fault.unit ?? "";
  return text.range(String(fault.least ?? "−∞"), String(fault.most ?? "∞"), unit);
}

/** "Session 2 › Target › Latitude" of "sessions.1.target.latitude_deg". */
export function pathTold(schema: string, value: unknown, path: string): string {
  let within: string | null = schema;
  let [shape, now]: [Shape | null, unknown] = [null, value];
  const told: string[] = [];
  for (const { name, number } of stepsOf(FIELDS, schema, value, path)) {
    const of: string | null = within;
    told.push(`${of ? labelOf(of, name) : name}${number === undefined ? "" : ` ${number}`}`);
    shape = of ? (FIELDS[of]?.[name]?.shape ?? null) : null;
    now = isMembers(now) ? now[name] : undefined;
    if (number !== undefined && Array.isArray(now)) now = now[number - 1];
    within = shape ? schemaWithin(shape, now) : null;
  }
  return told.join(" › ");
}

function schemaWithin(shape: Shape, value: unknown): string | null {
  if (shape.kind === "object") return shape.of;
  if (shape.kind === "union" && isMembers(value)) return shape.of[String(value[shape.by])] ?? null;
  if (shape.kind === "list" || shape.kind === "map") return schemaWithin(shape.of, value);
  if (shape.kind === "either") {
    const form = shape.of[formOf(FIELDS, shape.of, value)];
    return form ? schemaWithin(form, value) : null;
  }
  return null;
}

/** A value in a few words, for a folded box. */
export function briefOf(shape: Shape, value: unknown, schema?: string): string {
  if (value === undefined || value === null) return "";
  if (Array.isArray(value)) return shape.kind === "vector" ? value.join(", ") : value.length ? String(value.length) : "";
  if (typeof value === "string") return valueLabel(value);
  if (shape.kind === "union" && isMembers(value)) return valueLabel(String(value[shape.by]));
  const of = schema ?? schemaWithin(shape, value);
  if (isMembers(value)) return of ? membersTold(of, value) : Object.keys(value).join(", ");
  return `${String(value)} ${unitOf(shape)}`;
}

/** Names of the members that are set although they needn't be. */
export function membersTold(schema: string, value: Members): string {
  return Object.keys(value)
    .filter(
      (name) =>
        FIELDS[schema]?.[name]?.shape.kind !== "constant" && !FIELDS[schema]?.[name]?.isRequired && value[name] !== undefined,
    )
    .map((name) => labelOf(schema, name))
    .join(", ");
}

function plainly(name: string): string {
  const text = name.replace(/_/g, " ");
  return text.charAt(0).toUpperCase() + text.slice(1);
}
