/** An imaging session's request and answer. */
import { get, type Schemas } from "../../api/client";
import { type LonLat, ringOf } from "../../map/places";

export type SessionRequest = Schemas["ImagingPlanRequest"];
export type Asked = Schemas["StripRequest"] | Schemas["StereoRequest"] | Schemas["AreaRequest"] | Schemas["CorridorRequest"];
export type Mode = Asked["mode"];
export type Session = Schemas["SpacecraftPlanResponse"];

export const PATH = "/v1/spacecraft/plans/{id}";
export const MODES = ["strip", "stereo", "corridor", "area"] as const satisfies readonly Mode[];
/** How many positions a mode takes. */
export const POSITIONS: Record<Mode, { least: number; most: number }> = {
  strip: { least: 2, most: 2 },
  stereo: { least: 2, most: 2 },
  corridor: { least: 2, most: 64 },
  area: { least: 3, most: 63 },
};

/** The session, or the job that makes it. */
export function fetchSession(id: string, signal: AbortSignal): Promise<Session | Schemas["JobResponse"]> {
  return get(PATH, { id, signal });
}

export function isSession(answer: Session | Schemas["JobResponse"]): answer is Session {
  return "table" in answer;
}

export function fetchRequest(id: string, until: AbortSignal): Promise<SessionRequest> {
  return get("/v1/spacecraft/plans/{id}/request", { id, signal: until }) as Promise<SessionRequest>;
}

/** What is asked, however the request holds it. */
export function askedOf({ requests }: SessionRequest): Asked[] {
  if (Array.isArray(requests)) return requests;
  const { features } = (requests ?? {}) as { features?: unknown };
  return Array.isArray(features) ? features.flatMap((one) => ofFeature(one as GeoJSON.Feature) ?? []) : [];
}

/** The requests of a GeoJSON text; null where it holds none. */
export function askedOfGeoJson(text: string): Asked[] | null {
  let read: unknown;
  try {
    read = JSON.parse(text);
  } catch {
    return null;
  }
  const { features, type } = (read ?? {}) as { features?: unknown; type?: unknown };
  const list = type === "Feature" ? [read] : features;
  if (!Array.isArray(list)) return null;
  const asked = list.map((one, index) => ofFeature(one as GeoJSON.Feature, index));
  return asked.length > 0 && asked.every((one) => one !== null) ? asked : null;
}

/** Properties are the other members, as the service reads them; a mode that isn't said follows from the shape. */
function ofFeature({ geometry, properties, id }: GeoJSON.Feature, index = 0): Asked | null {
  if (geometry?.type !== "Polygon" && geometry?.type !== "LineString") return null;
  const mode = geometry.type === "Polygon" ? "area" : geometry.coordinates.length === 2 ? "strip" : "corridor";
  return { name: String(id ?? `${mode} ${index + 1}`), mode, ...properties, geometry } as Asked;
}

export function positionsOf({ geometry }: Asked): LonLat[] {
  const positions = geometry?.type === "Polygon" ? geometry.coordinates[0] : geometry?.coordinates;
  return (positions ?? []).map(([lon = 0, lat = 0]) => [lon, lat]);
}

export function shapeOf(asked: Asked): GeoJSON.Geometry {
  const positions = positionsOf(asked);
  return asked.geometry?.type === "Polygon"
    ? { type: "Polygon", coordinates: [ringOf(positions)] }
    : { type: "LineString", coordinates: positions };
}

/** A request of positions set on the map; its name differs from the others'. */
export function drawn(mode: Mode, positions: readonly LonLat[], others: readonly Asked[]): Asked {
  const names = new Set(others.map((one) => one.name));
  let number = others.filter((one) => one.mode === mode).length + 1;
  while (names.has(`${mode} ${number}`)) number++;
  const first = positions[0] ?? [0, 0];
  const geometry =
    mode === "area"
      ? { type: "Polygon", coordinates: [[...positions, first]] }
      : { type: "LineString", coordinates: [...positions] };
  return { mode, name: `${mode} ${number}`, priority: 1, geometry } as Asked;
}
