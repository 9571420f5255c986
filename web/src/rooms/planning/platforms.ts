/** The platform that the plan's request names or writes out. */
import { computed } from "@preact/signals";

import { type Attitude, type Body, findPlatform, type Platform, type TwoAxes, usualOf } from "../../parts/platforms";
import * as draft from "./draft";

export const platform = computed<Platform | null>(() => findPlatform(draft.platform.value));

/** The spacecraft, where it turns as a whole. */
export const body = computed<Body | null>(() => (platform.value?.kind === "body" ? platform.value : null));

/** The axes, where there are two on a carrier. */
export const twoAxes = computed<TwoAxes | null>(() => (platform.value && platform.value.kind !== "body" ? platform.value : null));

export const axes = computed(() => (twoAxes.value ? [twoAxes.value.outer.name, twoAxes.value.inner.name] : []));

/** Yaw, pitch and roll from LVLH that the carrier usually has; degrees. */
export const usual = computed(() => twoAxes.value?.usual_yaw_pitch_roll_deg ?? null);

const AXES_ONLY = [
  "PlanRequest.attitude",
  "AskedInitialState.angles_deg",
  "AskedInitialState.rates_deg_s",
  "AskedInitialState.accelerations_deg_s2",
  "PlanRequest.final_state.rest",
  "PlanRequest.final_state.FinalAngles",
  "SlewOptions.method",
  "SlewOptions.jerk_max_deg_s3",
  "SlewOptions.filter_cutoff_hz",
  "SlewOptions.filter_lag_compensation",
  "SlewOptions.keep_out",
  "SlewOptions.avoid_modes",
  "Session.keyhole",
  "Session.target.test_motion",
];
export const BODY_ONLY = [
  "Session.roll",
  "CampaignTarget.roll",
  "AskedInitialState.q_body_from_eci_xyzw",
  "AskedInitialState.omega_body_deg_s",
  "AskedInitialState.alpha_body_deg_s2",
  "PlanRequest.final_state.idle",
];

/** Fields, and values of fields, that a platform of the other kind has. */
export const others = computed<readonly string[]>(() => (body.value ? AXES_ONLY : BODY_ONLY));

/** The carrier's usual mean attitude in the place of what is there. */
export function takeUsual(): void {
  const attitude = draft.attitude.peek();
  const rest = attitude.law === "lvlh" ? attitude : {};
  draft.change({ attitude: { ...rest, ...usualOf(twoAxes.peek()) } as Attitude });
}

/** Whether the attitude is 0/0/0 although the carrier's usual mean is another. */
export const isUnlikely = computed(() => {
  const attitude = draft.attitude.value;
  if (body.value || attitude.law !== "lvlh" || !usual.value) return false;
  return ![attitude.yaw_deg, attitude.pitch_deg, attitude.roll_deg].some(Boolean) && usual.value.some(Boolean);
});

const UNKNOWN_TURN_DEG = 90;
const IN_MOTION = 1.25; // the axes follow targets before and after
const SPARE_S = 4;

/** The least of a body's largest rates, accelerations and jerks about an axis: of agility, or of its gyros' torque. */
function bodyLimits_deg({ agility, gyros, inertia_kg_m2 }: Body): number[] {
  if (agility) {
    const { rate_max_deg_s: rate, acceleration_max_deg_s2: acceleration, jerk_max_deg_s3: jerk } = agility;
    return [rate, acceleration, jerk].map((most) => Math.min(...[most].flat()));
  }
  if (!gyros) return [];
  const { rate_max_deg_s: rate, torque_max_n_m: torque, torque_rate_max_n_m_s: torqueRate } = gyros.turns;
  const inertia = Math.max(...(inertia_kg_m2 ?? [[1]]).flat());
  return [rate, ...[torque, torqueRate].map((most) => ((most / inertia) * 180) / Math.PI)];
}

/** Time to leave for a slew between two sessions, by the axes' angles at its ends, or a body's agility; degrees, seconds. */
export function slewTime_s(from: Readonly<Record<string, number>> | null, to: Readonly<Record<string, number>> | null): number {
  const [one, whole] = [twoAxes.peek(), body.peek()];
  if (whole) {
    const [slowest = 1, least = 1, gentlest = 1] = bodyLimits_deg(whole);
    const settle_s = (whole.agility ?? whole.gyros?.turns)?.settle_s ?? 0;
    return IN_MOTION * restToRest_s(UNKNOWN_TURN_DEG, slowest, least, gentlest) + settle_s + SPARE_S;
  }
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
