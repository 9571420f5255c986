/** Ground track, Sun and shadow of an orbit over days, as the service computes them. */
import { post, type Schemas } from "../api/client";
import type { Orbit } from "../api/orbit";
import { Problem } from "../api/problem";
import { rfc3339 } from "../i18n/forms";
import type { LonLat } from "./places";

export type Track = Schemas["OrbitTrackResponse"];

const MOST_DAYS = 31;
const DAY_MS = 86_400_000;
const tracks = new Map<string, Track>();

/** Ground track and eclipses, a row each so many seconds; why there are none where the service refuses. */
export async function fetchTrack(
  orbit: Orbit,
  [from_ms, to_ms]: readonly [number, number],
  step_s: number,
  until: AbortSignal,
): Promise<Track | Problem | null> {
  if (to_ms - from_ms > MOST_DAYS * DAY_MS) return null;
  const request = { orbit, start: rfc3339(from_ms), stop: rfc3339(to_ms), step_s };
  const key = JSON.stringify(request);
  try {
    const track = tracks.get(key) ?? (await post("/v1/orbits/tracks", request, { signal: until }));
    tracks.set(key, track);
    return track;
  } catch (error) {
    if (error instanceof Problem) return error;
    throw error;
  }
}

/** The places below the carrier from one instant to another, in lines. */
export function linesIn({ start, t_s, carrier }: Track, from_ms: number, to_ms: number): LonLat[][] {
  const start_ms = Date.parse(start);
  const lines: LonLat[][] = [[]];
  for (const [row, t] of t_s.entries()) {
    const at_ms = start_ms + 1000 * t;
    const [longitude, latitude] = [carrier.longitude_deg[row], carrier.latitude_deg[row]];
    if (at_ms < from_ms || at_ms > to_ms) continue;
    if (longitude == null || latitude == null) lines.push([]);
    else lines[lines.length - 1]?.push([longitude, latitude]);
  }
  return lines.filter((line) => line.length > 1);
}

/** Where carrier and Sun stand at the row nearest to an instant. */
export function rowAt({ start, t_s, carrier, sun }: Track, at_ms: number): { carrier: LonLat; sun: LonLat } | null {
  const t = (at_ms - Date.parse(start)) / 1000;
  const after = t_s.findIndex((one) => one >= t);
  const row = after <= 0 ? Math.max(after, 0) : t - (t_s[after - 1] ?? 0) < (t_s[after] ?? 0) - t ? after - 1 : after;
  const place = ({ longitude_deg, latitude_deg }: typeof sun | typeof carrier): LonLat | null => {
    const [longitude, latitude] = [longitude_deg[row], latitude_deg[row]];
    return longitude == null || latitude == null ? null : [longitude, latitude];
  };
  const [below, overhead] = [place(carrier), place(sun)];
  return below && overhead ? { carrier: below, sun: overhead } : null;
}
