/** Imaging modes as they are drawn: positions set one after another, which make their geometry. */
import { type LonLat, ringOf } from "./places";

export const MODES = ["strip", "stereo", "tri_stereo", "corridor", "area"] as const;
export type Mode = (typeof MODES)[number];
export type Geometry = GeoJSON.LineString | GeoJSON.MultiLineString | GeoJSON.Polygon | GeoJSON.MultiPolygon;

/** How many positions a mode takes. */
export const POSITIONS: Record<Mode, { least: number; most: number }> = {
  strip: { least: 2, most: 2 },
  stereo: { least: 2, most: 2 },
  tri_stereo: { least: 2, most: 2 },
  corridor: { least: 2, most: 64 },
  area: { least: 3, most: 63 },
};

export function isMode(mode: string): mode is Mode {
  return (MODES as readonly string[]).includes(mode);
}

/** Of an area its ring, closed. */
export function geometryOf(mode: Mode, positions: readonly LonLat[]): GeoJSON.LineString | GeoJSON.Polygon {
  const [first = [0, 0]] = positions;
  return mode === "area"
    ? { type: "Polygon", coordinates: [[...positions, first]] }
    : { type: "LineString", coordinates: [...positions] };
}

/** The mode that a shape has where none is said. */
export function modeOf({ type, coordinates }: Geometry): Mode {
  if (type === "Polygon" || type === "MultiPolygon") return "area";
  return type === "LineString" && coordinates.length === 2 ? "strip" : "corridor";
}

/** Of a shape of one part, without the point that closes a ring; of others none. */
export function positionsOf(geometry: Geometry | null | undefined): LonLat[] {
  const isRing = geometry?.type === "Polygon";
  const positions = isRing ? geometry.coordinates[0]?.slice(0, -1) : geometry?.type === "LineString" ? geometry.coordinates : [];
  return (positions ?? []).map(([lon = 0, lat = 0]) => [lon, lat]);
}

/** Every point of a shape, however deep it lies; of what is half typed, those there are. */
export function pointsOf(coordinates: unknown): LonLat[] {
  if (!Array.isArray(coordinates)) return [];
  const [first, second]: unknown[] = coordinates;
  if (typeof first === "number" && typeof second === "number") return [[first, second]];
  return coordinates.flatMap((one) => pointsOf(one));
}

/** To be drawn: rings are wound so that d3 takes their inside; one of fewer points is a line yet. */
export function shapeOf(geometry: Geometry): GeoJSON.Geometry {
  if (geometry.type === "MultiLineString" || geometry.type === "LineString") return geometry;
  const parts = geometry.type === "Polygon" ? [geometry.coordinates] : geometry.coordinates;
  return {
    type: "MultiPolygon",
    coordinates: parts.map((rings) =>
      rings.map((ring, number) => {
        const wound = ringOf(pointsOf(ring));
        return number === 0 ? wound : wound.reverse();
      }),
    ),
  };
}
