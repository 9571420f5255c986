/** The request in the making, as the form holds it. */
import { batch, computed, signal } from "@preact/signals";

import example from "../../../../examples/las_vegas_2015.json";
import type { Schemas } from "../../api/client";
import { type Orbit, reachOf, searchStart } from "../../api/orbit";
import type { PlanRequest } from "../plan/plan";
import type { Target } from "./target";

type Session = Schemas["Session"];
/** A session whose target or times aren't chosen yet. */
export type DraftSession = Omit<Session, "target" | "start" | "stop"> & {
  target?: Target;
  start?: string;
  stop?: string;
};
export type Conflict = NonNullable<PlanRequest["on_conflict"]>;
export type Lvlh = Schemas["LvlhAttitude"];

const EXAMPLE = example as unknown as PlanRequest;

/** Everything that the form doesn't show goes through it unchanged. */
const rest = signal<PlanRequest>(EXAMPLE);
export const orbit = signal<Orbit>(EXAMPLE.orbit);
export const attitude = signal<PlanRequest["attitude"]>(EXAMPLE.attitude);
export const name = signal(EXAMPLE.name ?? "");
export const sessions = signal<readonly DraftSession[]>(EXAMPLE.sessions);
/** Number of the session that target and windows are shown of. */
export const chosen = signal(0);
export const onConflict = signal<Conflict>(EXAMPLE.on_conflict ?? "refuse");
export const from_ms = signal(searchStart(EXAMPLE.orbit, Date.now()));
export const days = signal(3);
/** As many days as wanted, where an ephemeris goes on so long. */
export const to_ms = computed(() => {
  const wanted = from_ms.value + days.value * 86_400_000;
  const last = reachOf(orbit.value)?.to_ms ?? wanted;
  return last > from_ms.value ? Math.min(wanted, last) : wanted;
});
export const leastElevation_deg = signal(20);
/** The plan that this one is to replace. */
export const revises = signal<string | null>(null);

export const session = computed<DraftSession>(() => sessions.value[chosen.value] ?? {});
/** Stays the same while only the times change. */
export const target = computed(() => session.value.target);
export const isComplete = computed(() => sessions.value.every((one) => one.target && one.start && one.stop));

/** As the service takes it, sessions in order of time; only when it is complete. */
export const request = computed<PlanRequest>(() => ({
  ...rest.value,
  name: name.value,
  orbit: orbit.value,
  attitude: attitude.value,
  sessions: sessions.value as Session[],
  on_conflict: onConflict.value,
}));

export function setOrbit(next: Orbit): void {
  batch(() => {
    orbit.value = next;
    from_ms.value = searchStart(next, Date.now());
    sessions.value = sessions.value.map(({ start: _, stop: __, ...one }) => one);
    forgetInitialState();
  });
}

export function setTarget(target: Target): void {
  batch(() => {
    if (!revises.value && sessions.value.length === 1) name.value = "";
    const { start: _, stop: __, id: ___, name: ____, ...one } = session.value;
    replaceChosen({ ...one, target });
    forgetInitialState();
  });
}

/** In order of time, as the service wants sessions. */
export function setTimes(start: string, stop: string): void {
  batch(() => {
    const changed = { ...session.value, start, stop };
    replaceChosen(changed);
    const sorted = [...sessions.value].sort((one, other) => begin(one) - begin(other));
    sessions.value = sorted;
    chosen.value = sorted.indexOf(changed);
    forgetInitialState();
  });
}

export function addSession(): void {
  batch(() => {
    sessions.value = [...sessions.value, {}];
    chosen.value = sessions.value.length - 1;
  });
}

export function removeSession(number: number): void {
  batch(() => {
    const left = sessions.value.filter((_, index) => index !== number);
    sessions.value = left.length ? left : [{}];
    chosen.value = Math.min(chosen.value, sessions.value.length - 1);
    forgetInitialState();
  });
}

/** Put a request that was planned before into the form. */
export function load(asked: PlanRequest, replaces: string | null): void {
  batch(() => {
    rest.value = asked;
    orbit.value = asked.orbit;
    attitude.value = asked.attitude;
    name.value = asked.name ?? "";
    sessions.value = asked.sessions;
    chosen.value = 0;
    onConflict.value = asked.on_conflict ?? "refuse";
    const first = Date.parse(asked.sessions[0]?.start ?? "");
    const start = searchStart(asked.orbit, Date.now());
    from_ms.value = Number.isFinite(first) && first < start ? first - 3_600_000 : start;
    revises.value = replaces;
  });
}

function begin(one: DraftSession): number {
  return one.start ? Date.parse(one.start) : Infinity;
}

function replaceChosen(next: DraftSession): void {
  sessions.value = sessions.value.map((one, index) => (index === chosen.value ? next : one));
}

/** It was made for other times: without one the service begins as early as a gentle slew wants. */
function forgetInitialState(): void {
  const { initial_state: _, ...others } = rest.value;
  rest.value = others as PlanRequest;
}
