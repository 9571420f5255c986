/** Passes of the spacecraft over the requested areas, as the service finds them. */
import { post, remove, type Schemas } from "../../api/client";
import { reachOf } from "../../api/orbit";
import { rfc3339 } from "../../i18n/forms";
import { type Asked, askedOf, type SessionRequest } from "./session";

/** A scan in a pass, with its view. */
export type Opportunity = Required<Schemas["WindowOut"]>;

export interface Found {
  from_ms: number;
  to_ms: number;
  opportunities: readonly Opportunity[];
  /** In order of time, each as much as one session may hold. */
  passes: readonly Pass[];
  /** Names of what no pass shows whole. */
  unseen: readonly string[];
  warnings: readonly string[];
}

/** What one session can image. */
export interface Pass {
  start: string;
  stop: string;
  seen: readonly Opportunity[];
}

const DAY_MS = 86_400_000;
const SAMPLES = 21;
const ASKED = { include: "view", limit: 1000 };
const LONGEST_MS = 3_600_000; // of a session, as the service takes it
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
  const { id, windows: found, unseen, warnings } = await post("/v1/opportunities", body, given);
  const windows = found as Opportunity[];
  // Kept by the service for who wants it; ours is seen once.
  void remove("/v1/opportunities/{id}", { id }).catch(() => undefined);
  return { from_ms, to_ms, opportunities: windows, passes: passesOf(windows), unseen, warnings };
}

/** A request of a session as the imaging mode it is. */
function modeOf({ name: _, priority: __, scan_speed_m_s, start, window_start, window_stop, ...mode }: Asked) {
  return { ...mode, line: "plane", speed_m_s: scan_speed_m_s } as Schemas["StripMode"];
}

function passesOf(opportunities: readonly Opportunity[]): Pass[] {
  const passes: { start_ms: number; stop_ms: number; seen: Opportunity[] }[] = [];
  const sorted = [...opportunities].sort((one, other) => Date.parse(one.rise) - Date.parse(other.rise));
  for (const one of sorted) {
    if (!one.session) continue;
    const start_ms = Math.floor((Date.parse(one.rise) - TURN_MS) / ROW_MS) * ROW_MS;
    const stop_ms = Math.ceil((Date.parse(one.set) + TURN_MS) / ROW_MS) * ROW_MS;
    const pass = passes[passes.length - 1];
    if (pass && start_ms <= pass.stop_ms && stop_ms - pass.start_ms <= LONGEST_MS) {
      pass.stop_ms = Math.max(pass.stop_ms, stop_ms);
      pass.seen.push(one);
    } else passes.push({ start_ms, stop_ms, seen: [one] });
  }
  return passes.map(({ start_ms, stop_ms, seen }) => ({ start: rfc3339(start_ms), stop: rfc3339(stop_ms), seen }));
}

/** The pass seen from highest: by it a session of several is told. */
export function highest({ seen }: Pass): Opportunity {
  return seen.reduce((best, one) => (one.highest_deg > best.highest_deg ? one : best));
}
