/** Passes of the spacecraft over the requested areas, as the service finds them. */
import { post, remove, type Schemas } from "../../api/client";
import { reachOf } from "../../api/orbit";
import { rfc3339 } from "../../i18n/forms";
import { passesOf, type Window } from "../planning/scans";
import { type Asked, askedOf, type SessionRequest } from "./session";

export interface Found {
  from_ms: number;
  to_ms: number;
  /** In order of time, each as much as one session may hold. */
  passes: readonly Pass[];
  /** Names of what no pass shows whole. */
  unseen: readonly string[];
  warnings: readonly string[];
}

/** What one session can image, told by the window in which it is highest. */
export interface Pass extends Omit<Window, "session"> {
  session: { start: string; stop: string };
  seen: readonly Window[];
}

const DAY_MS = 86_400_000;
const SAMPLES = 21;
const ASKED = { include: "view", limit: 1000 };
// From orbital orientation to the farthest look, or back: 54 deg at 1.58 deg/s about each axis, and settling.
const TURN_MS = 60_000;
const ROW_MS = 200; // of the command table

export type Search = Pick<SessionRequest, "orbit" | "spacecraft" | "settings" | "requests"> & {
  from_ms: number;
  days: number;
};

export async function findPasses({ from_ms, days, ...search }: Search, until: AbortSignal): Promise<Found> {
  const { orbit, spacecraft, settings } = search;
  const last_ms = reachOf(orbit)?.to_ms ?? Infinity;
  const wanted_ms = from_ms + days * DAY_MS;
  const to_ms = last_ms > from_ms ? Math.min(wanted_ms, last_ms) : wanted_ms;
  const limits = [settings?.along_max_deg, settings?.across_max_deg].filter((one) => one != null);
  const body = {
    platform: spacecraft,
    orbit,
    targets: askedOf(search as SessionRequest).map((one) => ({ id: one.name, target: modeOf(one) })),
    conditions: limits.length ? { max_off_nadir_deg: Math.max(...limits) } : {},
    start: rfc3339(from_ms),
    stop: rfc3339(to_ms),
    samples: SAMPLES,
  };
  const given = { query: ASKED, signal: until };
  const { id, windows, unseen, warnings } = await post("/v1/opportunities", body, given);
  // Kept by the service for who wants it; ours is seen once.
  void remove("/v1/opportunities/{id}", { id }).catch(() => undefined);
  return {
    from_ms,
    to_ms,
    passes: passesOf((windows as Window[]).filter((one) => one.session)).map(sessionOf),
    unseen,
    warnings,
  };
}

/** A request of a session as the imaging mode it is. */
function modeOf({ name: _, priority: __, scan_speed_m_s, start, window_start, window_stop, ...mode }: Asked) {
  return { ...mode, line: "plane", speed_m_s: scan_speed_m_s } as Schemas["StripMode"];
}

function sessionOf(seen: readonly Window[]): Pass {
  const start_ms = Math.min(...seen.map((one) => Date.parse(one.rise))) - TURN_MS;
  const stop_ms = Math.max(...seen.map((one) => Date.parse(one.set))) + TURN_MS;
  const onRow = (ms: number, round: (count: number) => number) => rfc3339(round(ms / ROW_MS) * ROW_MS);
  const session = { start: onRow(start_ms, Math.floor), stop: onRow(stop_ms, Math.ceil) };
  const highest = seen.reduce((best, one) => (one.highest_deg > best.highest_deg ? one : best));
  return { ...highest, session, seen };
}
