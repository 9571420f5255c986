/** Shapes of a request's fields, and values of them: begun, checked, described. */

export type Shape =
  | { kind: "number"; least?: number; most?: number; unit?: string; isWhole?: boolean }
  | { kind: "text" }
  | { kind: "instant" }
  | { kind: "flag" }
  | { kind: "json" }
  | { kind: "constant"; value: string }
  | { kind: "choice"; of: readonly string[] }
  | { kind: "object"; of: string }
  /** Objects told apart by a member's value. */
  | { kind: "union"; by: string; of: Readonly<Record<string, string>> }
  | { kind: "either"; of: readonly Shape[] }
  | { kind: "vector"; of: readonly Shape[] }
  | { kind: "list"; of: Shape; most?: number }
  /** Values by names that aren't the schema's, such as the axes'. */
  | { kind: "map"; of: Shape };

export interface FieldSpec {
  shape: Shape;
  /** The service's own description. */
  text: string;
  isRequired?: boolean;
  isNullable?: boolean;
  /** Taken by the service unless something is given. */
  unless?: unknown;
  example?: unknown;
}
export type Fields = Record<string, FieldSpec>;
/** Fields of all schemas, by a schema's name. */
export type Book = Readonly<Record<string, Fields>>;
export type Members = Readonly<Record<string, unknown>>;

export type Fault = { kind: "range"; least?: number; most?: number; unit?: string } | { kind: "number" | "instant" | "missing" };

export function isMembers(value: unknown): value is Members {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

/** The schema that an object of a union follows. */
export function schemaOf(shape: Shape, value: unknown): string | null {
  if (shape.kind === "object") return shape.of;
  if (shape.kind === "union" && isMembers(value)) return shape.of[String(value[shape.by])] ?? null;
  return null;
}

/** Which of several forms a value has; -1 for none. */
export function formOf(book: Book, forms: readonly Shape[], value: unknown): number {
  return forms.findIndex((form) => {
    if (form.kind === "constant") return value === form.value;
    if (form.kind === "choice") return typeof value === "string";
    if (form.kind === "list" || form.kind === "vector") return Array.isArray(value);
    if (form.kind === "text") return typeof value === "string";
    return isMembers(value) && (form.kind !== "object" || isOfKind(book[form.of] ?? {}, value));
  });
}

/** Whether the members that tell the kind are this schema's, or left out. */
function isOfKind(fields: Fields, value: Members): boolean {
  return Object.entries(fields).every(
    ([name, { shape }]) => shape.kind !== "constant" || value[name] === undefined || value[name] === shape.value,
  );
}

/** The shape with the choices and forms left out that are listed by the field's name: "PlanRequest.final_state.rest". */
export function without(shape: Shape, listed: readonly string[], field: string): Shape {
  const isHere = (one: string) => !listed.includes(`${field}.${one}`);
  if (shape.kind === "choice") return { ...shape, of: shape.of.filter(isHere) };
  if (shape.kind !== "either") return shape;
  const forms = shape.of.filter((one) => one.kind !== "object" || isHere(one.of)).map((one) => without(one, listed, field));
  const [only] = forms;
  return only && forms.length === 1 ? only : { ...shape, of: forms };
}

/** A new value to go on from: only members without which there is none. */
export function begin(book: Book, shape: Shape, example?: unknown): unknown {
  if (shape.kind === "object") return beginObject(book, shape.of);
  if (shape.kind === "union") {
    const [first] = Object.keys(shape.of);
    return beginUnion(book, shape, first ?? "");
  }
  if (example !== undefined) return example;
  if (shape.kind === "number") return Math.min(Math.max(0, shape.least ?? 0), shape.most ?? 0);
  if (shape.kind === "vector") return shape.of.map((one) => begin(book, one));
  if (shape.kind === "list") return [];
  if (shape.kind === "map") return {};
  if (shape.kind === "constant") return shape.value;
  if (shape.kind === "choice") return shape.of[0];
  if (shape.kind === "either" && shape.of[0]) return begin(book, shape.of[0]);
  if (shape.kind === "flag") return true;
  if (shape.kind === "json") return {};
  return "";
}

export function beginUnion(book: Book, shape: Extract<Shape, { kind: "union" }>, which: string): Members {
  return { ...beginObject(book, shape.of[which] ?? ""), [shape.by]: which };
}

/** Members of which some are needed although the schema requires none: those to begin with. */
const NEEDED: Readonly<Record<string, readonly string[]>> = {
  KeepOut: ["body"],
  FinalAngles: ["park"],
  Exclusion: ["away_from", "min_deg"],
};

function beginObject(book: Book, schema: string): Members {
  const fields = Object.entries(book[schema] ?? {}).filter(([name, field]) => field.isRequired || NEEDED[schema]?.includes(name));
  return Object.fromEntries(fields.map(([name, field]) => [name, begin(book, field.shape, field.example)]));
}

/** What is wrong with a value by itself; its members are looked at on their own. */
export function faultOf(shape: Shape, value: unknown): Fault | null {
  if (value === undefined || value === null) return null;
  if (shape.kind === "number") {
    if (typeof value !== "number" || !Number.isFinite(value)) return { kind: "number" };
    const isWithin = value >= (shape.least ?? -Infinity) && value <= (shape.most ?? Infinity);
    return isWithin ? null : { kind: "range", least: shape.least, most: shape.most, unit: shape.unit };
  }
  if (shape.kind === "instant" && !Number.isFinite(Date.parse(String(value)))) return { kind: "instant" };
  return null;
}

/** An entry as JSON has it; what is no number stays as it is typed, so that nothing is lost. */
export function numberOf(typed: string): number | string | undefined {
  const text = typed.trim().replace(",", ".").replace("−", "-");
  if (text === "") return undefined;
  return Number.isFinite(Number(text)) ? Number(text) : typed;
}

export interface Place {
  path: string;
  fault: Fault;
}

/** Every fault of an object and of what is in it, by its dotted path. */
export function faultsOf(book: Book, schema: string, value: unknown, path = ""): Place[] {
  const fields = book[schema];
  if (!fields || !isMembers(value)) return [];
  return Object.entries(fields).flatMap(([name, field]) => {
    const at = path ? `${path}.${name}` : name;
    const given = value[name];
    if (given === undefined || given === "") {
      return field.isRequired ? [{ path: at, fault: { kind: "missing" } as const }] : [];
    }
    return faultsIn(book, field.shape, given, at);
  });
}

function faultsIn(book: Book, shape: Shape, value: unknown, path: string): Place[] {
  const fault = faultOf(shape, value);
  if (fault) return [{ path, fault }];
  if (shape.kind === "object" || shape.kind === "union") return faultsOf(book, schemaOf(shape, value) ?? "", value, path);
  if (shape.kind === "either") {
    const form = shape.of[formOf(book, shape.of, value)];
    return form ? faultsIn(book, form, value, path) : [];
  }
  if (Array.isArray(value) && (shape.kind === "list" || shape.kind === "vector")) {
    return value.flatMap((one, number) => {
      const of = shape.kind === "list" ? shape.of : shape.of[number];
      return of ? faultsIn(book, of, one, `${path}.${number}`) : [];
    });
  }
  if (shape.kind === "map" && isMembers(value)) {
    return Object.entries(value).flatMap(([name, one]) => faultsIn(book, shape.of, one, `${path}.${name}`));
  }
  return [];
}

/** Dotted paths of members that the schema doesn't know. */
export function unknownIn(book: Book, schema: string, value: unknown, path = ""): string[] {
  const fields = book[schema];
  if (!fields || !isMembers(value)) return [];
  return Object.entries(value).flatMap(([name, given]) => {
    const at = path ? `${path}.${name}` : name;
    const field = fields[name];
    if (given === undefined) return [];
    return field ? unknownWithin(book, field.shape, given, at) : [at];
  });
}

function unknownWithin(book: Book, shape: Shape, value: unknown, path: string): string[] {
  if (shape.kind === "object") return unknownIn(book, shape.of, value, path);
  if (shape.kind === "union") {
    const schema = schemaOf(shape, value);
    return schema ? unknownIn(book, schema, value, path) : [path];
  }
  if (shape.kind === "either") {
    const form = shape.of[formOf(book, shape.of, value)];
    return form ? unknownWithin(book, form, value, path) : value === null ? [] : [path];
  }
  if (shape.kind === "list" && Array.isArray(value)) {
    return value.flatMap((one, number) => unknownWithin(book, shape.of, one, `${path}.${number}`));
  }
  if (shape.kind === "map" && isMembers(value)) {
    return Object.entries(value).flatMap(([name, one]) => unknownWithin(book, shape.of, one, `${path}.${name}`));
  }
  return [];
}

/** A path's steps as they are named: fields by their names, entries of lists by their numbers from 1. */
export function stepsOf(book: Book, schema: string, value: unknown, path: string): { name: string; number?: number }[] {
  const steps: { name: string; number?: number }[] = [];
  let [shape, now]: [Shape | null, unknown] = [{ kind: "object", of: schema }, value];
  for (const part of path.split(".")) {
    const last = steps.at(-1);
    if (shape?.kind === "either") shape = shape.of[formOf(book, shape.of, now)] ?? null;
    const within: string | null = shape && schemaOf(shape, now);
    if (/^\d+$/.test(part) && last && !within) {
      last.number = Number(part) + 1;
      now = Array.isArray(now) ? now[Number(part)] : undefined;
      shape = shape?.kind === "list" ? shape.of : shape?.kind === "vector" ? (shape.of[Number(part)] ?? null) : null;
      continue;
    }
    steps.push({ name: part });
    shape = within ? (book[within]?.[part]?.shape ?? null) : shape?.kind === "map" ? shape.of : null;
    now = isMembers(now) ? now[part] : undefined;
  }
  return steps;
}
