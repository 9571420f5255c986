/** Windows of an imaging mode: one for each pass in which all of its scans are in view, of the scans' windows. */
import type { Schemas } from "../../api/client";
import { rfc3339 } from "../../i18n/forms";

/** With all that the page's searches include. */
export type Window = Required<Schemas["WindowOut"]>;

export const GRID_MS = 200; // of the command table
const APART_MS = 1_200_000; // a pass is over sooner, the next comes later
const LEAD_MS = 10_000; // before the first of looks at given angles, which begin when they come
const SLEW_MS = 25_000; // between scans near each other, and settling

/** What a session of the mode begins with: its scans follow one another as soon as the slews let them. */
export function wholePasses(windows: readonly Window[], mode: string): Window[] {
  const lead_ms = mode.endsWith("stereo") ? LEAD_MS : 0;
  return passesOf(windows).flatMap((pass) => ofPass(pass, lead_ms) ?? []);
}

/** Windows that belong to one pass each, in order of time. */
export function passesOf<W extends { rise: string }>(windows: readonly W[]): W[][] {
  const passes: W[][] = [];
  const sorted = [...windows].sort((one, other) => Date.parse(one.rise) - Date.parse(other.rise));
  for (const one of sorted) {
    const last = passes[passes.length - 1];
    const first = last?.[0];
    if (last && first && Date.parse(one.rise) - Date.parse(first.rise) < APART_MS) last.push(one);
    else passes.push([one]);
  }
  return passes;
}

/** From the first rise to the last set, and the window in which it is highest. */
export function spanOf(windows: readonly Window[]) {
  return {
    rise_ms: Math.min(...windows.map((one) => Date.parse(one.rise))),
    set_ms: Math.max(...windows.map((one) => Date.parse(one.set))),
    highest: windows.reduce((best, one) => (one.highest_deg > best.highest_deg ? one : best)),
  };
}

/** null unless all scans of one number are there. */
function ofPass(pass: readonly Window[], lead_ms: number): Window | null {
  const count = pass[0]?.scan?.parts ?? 0;
  const scans = Array.from({ length: count }, (_, k) => pass.find(({ scan, session }) => scan?.part === k + 1 && session));
  const [first] = scans;
  if (!first?.session || !first.scan || !scans.every((one) => one !== undefined)) return null;
  if (count === 1) return first;
  const { rise_ms, set_ms, highest } = spanOf(scans);
  const scanned_ms = scans.reduce(
    (sum, { session }) => sum + (session ? Date.parse(session.stop) - Date.parse(session.start) : 0),
    0,
  );
  const needed_ms = scanned_ms + (count - 1) * SLEW_MS;
  const middle_ms = (rise_ms + set_ms) / 2;
  const { first_start, last_start } = first.scan;
  const soonest_ms = Date.parse(first_start ?? first.session.start);
  const latest_ms = Date.parse(last_start ?? first.session.start);
  const start_ms = Math.min(Math.max(middle_ms - needed_ms / 2, soonest_ms), latest_ms) - lead_ms;
  return {
    ...highest,
    rise: rfc3339(rise_ms),
    set: rfc3339(set_ms),
    duration_s: (set_ms - rise_ms) / 1000,
    session: {
      ...first.session,
      start: rfc3339(Math.ceil(start_ms / GRID_MS) * GRID_MS),
      stop: rfc3339(Math.ceil(set_ms / GRID_MS) * GRID_MS),
    },
  };
}
