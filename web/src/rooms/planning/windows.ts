/** Windows of the chosen session's target: searched anew whenever something they depend on changes. */
import { effect, signal } from "@preact/signals";

import { post, remove, type Schemas } from "../../api/client";
import { EARTH_FIXED_MODES, SEARCHED_MODES } from "../../api/lists";
import { isAbort } from "../../api/problem";
import { rfc3339 } from "../../i18n/forms";
import { lightOf } from "../../windows/sight";
import * as draft from "./draft";
import type { Target } from "./target";

export type Window = Schemas["WindowOut"];

const SAMPLES = 41;
const QUIET_MS = 250; // typing isn't yet asking
const LONGEST_S = 300; // a star is seen for most of an hour; nobody asks that by a click

export interface Found {
  windows: readonly Window[];
  /** What was taken for a name. */
  assumed: string | null;
  warnings: readonly string[];
}

export const found = signal<Found | null>(null);
export const searchError = signal<unknown>(null);
export const isSearching = signal(false);
const retries = signal(0);

export function searchAgain(): void {
  retries.value++;
}

// Where the boresight comes to an edge; at the others only the sight ends.
const EDGES: ReadonlySet<string> = new Set(["reach", "across", "mask", "sun_keep_out", "moon_keep_out"]);
const AWAY_FROM_A_STOP = 0.05;
const GRID_MS = 200; // of the command table
const EDGE_MS = 1000;
const NEAR_MS = 3_600_000;

/** The window that a session lies in or near, to draw it by. */
export function windowNear(windows: readonly Window[], one: draft.DraftSession): Window | null {
  if (!one.start || !one.stop) return null;
  const middle = (Date.parse(one.start) + Date.parse(one.stop)) / 2;
  const away = (window: Window) => Math.max(0, Date.parse(window.rise) - middle, middle - Date.parse(window.set));
  const nearest = windows.reduce<Window | null>((best, window) => (!best || away(window) < away(best) ? window : best), null);
  return nearest && away(nearest) < NEAR_MS ? nearest : null;
}

/** The session that a click on a window takes: what other sessions leave of what can be held, away
    from its stops, of a long one the middle minutes; null where nothing is left. */
export function sessionIn(window: Window): { start: string; stop: string } | null {
  if (!window.session) return null;
  const free = longestFree(...held(window, window.session));
  if (!free) return null;
  const [first, last] = free;
  if (last - first <= LONGEST_S * 1000) return { start: rfc3339(first), stop: rfc3339(last) };
  const half = (LONGEST_S * 1000) / 2;
  const start = Math.round((first + last) / 2000) * 1000 - half;
  return { start: rfc3339(start), stop: rfc3339(start + 2 * half) };
}

/** What can be held, without the part next to an end that a stop, a cone, a mask or a rate makes. */
function held(window: Window, session: NonNullable<Window["session"]>): [number, number] {
  const [first, last] = [Date.parse(session.start), Date.parse(session.stop)];
  const away = Math.ceil((AWAY_FROM_A_STOP * (last - first)) / GRID_MS) * GRID_MS;
  const isFree = (by: string, gap_ms: number) => !EDGES.has(by) && gap_ms < EDGE_MS;
  return [
    isFree(window.opened_by, first - Date.parse(window.rise)) ? first : first + away,
    isFree(window.closed_by, Date.parse(window.set) - last) ? last : last - away,
  ];
}

/** Of a span of time, what the sessions beside the chosen one leave in one piece. */
function longestFree(first: number, last: number): [number, number] | null {
  const others = draft.sessions
    .peek()
    .filter((one, number) => number !== draft.chosen.peek() && one.start && one.stop)
    .map((one) => [Date.parse(one.start ?? ""), Date.parse(one.stop ?? "")] as const)
    .sort((one, other) => one[0] - other[0]);
  let [from, longest] = [first, null as [number, number] | null];
  for (const [start, stop] of [...others, [last, last] as const]) {
    const to = Math.min(start, last);
    if (to - from > (longest ? longest[1] - longest[0] : 0)) longest = [from, to];
    from = Math.max(from, stop);
  }
  return longest;
}

/** The window that a session lies in. */
export function windowOf(windows: readonly Window[], one: draft.DraftSession): Window | null {
  if (!one.start || !one.stop) return null;
  const middle = (Date.parse(one.start) + Date.parse(one.stop)) / 2;
  return windows.find((window) => Date.parse(window.rise) <= middle && middle <= Date.parse(window.set)) ?? null;
}

/** So likely to have the target in the frame, a window is good; a plan of less warns. */
export const GOOD = 0.9;

/** The soonest good one in the best light, else the likeliest, to a tenth: what is taken until the person chooses. */
export function best(windows: readonly Window[]): Window | null {
  const rank = (window: Window) => {
    const light = lightOf(window.closest.sun_elevation_deg);
    const isDark = light === "night" || light === "twilight";
    return (isDark ? 0 : 1000) + Math.floor(10 * Math.min(window.probability_in_frame ?? 0, GOOD));
  };
  return windows.reduce<Window | null>((top, one) => (one.session && (!top || rank(one) > rank(top)) ? one : top), null);
}

function isOneOf(modes: readonly string[], mode: string): boolean {
  return modes.includes(mode);
}

let last: string | null = null;

async function search(target: Target, until: AbortSignal): Promise<void> {
  isSearching.value = true;
  searchError.value = null;
  try {
    const answer = await post(
      "/v1/opportunities",
      {
        platform: draft.request.peek().platform,
        orbit: draft.orbit.peek(),
        attitude: draft.attitude.peek(),
        targets: [{ id: "target", target }],
        start: rfc3339(draft.from_ms.peek()),
        stop: rfc3339(draft.to_ms.peek()),
        conditions: isOneOf(EARTH_FIXED_MODES, target.mode) ? { min_elevation_deg: draft.leastElevation_deg.peek() } : {},
        samples: SAMPLES,
      },
      { signal: until },
    );
    found.value = {
      windows: answer.windows,
      assumed: answer.assumed[0]?.detail ?? null,
      warnings: answer.warnings,
    };
    // Kept by the service for who wants it; ours is seen once.
    if (last) void remove("/v1/opportunities/{id}", { id: last }).catch(() => undefined);
    last = answer.id;
    const taken = !draft.session.peek().start && best(answer.windows);
    const times = taken && sessionIn(taken);
    if (times) draft.setTimes(times.start, times.stop);
  } catch (error) {
    if (isAbort(error)) return;
    found.value = null;
    searchError.value = error;
  }
  isSearching.value = false;
}

/** Until the room is left. */
export function keepSearching(): () => void {
  let shown = "";
  return effect(() => {
    const target = draft.target.value;
    // Another target's windows are not to be taken for this one's.
    if (JSON.stringify(target) !== shown) found.value = null;
    shown = JSON.stringify(target);
    // What the answer depends on, whose change asks anew; times of sessions are not part of it.
    void [draft.orbit.value, draft.attitude.value, draft.from_ms.value, draft.days.value];
    void [draft.leastElevation_deg.value, retries.value];
    if (!target || !isOneOf(SEARCHED_MODES, target.mode)) {
      found.value = null;
      isSearching.value = false;
      return;
    }
    const wanted = new AbortController();
    const timer = setTimeout(() => void search(target, wanted.signal), found.peek() ? QUIET_MS : 0);
    return () => {
      clearTimeout(timer);
      wanted.abort();
    };
  });
}
