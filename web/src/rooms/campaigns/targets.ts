/** Targets of a file: CSV with a heading, a JSON list, a request's, or GeoJSON. */
import { modeOf } from "../../map/modes";
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
const NUMBERS = ["priority", "session_s", "min_session_s", "looks"] as const;

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
  if (geometry?.type === "Polygon" || geometry?.type === "LineString") {
    const { name, priority, looks, mode = modeOf(geometry), ...members } = properties ?? {};
    const target = { mode, ...members, geometry } as CampaignTarget["target"];
    return { id: String(name ?? id ?? `${mode} ${index + 1}`), priority, looks, target };
  }
  if (geometry?.type !== "Point") throw new NoTargets(index + 1, "Point, LineString, Polygon");
  const [longitude_deg, latitude_deg] = geometry.coordinates;
  return ofRow({ id, ...properties, longitude_deg, latitude_deg }, index + 1);
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

function ofRow(given: Record<string, unknown>, line: number): CampaignTarget {
  const row = Object.fromEntries(Object.entries(given).map(([name, value]) => [HEADINGS[name] ?? name, value]));
  const numberOf = (name: string) => {
    const value = row[name];
    if (value === undefined || value === null || value === "") return undefined;
    const number = Number(value);
    if (!Number.isFinite(number)) throw new NoTargets(line, name);
    return number;
  };
  const [latitude_deg, longitude_deg] = [numberOf("latitude_deg"), numberOf("longitude_deg")];
  const name = String(row.id ?? "").trim();
  const place = String(row.place ?? "").trim();
  const group = String(row.group ?? "").trim();
  const asked = { session_s: SESSION_S, ...wishes(numberOf), ...(group && { group }) };
  if (latitude_deg === undefined || longitude_deg === undefined) {
    if (!place) throw new NoTargets(line, latitude_deg === undefined ? "latitude_deg" : "longitude_deg");
    return { id: name || place, ...asked, target: { mode: "place", name: place } };
  }
  return {
    id: name || `${latitude_deg} ${longitude_deg}`,
    ...asked,
    target: { mode: "ground", latitude_deg, longitude_deg, height_m: numberOf("height_m") ?? 0 },
  };
}

function wishes(numberOf: (name: string) => number | undefined): Partial<CampaignTarget> {
  return Object.fromEntries(NUMBERS.map((name) => [name, numberOf(name)]).filter(([, value]) => value !== undefined));
}
