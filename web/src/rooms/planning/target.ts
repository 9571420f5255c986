/** A target as a person types it. */

import type { Schemas } from "../../api/client";
import { FIELDS } from "../../api/fields";
import { type Geometry, isMode, POSITIONS, positionsOf } from "../../map/modes";

export type Target = Schemas["Session"]["target"];
export type Path = Schemas["GroundPathTarget"];
export type Point = Schemas["PathPoint"];

export const BODIES = ["sun", "moon", "mercury", "venus", "mars", "jupiter", "saturn"] as const;

/** Modes of the service; a place's name and coordinates are entered alike. */
export const KINDS: readonly string[] = (() => {
  const shape = FIELDS.Session?.target?.shape;
  return shape?.kind === "union" ? Object.keys(shape.of).filter((mode) => mode !== "place") : [];
})();

/** The shape of an imaging mode; of what is half typed none. */
export function geometryIn(target: Target | undefined): Geometry | null {
  const geometry = target && "geometry" in target ? (target.geometry as Partial<Geometry> | null) : null;
  return Array.isArray(geometry?.coordinates) ? (geometry as Geometry) : null;
}

/** Whether an imaging mode has the positions that it takes. */
export function isDrawn(target: Target): boolean {
  const geometry = geometryIn(target);
  if (!geometry || !isMode(target.mode)) return false;
  const isOnePart = geometry.type === "LineString" || geometry.type === "Polygon";
  return !isOnePart || positionsOf(geometry).length >= POSITIONS[target.mode].least;
}

export function kindOf(target: Target): string {
  return target.mode === "place" ? "ground" : target.mode;
}

/** The schema that a target of this mode follows. */
export function schemaOfMode(mode: string): string | null {
  const shape = FIELDS.Session?.target?.shape;
  return shape?.kind === "union" ? (shape.of[mode] ?? null) : null;
}

/** Coordinates or a place's name; null for nothing. */
export function groundOf(text: string): Target | null {
  const point = pointOf(text);
  if (point) return { mode: "ground", ...point };
  const name = text.trim();
  return name ? { mode: "place", name } : null;
}

// One angle: degrees, or degrees, minutes and seconds, with a letter before or after.
const NUMBER = String.raw`\d+(?:[.]\d+)?`;
const SIZE = String.raw`([+\-−]?)(${NUMBER})(?:(?:\s*[°d:]\s*|\s+)(${NUMBER})(?:(?:\s*['′m:]\s*|\s+)(${NUMBER})\s*(?:["″s]|''|′′)?|\s*['′m])?|\s*°)?`;
const BEFORE = String.raw`([NSEW])\s*${SIZE}()`;
const AFTER = String.raw`()${SIZE}\s*([NSEW])`;
const PLAIN = String.raw`()([+\-−]?)(${NUMBER})()()\s*°?\s*([NSEW]?)`;
const HEIGHT = String.raw`(?:\s*[,;\s]\s*([+\-−]?${NUMBER})\s*m?)?`;
// Minutes and seconds want letters: "46 3 14 30" may be anything.
const PAIRS = [PLAIN, BEFORE, AFTER].map((angle) => new RegExp(String.raw`^\s*${angle}\s*[,;\s]\s*${angle}${HEIGHT}\s*$`, "i"));

/** "36.11, -115.17", "36.11 N 115.17 W", "46 3 25 N 14 30 36 E", with the height in metres as a third number. */
export function pointOf(text: string): Point | null {
  const found = PAIRS.reduce<RegExpExecArray | null>((known, pair) => known ?? pair.exec(text), null);
  if (!found) return null;
  const [one, other] = [angleOf(found, 1), angleOf(found, 7)];
  const isSwapped = /[EW]/i.test(one.letter) && /[NS]/i.test(other.letter);
  const [latitude, longitude] = isSwapped ? [other, one] : [one, other];
  if (/[EW]/i.test(latitude.letter) || /[NS]/i.test(longitude.letter)) return null;
  return {
    latitude_deg: latitude.degrees,
    longitude_deg: longitude.degrees,
    height_m: Number((found[13] ?? "0").replace("−", "-")),
  };
}

function angleOf(found: RegExpExecArray, at: number): { degrees: number; letter: string } {
  const [before = "", sign = "", whole = "0", minutes = "0", seconds = "0", after = ""] = found.slice(at, at + 6);
  const letter = before || after;
  const size = Number(whole) + Number(minutes) / 60 + Number(seconds) / 3600;
  const isNegative = /[SW]/i.test(letter) !== /[-−]/.test(sign);
  return { degrees: Number((isNegative ? -size : size).toFixed(7)) + 0, letter };
}

/** A name, a Hipparcos number, or right ascension and declination in degrees. */
export function starOf(text: string): Target | null {
  const name = text.trim();
  const hip = /^(?:HIP\s*)?(\d{1,6})$/i.exec(name);
  if (hip) return { mode: "star", hip: Number(hip[1]) };
  const place = /^(\d+(?:\.\d+)?)\s*°?\s*[,;\s]\s*([+\-−]?\d+(?:\.\d+)?)\s*°?$/.exec(name);
  if (place) return { mode: "star", ra_deg: Number(place[1]), dec_deg: Number((place[2] ?? "").replace("−", "-")) };
  return name ? { mode: "star", name } : null;
}

/** What stands in the text field for a target, and in lists. */
export function textOf(target: Target): string {
  if (target.mode === "ground" || target.mode === "ground_moving" || target.mode === "station") {
    const height = target.height_m ? `, ${target.height_m}` : "";
    return `${target.latitude_deg}, ${target.longitude_deg}${height}`;
  }
  if (target.mode === "place") return target.name;
  if (target.mode === "star") return target.name ?? (target.hip ? `HIP ${target.hip}` : `${target.ra_deg}, ${target.dec_deg}`);
  if (target.mode === "body") return target.name;
  if (target.mode === "ground_path")
    return target.points.map(({ latitude_deg: n, longitude_deg: e }) => `${n}, ${e}`).join(" – ");
  return target.mode;
}

const EARTH_M = 6_371_000;
const RAD = Math.PI / 180;

/** Over a sphere, which places a session well enough; metres. */
export function lengthOf(points: readonly Point[]): number {
  return points.slice(1).reduce((sum, point, number) => sum + distance(points[number] ?? point, point), 0);
}

function distance(one: Point, other: Point): number {
  const [north, east] = [other.latitude_deg - one.latitude_deg, other.longitude_deg - one.longitude_deg];
  const half =
    Math.sin((north * RAD) / 2) ** 2 +
    Math.cos(one.latitude_deg * RAD) * Math.cos(other.latitude_deg * RAD) * Math.sin((east * RAD) / 2) ** 2;
  return 2 * EARTH_M * Math.asin(Math.min(1, Math.sqrt(half)));
}

/** The point halfway along. */
export function middleOf(points: readonly Point[]): Point | null {
  let left = lengthOf(points) / 2;
  for (const [number, point] of points.slice(1).entries()) {
    const from = points[number] ?? point;
    const leg = distance(from, point);
    if (left <= leg) {
      const share = leg ? left / leg : 0;
      const east = ((point.longitude_deg - from.longitude_deg + 540) % 360) - 180;
      const between = (a: number, b: number) => Number((a + share * (b - a)).toFixed(6));
      return {
        latitude_deg: between(from.latitude_deg, point.latitude_deg),
        longitude_deg: between(from.longitude_deg, from.longitude_deg + east),
        height_m: between(from.height_m ?? 0, point.height_m ?? 0),
      };
    }
    left -= leg;
  }
  return points[0] ?? null;
}

const SCAN_S = 60;
const [SLOWEST_M_S, FASTEST_M_S] = [1, 10_000];

/** The speed at which a path takes a minute: what is taken until somebody says otherwise. */
export function easySpeed(points: readonly Point[]): number {
  return Math.min(FASTEST_M_S, Math.max(SLOWEST_M_S, Math.round(lengthOf(points) / SCAN_S)));
}

/** The path with other points; a speed of its own stays. */
export function withPoints(path: Path | null, points: readonly Point[]): Path {
  const isOwn = path !== null && path.points.length > 1 && path.speed_m_s !== easySpeed(path.points);
  return { ...path, mode: "ground_path", points: [...points], speed_m_s: isOwn ? path.speed_m_s : easySpeed(points) };
}

/** Time from a path's first point to its last; seconds. */
export function durationOf(path: Path): number {
  return lengthOf(path.points) / path.speed_m_s;
}
