/** A plan's lines on the ground: traces, and the outlines of the camera's frame. */
import type { View } from "./view";

/** Longitude, latitude, deg. */
export type LonLat = [number, number];

export interface Trace {
  latitude_deg: readonly (number | null)[];
  longitude_deg: readonly (number | null)[];
}

const POINTS = 600; // more than a screen shows
const FOOTPRINTS = 24; // outlines along the sessions

/** Known points in lines; who draws them cuts them at the date line. */
export function linesOf({ longitude_deg: longitudes, latitude_deg: latitudes }: Trace): LonLat[][] {
  const lines: LonLat[][] = [[]];
  const every = Math.max(1, Math.floor(longitudes.length / POINTS));
  for (let row = 0; row < longitudes.length; row++) {
    if (row % every !== 0 && row !== longitudes.length - 1) continue;
    const [longitude, latitude] = [longitudes[row], latitudes[row]];
    if (longitude == null || latitude == null) lines.push([]);
    else lines[lines.length - 1]?.push([longitude, latitude]);
  }
  return lines.filter((line) => line.length > 1);
}

/** Rows at which the frame's outline is drawn, in sessions. */
export function footprintRows(view: View): number[] {
  const rows = view.activity.flatMap((kind, row) => (kind === "track" ? [row] : []));
  const every = Math.max(1, Math.ceil(rows.length / FOOTPRINTS));
  return rows.filter((_, k) => k % every === 0);
}

/** Around the frame, clockwise as d3 wants what is inside; empty where a corner misses the Earth. */
export function footprintAt(view: View, row: number): LonLat[] {
  const [longitudes, latitudes] = [view.footprint.longitude_deg[row] ?? [], view.footprint.latitude_deg[row] ?? []];
  const corners: LonLat[] = [];
  for (const [k, longitude] of longitudes.entries()) {
    const latitude = latitudes[k];
    if (longitude === null || latitude == null) return [];
    corners.push([longitude, latitude]);
  }
  const [first] = corners;
  if (!first) return [];
  const area = corners.reduce((sum, [x, y], k) => {
    const [nextX, nextY] = corners[(k + 1) % corners.length] ?? first;
    return sum + x * nextY - nextX * y;
  }, 0);
  return area > 0 ? [first, ...corners.slice(1).reverse(), first] : [...corners, first];
}
