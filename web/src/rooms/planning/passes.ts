/** The carrier's way over the Earth while it is seen, for drawing: a sphere will do. */
import type { LonLat } from "../../map/places";
import type { Window } from "./windows";

const EARTH_KM = 6371;
const RAD = Math.PI / 180;

/** The point below the carrier, seen from a place by azimuth, elevation and range. */
function below(place: LonLat, azimuth_deg: number, elevation_deg: number, range_km: number): LonLat {
  const sine = Math.sin(elevation_deg * RAD);
  const radius_km = Math.sqrt(EARTH_KM ** 2 + range_km ** 2 + 2 * EARTH_KM * range_km * sine);
  const away = Math.asin(Math.min(1, (range_km * Math.cos(elevation_deg * RAD)) / radius_km));
  return along(place, azimuth_deg, away);
}

/** So far (radians) from a place in a direction. */
function along([lon, lat]: LonLat, azimuth_deg: number, away: number): LonLat {
  const [phi, theta] = [lat * RAD, azimuth_deg * RAD];
  const sine = Math.sin(phi) * Math.cos(away) + Math.cos(phi) * Math.sin(away) * Math.cos(theta);
  const east = Math.atan2(Math.sin(theta) * Math.sin(away) * Math.cos(phi), Math.cos(away) - Math.sin(phi) * sine);
  return [((lon + east / RAD + 540) % 360) - 180, Math.asin(sine) / RAD];
}

/** The ground track of a pass over a place: from rise by culmination to set. */
export function groundTrack(window: Window): LonLat[] {
  const { place, sky, through } = window;
  if (!place || !sky) return [];
  const seen: LonLat = [place.longitude_deg, place.latitude_deg];
  return [sky.rise, sky.culmination, sky.set].flatMap((point) => {
    const range_km = rangeAt(through, Date.parse(point.at));
    return range_km === null ? [] : [below(seen, point.azimuth_deg, point.elevation_deg, range_km)];
  });
}

function rangeAt(through: Window["through"], at_ms: number): number | null {
  let nearest: number | null = null;
  let away_ms = Infinity;
  for (const [index, at] of through.at.entries()) {
    const gap_ms = Math.abs(Date.parse(at) - at_ms);
    if (gap_ms < away_ms) [nearest, away_ms] = [through.range_km[index] ?? null, gap_ms];
  }
  return nearest;
}

/** Half the angle of the circle within which the carrier must be below to be seen so high; degrees. */
export function circleOf(window: Window, leastElevation_deg: number): number | null {
  const { range_km, elevation_deg } = window.closest;
  if (range_km === null || !window.place) return null;
  const sine = Math.sin(elevation_deg * RAD);
  const radius_km = Math.sqrt(EARTH_KM ** 2 + range_km ** 2 + 2 * EARTH_KM * range_km * sine);
  const least = leastElevation_deg * RAD;
  return (Math.acos((EARTH_KM / radius_km) * Math.cos(least)) - least) / RAD;
}
