/** Windows of the chosen session's target: searched anew whenever something they depend on changes. */
import { effect, signal } from "@preact/signals";

import { post, remove, type Schemas } from "../../api/client";
import { EARTH_FIXED_MODES, SEARCHED_MODES } from "../../api/lists";
import { isAbort } from "../../api/problem";
import { rfc3339 } from "../../i18n/forms";
import { isMode } from "../../map/modes";
import { platforms } from "../../parts/platforms";
import { lightOf } from "../../windows/sight";
import * as draft from "./draft";
import { body, slewTime_s } from "./platforms";
import { type Window, wholePasses } from "./scans";
import { durationOf, isDrawn, middleOf, type Target } from "./target";

export type { Window };

const SAMPLES = 41;
const ASKED = { include: "view,probability,reasons", limit: 500 };
const QUIET_MS = 250; // typing isn't yet asking
const LONGEST_S = 300; // a star is seen for most of an hour; nobody asks that by a click

export interface Found {
  windows: readonly Window[];
  /** Why there are none. */
  unseen: Schemas["Unseen"] | null;
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
const EDGES: ReadonlySet<string> = new Set(["reach", "across", "mask", "star_trackers", "sun_keep_out", "moon_keep_out"]);
const KEPT = /^(exclusions|directions)\./;
const AWAY_FROM_A_STOP = 0.05;
const GRID_MS = 200; // of the command table
const EDGE_MS = 1000;
const LEAST_MS = 2000; // of a session
const NEAR_MS = 3_600_000;
const SAFE_SHARE = 0.98; // the path's length is known over a sphere only

/** The window that a session lies in or near, to draw it by. */
export function windowNear(windows: readonly Window[], one: draft.DraftSession): Window | null {
  if (!one.start || !one.stop) return null;
  const middle = (Date.parse(one.start) + Date.parse(one.stop)) / 2;
  const away = (window: Window) => Math.max(0, Date.parse(window.rise) - middle, middle - Date.parse(window.set));
  const nearest = windows.reduce<Window | null>((best, window) => (!best || away(window) < away(best) ? window : best), null);
  return nearest && away(nearest) < NEAR_MS ? nearest : null;
}

/** The session that a click on a window takes: what other sessions and the slews from and to them leave
    of what can be held, away from its stops, of a long one the middle minutes; null where nothing is left. */
export function sessionIn(window: Window): { start: string; stop: string } | null {
  if (!window.session) return null;
  if (isMode(draft.target.peek()?.mode ?? "")) return window.session;
  const free = longestFree(window, ...held(window, window.session));
  if (!free) return null;
  const [first, last] = free;
  const longest_ms = longestOf(draft.target.peek());
  if (last - first <= longest_ms) return { start: rfc3339(first), stop: rfc3339(last) };
  const half = longest_ms / 2;
  const start = Math.round((first + last) / 2000) * 1000 - half;
  return { start: rfc3339(start), stop: rfc3339(start + 2 * half) };
}

/** A path is scanned once; another target is held for some minutes. */
function longestOf(target: Target | undefined): number {
  if (target?.mode !== "ground_path") return LONGEST_S * 1000;
  const scan_ms = Math.floor((SAFE_SHARE * durationOf(target) * 1000) / (2 * GRID_MS)) * 2 * GRID_MS;
  return Math.max(LEAST_MS, Math.min(scan_ms, LONGEST_S * 1000));
}

/** What can be held, without the part next to an end that a stop, a cone, a mask or a rate makes. */
function held(window: Window, session: NonNullable<Window["session"]>): [number, number] {
  const [first, last] = [Date.parse(session.start), Date.parse(session.stop)];
  const away = Math.ceil((AWAY_FROM_A_STOP * (last - first)) / GRID_MS) * GRID_MS;
  const isFree = (by: string, gap_ms: number) => !EDGES.has(by) && !KEPT.test(by) && gap_ms < EDGE_MS;
  return [
    isFree(window.opened_by, first - Date.parse(window.rise)) ? first : first + away,
    isFree(window.closed_by, Date.parse(window.set) - last) ? last : last - away,
  ];
}

/** Of a span of time, what the sessions beside the chosen one leave in one piece, with time for the slews. */
function longestFree(window: Window, first: number, last: number): [number, number] | null {
  const others = draft.sessions
    .peek()
    .filter((one, number) => number !== draft.chosen.peek() && one.start && one.stop)
    .map((one) => [Date.parse(one.start ?? ""), Date.parse(one.stop ?? "")] as const)
    .sort((one, other) => one[0] - other[0]);
  let [from, longest] = [first, null as [number, number] | null];
  for (const [start, stop] of [...others, [Infinity, Infinity] as const]) {
    const to = Math.min(last, Number.isFinite(start) ? onRow(start - slewBetween_ms(window, start), Math.floor) : last);
    if (to - from >= LEAST_MS && to - from > (longest ? longest[1] - longest[0] : 0)) longest = [from, to];
    if (Number.isFinite(stop)) from = Math.max(from, onRow(stop + slewBetween_ms(window, stop), Math.ceil));
  }
  return longest;
}

function onRow(ms: number, round: (count: number) => number): number {
  return round(ms / GRID_MS) * GRID_MS;
}

/** Time of a slew between another session's end, or beginning, and this window at about that time. */
function slewBetween_ms(window: Window, edge_ms: number): number {
  return 1000 * slewTime_s(angles.get(edge_ms) ?? null, anglesAt(window, edge_ms));
}

/** Angles of the axes at the ends of sessions that were placed in a window, by the time; degrees. */
const angles = new Map<number, Record<string, number>>();

/** As the window has them nearest to an instant; null where it tells none. */
function anglesAt(window: Window, at_ms: number): Record<string, number> | null {
  const { at, angles_deg } = window.through;
  const nearest = at.reduce(
    (best, instant, index) =>
      Math.abs(Date.parse(instant) - at_ms) < Math.abs(Date.parse(at[best] ?? "") - at_ms) ? index : best,
    0,
  );
  const found = Object.entries(angles_deg).flatMap(([axis, values]) => {
    const value = values[nearest];
    return value === null || value === undefined ? [] : [[axis, value] as const];
  });
  return found.length ? Object.fromEntries(found) : null;
}

/** Remembers where the axes are at the chosen session's ends, for the one that is placed beside it. */
function rememberAngles(windows: readonly Window[]): void {
  const one = draft.session.peek();
  const window = windowOf(windows, one);
  for (const instant of [one.start, one.stop]) {
    const known = window && instant ? anglesAt(window, Date.parse(instant)) : null;
    if (known && instant) angles.set(Date.parse(instant), known);
  }
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

const GOOD_S = 20;

/** Windows in which a session of some length is free, else those with any. */
export function withRoom(windows: readonly Window[]): readonly Window[] {
  const free = windows.flatMap((window) => {
    const times = sessionIn(window);
    return times ? [{ window, lasts_s: (Date.parse(times.stop) - Date.parse(times.start)) / 1000 }] : [];
  });
  const good = free.filter(({ lasts_s }) => lasts_s >= GOOD_S);
  return (good.length ? good : free).map(({ window }) => window);
}

function isOneOf(modes: readonly string[], mode: string): boolean {
  return modes.includes(mode);
}

let last: string | null = null;

/** The target that windows are looked for: of a path the point halfway, a mode once it is drawn; null where there are none. */
export function searchedOf(target: Target | undefined): Target | null {
  if (!target) return null;
  if (target.mode === "ground_path") {
    const middle = middleOf(target.points);
    return middle && target.points.length > 1 ? { mode: "ground", ...middle } : null;
  }
  if (isMode(target.mode)) return isDrawn(target) ? target : null;
  return isOneOf(SEARCHED_MODES, target.mode) ? target : null;
}

/** Conditions on the ground mean nothing for a target in space. */
function conditionsFor(target: Target): draft.Conditions {
  const asked = { ...draft.conditions.peek(), ...draft.light.peek() };
  const { min_elevation_deg, sun_elevation_min_deg, sun_elevation_max_deg, ...others } = asked;
  return isMode(target.mode) || isOneOf(EARTH_FIXED_MODES, target.mode)
    ? { min_elevation_deg, sun_elevation_min_deg, sun_elevation_max_deg, ...others }
    : others;
}

const MOVING_REACH_MS = 2 * 86_400_000; // as far from its epoch as the service knows where a target goes

/** The days that are shown, as far as the target can be in them. */
function spanFor(target: Target): { start: string; stop: string } {
  const [from_ms, to_ms] = [draft.from_ms.peek(), draft.to_ms.peek()];
  const epoch_ms = target.mode === "ground_moving" ? Date.parse(target.epoch) : Number.NaN;
  if (Number.isNaN(epoch_ms)) return { start: rfc3339(from_ms), stop: rfc3339(to_ms) };
  const start_ms = Math.max(from_ms, epoch_ms - MOVING_REACH_MS);
  const stop_ms = Math.min(to_ms, epoch_ms + MOVING_REACH_MS);
  return { start: rfc3339(start_ms), stop: rfc3339(stop_ms > start_ms ? stop_ms : to_ms) };
}

async function search(target: Target, until: AbortSignal): Promise<void> {
  isSearching.value = true;
  searchError.value = null;
  try {
    const answer = await post(
      "/v1/opportunities",
      {
        platform: draft.platform.peek(),
        orbit: draft.orbit.peek(),
        attitude: body.peek() ? undefined : draft.attitude.peek(),
        targets: [{ id: "target", target }],
        ...spanFor(target),
        conditions: conditionsFor(target),
        clouds: draft.clouds.peek(),
        samples: SAMPLES,
      },
      { query: ASKED, signal: until },
    );
    const windows = isMode(target.mode) ? wholePasses(answer.windows as Window[], target.mode) : (answer.windows as Window[]);
    found.value = {
      windows,
      unseen: answer.reasons?.[0] ?? null,
      assumed: answer.assumed[0]?.detail ?? null,
      warnings: answer.warnings,
    };
    // Kept by the service for who wants it; ours is seen once.
    if (last) void remove("/v1/opportunities/{id}", { id: last }).catch(() => undefined);
    last = answer.id;
    const taken = draft.session.peek().start ? null : best(withRoom(windows));
    const times = taken && sessionIn(taken);
    if (times) draft.setTimes(times.start, times.stop);
    rememberAngles(windows);
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
  const remembering = effect(() => {
    if (found.value && draft.session.value) rememberAngles(found.value.windows);
  });
  const searching = effect(() => {
    const target = searchedOf(draft.target.value);
    // Another target's windows are not to be taken for this one's.
    if (JSON.stringify(target) !== shown) found.value = null;
    shown = JSON.stringify(target);
    // What the answer depends on, whose change asks anew; times of sessions are not part of it.
    void [draft.orbit.value, draft.attitude.value, draft.platform.value, draft.from_ms.value, draft.days.value];
    void [draft.conditions.value, draft.light.value, draft.clouds.value, retries.value];
    if (!target || !platforms.value) {
      found.value = null;
      searchError.value = null;
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
  return () => {
    searching();
    remembering();
  };
}
