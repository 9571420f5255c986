/** Fields of a request as a form needs them, read from the service's schema. */
import type { Fields, Shape } from "./src/parts/fields/shape.ts";

/** A node of the schema, as far as requests use it. */
export interface Node {
  $ref?: string;
  type?: string;
  const?: unknown;
  enum?: string[];
  format?: string;
  minimum?: number;
  maximum?: number;
  maxItems?: number;
  prefixItems?: Node[];
  items?: Node;
  additionalProperties?: Node | boolean;
  anyOf?: Node[];
  oneOf?: Node[];
  discriminator?: { propertyName: string; mapping: Record<string, string> };
  default?: unknown;
  description?: string;
  examples?: unknown[];
  "x-unit"?: string;
}
export interface ObjectSchema {
  properties: Record<string, Node>;
  required?: string[];
  description?: string;
}

const NONE = "1"; // the unit of what has none

/** The schemas that the named ones reach, each with its fields in the schema's order. */
export function fieldsOf(schemas: Record<string, ObjectSchema>, roots: readonly string[]): Record<string, Fields> {
  const found: Record<string, Fields> = {};
  const visit = (name: string): string => {
    const { properties, required = [] } = schemas[name] ?? { properties: {} };
    if (name in found) return name;
    const fields: Fields = {};
    found[name] = fields;
    for (const [field, node] of Object.entries(properties)) {
      const { shape, isNullable } = shapeOf(node, node["x-unit"], visit);
      fields[field] = {
        shape,
        text: told(node.description ?? ""),
        ...(required.includes(field) && { isRequired: true }),
        ...(isNullable && { isNullable }),
        ...(isPlain(node.default) && { unless: node.default }),
        ...(node.examples?.[0] !== undefined && { example: node.examples[0] }),
      };
    }
    return name;
  };
  for (const root of roots) visit(root);
  return found;
}

function isPlain(value: unknown): boolean {
  return value !== undefined && value !== null && value !== "" && !(Array.isArray(value) && value.length === 0);
}

/** Without what the form shows anyway: unit, kinds, default. */
function told(description: string): string {
  return description
    .replace(/ Unit: [^.]*\.$/, "")
    .replace(/ Left out: `.*`\.$/s, "")
    .replace(/ `\w+` is one of (`\w+`(, )?)+\.$/, "")
    .replaceAll("`", "");
}

function shapeOf(node: Node, unit: string | undefined, visit: (name: string) => string): { shape: Shape; isNullable: boolean } {
  const forms = node.anyOf ?? node.oneOf;
  if (node.discriminator) {
    const { propertyName: by, mapping } = node.discriminator;
    const of = Object.fromEntries(Object.entries(mapping).map(([value, ref]) => [value, visit(nameOf(ref))]));
    return { shape: { kind: "union", by, of }, isNullable: false };
  }
  if (forms) {
    const others = forms.filter((one) => one.type !== "null");
    const isNullable = others.length < forms.length;
    const shapes = others.map((one) => shapeOf(one, unit, visit).shape);
    const [first] = shapes;
    return { shape: shapes.length === 1 && first ? first : { kind: "either", of: shapes }, isNullable };
  }
  return { shape: plainShapeOf(node, unit, visit), isNullable: false };
}

function plainShapeOf(node: Node, unit: string | undefined, visit: (name: string) => string): Shape {
  const inner = (one: Node): Shape => shapeOf(one, unit, visit).shape;
  if (node.$ref) return { kind: "object", of: visit(nameOf(node.$ref)) };
  if (node.const !== undefined) return { kind: "constant", value: String(node.const) };
  if (node.enum?.length === 1) return { kind: "constant", value: String(node.enum[0]) };
  if (node.enum) return { kind: "choice", of: node.enum };
  if (node.type === "boolean") return { kind: "flag" };
  if (node.type === "string") return { kind: node.format === "date-time" ? "instant" : "text" };
  if (node.type === "number" || node.type === "integer") {
    return {
      kind: "number",
      ...(node.minimum !== undefined && { least: node.minimum }),
      ...(node.maximum !== undefined && { most: node.maximum }),
      ...(unit !== undefined && unit !== NONE && { unit }),
      ...(node.type === "integer" && { isWhole: true }),
    };
  }
  if (node.prefixItems) return { kind: "vector", of: node.prefixItems.map(inner) };
  if (node.items) return { kind: "list", of: inner(node.items), ...(node.maxItems !== undefined && { most: node.maxItems }) };
  if (typeof node.additionalProperties === "object") return { kind: "map", of: inner(node.additionalProperties) };
  return { kind: "json" };
}

function nameOf(ref: string): string {
  return ref.replace(/^.*\//, "");
}
