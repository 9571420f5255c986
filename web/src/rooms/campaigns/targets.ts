/** Targets of a file: CSV with a heading, a JSON list, a request's, or GeoJSON. */
import { FIELDS } from "../../api/fields";
import { type Geometry, isMode, modeOf } from "../../map/modes";
import type { CampaignTarget } from "./campaign";

export const SESSION_S = 40; // of a look whose file doesn't say
const HEADINGS: Record<string, string> = {
  name: "id",
  city: "id",
  lat: "latitude_deg",
  latitude: "latitude_deg",
  lon: "longitude_deg",
  lng: "longitude_deg",
  longitude: "longitude_deg",
  height: "height_m",
};
const SHAPES = ["LineString", "MultiLineString", "Polygon", "MultiPolygon"];
const MEMBERS = FIELDS.CampaignTarget ?? {};

/** Which line of a file holds no target, and what is missing there. */
export class NoTargets extends Error {
  constructor(
    readonly line: number | null,
    readonly missing: string,
  ) {
    super(missing);
  }
}

/** Raises NoTargets. */
export function targetsOf(text: string): CampaignTarget[] {
  const content = text.replace(/^\uFEFF/, "").trim();
  if (!content.startsWith("{") && !content.startsWith("[")) return ofCsv(content);
  let read: unknown;
  try {
    read = JSON.parse(content);
  } catch (caught) {
    throw new NoTargets(null, String(caught));
  }
  const { targets, type } = read as { targets?: unknown; type?: unknown };
  const features = type === "Feature" ? [read] : (read as { features?: unknown }).features;
  if (Array.isArray(features)) return features.map((feature, index) => ofFeature(feature as GeoJSON.Feature, index));
  const list = Array.isArray(read) ? read : targets;
  if (!Array.isArray(list)) throw new NoTargets(null, "targets");
  return list.map((one: Record<string, unknown>, index) =>
    one.target ? (one as unknown as CampaignTarget) : ofRow(one, index + 1),
  );
}

/** A point, or a shape as the imaging mode that its properties say, or that follows from it. */
function ofFeature({ geometry, properties, id }: GeoJSON.Feature, index: number): CampaignTarget {
  if (geometry && SHAPES.includes(geometry.type)) {
    const { name, mode = modeOf(geometry as Geometry), ...members } = properties ?? {};
    const among = (isOwn: boolean) => Object.fromEntries(Object.entries(members).filter(([one]) => one in MEMBERS === isOwn));
    const target = { mode, ...among(false), geometry } as CampaignTarget["target"];
    return { ...among(true), id: String(name ?? members.id ?? id ?? `${mode} ${index + 1}`), target };
  }
  if (geometry?.type !== "Point") throw new NoTargets(index + 1, ["Point", ...SHAPES].join(", "));
  const [longitude_deg, latitude_deg, height_m] = geometry.coordinates;
  return ofRow({ id, ...properties, longitude_deg, latitude_deg, ...(height_m !== undefined && { height_m }) }, index + 1);
}

function ofCsv(content: string): CampaignTarget[] {
  const [heading = "", ...lines] = content.split(/\r?\n/).filter((line) => line.trim() && !line.startsWith("#"));
  const separator = [";", "\t", ","].find((one) => heading.includes(one)) ?? ",";
  const names = cells(heading, separator).map((name) => HEADINGS[name.toLowerCase()] ?? name.toLowerCase());
  if (lines.length === 0) throw new NoTargets(1, "id, latitude_deg, longitude_deg");
  return lines.map((line, index) => {
    const values = cells(line, separator);
    return ofRow(Object.fromEntries(names.map((name, column) => [name, values[column] ?? ""])), index + 2);
  });
}

/** Cells of a line, those in quotes as they are between them. */
function cells(line: string, separator: string): string[] {
  const found: string[] = [];
  for (const match of line.matchAll(new RegExp(`(?:^|${separator})(?:"((?:[^"]|"")*)"|([^${separator}]*))`, "g"))) {
    found.push((match[1]?.replace(/""/g, '"') ?? match[2] ?? "").trim());
  }
  return found;
}

/** Columns are a target's fields, "target.mode" and "roll.rule" too; others, such as a town's people, are left alone. */
function ofRow(given: Record<string, unknown>, line: number): CampaignTarget {
  const told = Object.entries(given).filter(([, value]) => value !== undefined && value !== null && value !== "");
  const row: Record<string, unknown> = Object.fromEntries(told.map(([name, value]) => [HEADINGS[name] ?? name, value]));
  const numberOf = (name: string) => {
    const number = Number(row[name]);
    if (row[name] !== undefined && !Number.isFinite(number)) throw new NoTargets(line, name);
    return row[name] === undefined ? undefined : number;
  };
  const own: Record<string, unknown> = {};
  for (const [name, value] of Object.entries(row)) {
    const [first = "", ...path] = name.split(".");
    const kind = MEMBERS[first]?.shape.kind;
    if (kind !== undefined && path.length > 0) put(own, [first, ...path], typeof value === "string" ? cellValue(value) : value);
    else if (kind === "number") own[name] = numberOf(name);
    else if (kind === "text" || kind === "instant") own[name] = String(value);
    else if (kind !== undefined && typeof value === "object") own[name] = value;
  }
  const target = (own.target ?? placeOf(row, numberOf, line)) as CampaignTarget["target"];
  const { latitude_deg, longitude_deg, name } = target as Record<string, unknown>;
  return {
    ...(!isMode(target.mode) && { session_s: SESSION_S }),
    ...own,
    id: String(own.id ?? name ?? `${latitude_deg} ${longitude_deg}`),
    target,
  };
}

function placeOf(row: Record<string, unknown>, numberOf: (name: string) => number | undefined, line: number) {
  const [latitude_deg, longitude_deg] = [numberOf("latitude_deg"), numberOf("longitude_deg")];
  if (latitude_deg !== undefined && longitude_deg !== undefined)
    return { mode: "ground", latitude_deg, longitude_deg, height_m: numberOf("height_m") ?? 0 };
  if (row.place === undefined) throw new NoTargets(line, latitude_deg === undefined ? "latitude_deg" : "longitude_deg");
  return { mode: "place", name: String(row.place) };
}

function put(inside: Record<string, unknown>, [first = "", ...rest]: string[], value: unknown) {
  const within = (inside[first] ?? {}) as Record<string, unknown>;
  if (rest.length > 0) put(within, rest, value);
  inside[first] = rest.length > 0 ? within : value;
}

/** JSON, or else text, as the command reads a cell. */
function cellValue(cell: string): unknown {
  try {
    return JSON.parse(cell);
  } catch {
    return cell;
  }
}
