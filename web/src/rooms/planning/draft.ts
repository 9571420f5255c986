/** The request in the making: the JSON that is sent, edited as it is, and kept while the tab is open. */
import { batch, computed, effect, signal } from "@preact/signals";

import example from "../../../../examples/las_vegas_2015.json";
import type { Schemas } from "../../api/client";
import { type Orbit, reachOf, searchStart } from "../../api/orbit";
import { isMembers, type Members } from "../../parts/fields/shape";
import { keep, readKept } from "../../parts/kept";
import { type Attitude, slewOfBody } from "../../parts/platforms";
import type { PlanRequest } from "../plan/plan";
import { kindOf, type Target, textOf } from "./target";

export type SearchRequest = Schemas["OpportunityRequest"];
type Session = Schemas["Session"];
/** A session whose target or times aren't chosen yet. */
export type DraftSession = Omit<Session, "target" | "start" | "stop"> & {
  target?: Target;
  start?: string;
  stop?: string;
};
export type DraftRequest = Omit<PlanRequest, "sessions"> & { sessions: readonly DraftSession[] };
export type Conflict = NonNullable<PlanRequest["on_conflict"]>;
export type Conditions = Schemas["OpportunityConditions"];

const EXAMPLE = example as unknown as DraftRequest;
const LVLH: Attitude = { law: "lvlh" };
const KEPT = "plan";
const NAMED_TARGETS = 3;

interface Kept {
  request: DraftRequest;
  chosen: number;
  from_ms: number;
  days: number;
  conditions: Conditions;
  revises: string | null;
  loaded: string | null;
}

const kept = readDraft();

export const made = signal<DraftRequest>(kept?.request ?? EXAMPLE);
/** Number of the session that target and windows are shown of. */
export const chosen = signal(kept?.chosen ?? 0);
export const from_ms = signal(kept?.from_ms ?? searchStart(EXAMPLE.orbit, Date.now()));
export const days = signal(kept?.days ?? 3);
/** Of windows that are looked for; they aren't part of the request. */
export const conditions = signal<Conditions>(kept?.conditions ?? { min_elevation_deg: 20 });
/** The plan that this one is to replace. */
export const revises = signal<string | null>(kept?.revises ?? null);
/** The plan whose request was loaded last, by its address. */
export const loaded = signal<string | null>(kept?.loaded ?? null);
/** Whether it was there before the page was loaded. */
export const wasKept = kept !== null;

export const orbit = computed<Orbit>(() => made.value.orbit);
export const attitude = computed<Attitude>(() => made.value.attitude ?? LVLH);
export const platform = computed(() => made.value.platform);
/** Light and view that the plan's sessions must have, and so their windows, and its forecast. */
export const light = computed(() => made.value.conditions);
export const clouds = computed(() => made.value.clouds);
export const sessions = computed(() => made.value.sessions);
export const onConflict = computed<Conflict>(() => made.value.on_conflict ?? "refuse");
export const leastElevation_deg = computed(() => conditions.value.min_elevation_deg ?? 0);
/** As many days as wanted, where an ephemeris goes on so long. */
export const to_ms = computed(() => {
  const wanted = from_ms.value + days.value * 86_400_000;
  const last = reachOf(orbit.value)?.to_ms ?? wanted;
  return last > from_ms.value ? Math.min(wanted, last) : wanted;
});
export const session = computed<DraftSession>(() => sessions.value[chosen.value] ?? {});
/** Stays the same while only the times change. */
export const target = computed(() => session.value.target);
export const isComplete = computed(() => sessions.value.every((one) => one.target && one.start && one.stop));

const wantedKind = signal<{ of: Target | undefined; kind: string } | null>(null);
/** The kind of target that is entered, and that a click on the map makes. */
export const kind = computed<string>(() => {
  const wanted = wantedKind.value;
  if (wanted && wanted.of === target.value) return wanted.kind;
  return target.value ? kindOf(target.value) : "ground";
});

/** As the service takes it, sessions in order of time; only when it is complete. */
export const request = computed<PlanRequest>(() => ({
  ...made.value,
  name: made.value.name || targetsTold(),
  sessions: sessions.value as Session[],
  on_conflict: onConflict.value,
}));

/** Targets by name, as a plan is called that has no other. */
export function targetsTold(): string {
  const names = sessions.value.flatMap((one) => (one.target ? [one.name ?? textOf(one.target)] : []));
  return `${names.slice(0, NAMED_TARGETS).join(", ")}${names.length > NAMED_TARGETS ? "…" : ""}`;
}

export function change(members: Partial<DraftRequest>): void {
  made.value = { ...made.value, ...members };
}

/** The request as it was when a body took the place of its two axes. */
let ofAxes: DraftRequest | null = null;

/** A body steers itself: what only axes have is set aside, and is there again for them. */
export function takeBody(next: PlanRequest["platform"]): void {
  const before = made.peek();
  if (before.attitude) ofAxes = before;
  const { attitude: _, initial_state, final_state: __, final_by: ___, slew, ...rest } = before;
  made.value = {
    ...rest,
    platform: next,
    sessions: before.sessions.map(({ keyhole: ____, ...one }) => one),
    ...stateOf(before.attitude ? beginOf(initial_state) : initial_state),
    ...slewOfBody(slew),
  } as DraftRequest;
}

/** What either kind of platform has of it. */
function beginOf(state: DraftRequest["initial_state"]): DraftRequest["initial_state"] {
  const { epoch, after } = state ?? {};
  return { ...(epoch && { epoch }), ...(after && { after }) };
}

function stateOf(initial_state: DraftRequest["initial_state"]): Pick<DraftRequest, "initial_state"> {
  return initial_state && Object.keys(initial_state).length ? { initial_state } : {};
}

/** Two axes on a carrier, with what was asked of the ones before a body; mean: the attitude where none was. */
export function takeAxes(next: PlanRequest["platform"], mean: Attitude): void {
  const now = made.peek();
  if (now.attitude) {
    change({ platform: next });
    return;
  }
  const { final_state: _, final_by: __, initial_state: ___, ...rest } = now;
  const { attitude = mean, initial_state, final_state, final_by, slew, sessions: before = [] } = ofAxes ?? {};
  made.value = {
    ...rest,
    platform: next,
    attitude,
    ...stateOf({ ...initial_state, ...beginOf(now.initial_state) }),
    ...((slew || now.slew) && { slew: { ...slew, ...now.slew } }),
    ...(final_state !== undefined && { final_state }),
    ...(final_by !== undefined && { final_by }),
    sessions: now.sessions.map((one, number) => {
      const keyhole = before[number]?.target === one.target ? before[number]?.keyhole : undefined;
      return keyhole ? { ...one, keyhole } : one;
    }),
  } as DraftRequest;
}

export function setKind(next: string): void {
  wantedKind.value = { of: target.peek(), kind: next };
}

export function setOrbit(next: Orbit): void {
  batch(() => {
    from_ms.value = searchStart(next, Date.now());
    change({ orbit: next, sessions: sessions.value.map(({ start: _, stop: __, ...one }) => one) });
    forgetInitialEpoch();
  });
}

/** Another target: neither names nor times of the one before are its. */
export function setTarget(next: Target): void {
  batch(() => {
    if (!revises.value && sessions.value.length === 1) change({ name: "" });
    const { start: _, stop: __, id: ___, name: ____, ...one } = session.value;
    replaceChosen({ ...one, target: next });
    forgetInitialEpoch();
  });
}

/** The same target told more closely; its session is placed anew where that moves it. */
export function refineTarget(next: Target, { isMoved = false } = {}): void {
  const { start, stop, ...one } = session.value;
  replaceChosen({ ...one, ...(!isMoved && { start, stop }), target: next });
}

export function changeSession(members: DraftSession): void {
  replaceChosen(members);
}

/** In order of time, as the service wants sessions. */
export function setTimes(start: string, stop: string): void {
  batch(() => {
    const changed = { ...session.value, start, stop };
    replaceChosen(changed);
    const sorted = [...sessions.value].sort((one, other) => begin(one) - begin(other));
    change({ sessions: sorted });
    chosen.value = sorted.indexOf(changed);
    forgetInitialEpoch();
  });
}

/** An empty one, unless there is one already. */
export function addSession(): void {
  batch(() => {
    const empty = sessions.value.findIndex((one) => !one.target && !one.start);
    if (empty < 0) change({ sessions: [...sessions.value, {}] });
    chosen.value = empty < 0 ? sessions.value.length - 1 : empty;
  });
}

export function removeSession(number: number): void {
  batch(() => {
    const left = sessions.value.filter((_, index) => index !== number);
    change({ sessions: left.length ? left : [{}] });
    chosen.value = Math.min(chosen.value, sessions.value.length - 1);
    forgetInitialEpoch();
  });
}

/** Put a request that was planned before, or comes from a file, into the form. */
export function load(asked: PlanRequest | DraftRequest, replaces: string | null, from: string | null = null): void {
  batch(() => {
    made.value = asked as DraftRequest;
    ofAxes = null;
    // A name that was made of the targets follows them.
    if (asked.name && asked.name === targetsTold()) change({ name: "" });
    chosen.value = 0;
    const first = Date.parse(asked.sessions[0]?.start ?? "");
    const start = searchStart(asked.orbit, Date.now());
    from_ms.value = Number.isFinite(first) && first < start ? first - 3_600_000 : start;
    revises.value = replaces;
    loaded.value = from;
    wantedKind.value = null;
  });
}

/** Put a window of a search into the form: its target, from start to stop. */
export function loadWindow(searched: SearchRequest, window: { target?: string; start?: string; stop?: string }): void {
  const { platform, orbit, attitude, targets } = searched;
  const asked = targets.find((one) => one.id === window.target);
  const { start, stop } = window;
  batch(() => {
    load(
      { platform, orbit, attitude, sessions: [{ name: window.target, target: asked?.target, start, stop }] } as DraftRequest,
      null,
    );
    conditions.value = searched.conditions ?? {};
  });
}

/** The request that a JSON text holds; null for what has no orbit, sessions and, but of a body, attitude. */
export function requestOf(read: unknown): DraftRequest | null {
  const isRequest = isMembers(read) && isMembers(read.orbit) && Array.isArray(read.sessions) && hasAttitude(read);
  return isRequest && (read.sessions as unknown[]).every(isMembers) ? (read as unknown as DraftRequest) : null;
}

/** A body may go by a name that only the service knows. */
function hasAttitude({ attitude, platform: of }: Members): boolean {
  const mayBeBody = typeof of === "string" || (isMembers(of) && of.kind === "body");
  return isMembers(attitude) || (attitude === undefined && mayBeBody);
}

function begin(one: DraftSession): number {
  return one.start ? Date.parse(one.start) : Infinity;
}

function replaceChosen(next: DraftSession): void {
  change({ sessions: sessions.value.map((one, index) => (index === chosen.value ? next : one)) });
}

/** It was of other times: without one the service begins as early as a gentle slew wants. */
function forgetInitialEpoch(): void {
  const { initial_state: state, ...others } = made.value;
  if (!state?.epoch) return;
  const { epoch: _, ...rest } = state;
  made.value = Object.keys(rest).length ? { ...others, initial_state: rest } : others;
}

function readDraft(): Kept | null {
  const read = readKept(KEPT);
  return isMembers(read) && requestOf(read.request) ? (read as unknown as Kept) : null;
}

effect(() =>
  keep(KEPT, {
    request: made.value,
    chosen: chosen.value,
    from_ms: from_ms.value,
    days: days.value,
    conditions: conditions.value,
    revises: revises.value,
    loaded: loaded.value,
  } satisfies Kept),
);
