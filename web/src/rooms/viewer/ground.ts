/** A plan's lines on the ground: traces, and the outlines of the camera's frame. */
import { type LonLat, ringOf, wrap } from "../../map/places";
import type { View } from "./view";

export interface Trace {
  latitude_deg: readonly (number | null)[];
  longitude_deg: readonly (number | null)[];
}

const POINTS = 600; // more than a screen shows
const FOOTPRINTS = 24; // outlines along the sessions
const ARCSEC_PER_DEG = 3600;

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
  return ringOf(corners);
}

const ELLIPSE_POINTS = 48;

/** Where the target may be on the ground, within 1 sigma: the ellipse of the image, laid between the
    frame's corners that the service tells and moved to the target; empty outside of sessions. */
export function ellipseAt(view: View, row: number): LonLat[] {
  const [longitudes, latitudes] = [view.footprint.longitude_deg[row] ?? [], view.footprint.latitude_deg[row] ?? []];
  const { sigma_major_arcsec, sigma_minor_arcsec, major_turn_deg } = view.pointing;
  const [major, minor, turn_deg] = [sigma_major_arcsec[row], sigma_minor_arcsec[row], major_turn_deg[row]];
  const [first = 0, second = 0] = view.frame_deg.map((side) => (side * ARCSEC_PER_DEG) / 2);
  const corners = longitudes.flatMap((longitude, k): LonLat[] => {
    const latitude = latitudes[k];
    return longitude === null || latitude == null ? [] : [[wrap(longitude - (longitudes[0] ?? 0)), latitude]];
  });
  if (corners.length !== 4 || major == null || minor == null) return [];
  const turn = ((turn_deg ?? 0) * Math.PI) / 180;
  // The corners are on the ellipsoid; a target above it is seen before that point.
  const target = view.targets.find((one) => one.session === view.session[row]);
  const [longitude, latitude] = [target?.longitude_deg[row], target?.latitude_deg[row]];
  const middle = [0, 1].map((part) => corners.reduce((all, corner) => all + (corner[part] ?? 0) / 4, 0));
  const aside: LonLat =
    longitude == null || latitude == null
      ? [0, 0]
      : [wrap(longitude - (longitudes[0] ?? 0) - (middle[0] ?? 0)), latitude - (middle[1] ?? 0)];
  return Array.from({ length: ELLIPSE_POINTS + 1 }, (_, k) => {
    const around = (-2 * Math.PI * k) / ELLIPSE_POINTS;
    const [along, across] = [major * Math.cos(around), minor * Math.sin(around)];
    const u = (along * Math.cos(turn) - across * Math.sin(turn)) / first;
    const v = (along * Math.sin(turn) + across * Math.cos(turn)) / second;
    // From +X +Y on, counter-clockwise as the camera sees them.
    const shares = [(1 + u) * (1 + v), (1 - u) * (1 + v), (1 - u) * (1 - v), (1 + u) * (1 - v)];
    const sum = (part: 0 | 1) => corners.reduce((all, corner, c) => all + ((shares[c] ?? 0) * corner[part]) / 4, 0);
    return [wrap((longitudes[0] ?? 0) + sum(0) + aside[0]), sum(1) + aside[1]];
  });
}
