/** Registered platforms, and the one that the request names or writes out. */
import { computed, signal } from "@preact/signals";

import { get, type Schemas } from "../../api/client";
import * as draft from "./draft";

export type Platform = Schemas["PlatformDefinition"];

/** null until the service has told them. */
export const platforms = signal<readonly Platform[] | null>(null);

/** Asked once; where none are told, the form goes on without what they say. */
export async function learnPlatforms(until: AbortSignal): Promise<void> {
  if (platforms.peek()) return;
  try {
    // the form writes requests of two axes only
    const known = (await get("/v1/platforms", { signal: until })).platforms;
    platforms.value = known.filter((one): one is Platform => one.kind !== "body");
  } catch (error) {
    if (until.aborted) return;
    platforms.value = [];
    throw error;
  }
}

export const platform = computed<Platform | null>(() => {
  const asked = draft.platform.value;
  if (typeof asked !== "string") return asked;
  return platforms.value?.find((one) => one.name === asked) ?? null;
});

export const axes = computed(() => (platform.value ? [platform.value.outer.name, platform.value.inner.name] : []));

/** Yaw, pitch and roll from LVLH that the carrier usually has; degrees. */
export const usual = computed(() => platform.value?.usual_yaw_pitch_roll_deg ?? null);

/** The carrier's usual mean attitude in the place of what is there. */
export function takeUsual(): void {
  const [yaw_deg, pitch_deg, roll_deg] = usual.peek() ?? [0, 0, 0];
  const attitude = draft.attitude.peek();
  const others = attitude.law === "lvlh" ? attitude : {};
  draft.change({ attitude: { ...others, law: "lvlh", yaw_deg, pitch_deg, roll_deg } as draft.Attitude });
}

/** Whether the attitude is 0/0/0 although the carrier's usual mean is another. */
export const isUnlikely = computed(() => {
  const attitude = draft.attitude.value;
  if (attitude.law !== "lvlh" || !usual.value) return false;
  return ![attitude.yaw_deg, attitude.pitch_deg, attitude.roll_deg].some(Boolean) && usual.value.some(Boolean);
});

const UNKNOWN_TURN_DEG = 90;
const IN_MOTION = 1.25; // the axes follow targets before and after
const SPARE_S = 4;

/** Time to leave for a slew between two sessions, by the axes' angles at its ends; degrees, seconds. */
export function slewTime_s(from: Readonly<Record<string, number>> | null, to: Readonly<Record<string, number>> | null): number {
  const one = platform.peek();
  if (!one) return 0;
  const times = [one.outer, one.inner].map((axis) => {
    const [first, last] = [from?.[axis.name], to?.[axis.name]];
    const turn = first === undefined || last === undefined ? UNKNOWN_TURN_DEG : Math.abs(last - first);
    return restToRest_s(turn, axis.rate_max_deg_s, axis.acceleration_max_deg_s2, axis.jerk_max_deg_s3);
  });
  return IN_MOTION * Math.max(...times) + SPARE_S;
}

/** The least time from rest to rest with rate, acceleration and jerk bounded: up to seven stretches of constant jerk. */
export function restToRest_s(turn: number, rate: number, acceleration: number, jerk: number): number {
  const ramp = acceleration / jerk;
  // The acceleration's bound isn't reached, or the rate's isn't, or both are.
  const atRate = rate >= acceleration * ramp ? rate / acceleration + ramp : 2 * Math.sqrt(rate / jerk);
  if (turn >= rate * atRate) return turn / rate + atRate;
  if (turn >= 2 * acceleration * ramp ** 2) return ramp + Math.sqrt(ramp ** 2 + (4 * turn) / acceleration);
  return 4 * Math.cbrt(turn / 2 / jerk);
}
