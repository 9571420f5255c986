/** Registered platforms, and what goes with each kind in a request. */
import { signal } from "@preact/signals";

import { get, type Schemas } from "../api/client";
import type { PlanRequest } from "../api/correct";

export type TwoAxes = Schemas["PlatformDefinition"];
export type Body = Schemas["BodyPlatform"];
export type Platform = TwoAxes | Body;
/** A request names it or writes it out. */
export type AskedPlatform = PlanRequest["platform"];
export type Attitude = NonNullable<Schemas["PlanRequest"]["attitude"]>;
type Slew = Schemas["PlanRequest"]["slew"];

/** null until the service has told them. */
export const platforms = signal<readonly Platform[] | null>(null);

/** Asked once; where none are told, the form goes on without what they say. */
export async function learnPlatforms(until: AbortSignal): Promise<void> {
  if (platforms.peek()) return;
  try {
    platforms.value = (await get("/v1/platforms", { signal: until })).platforms;
  } catch (error) {
    if (until.aborted) return;
    platforms.value = [];
    throw error;
  }
}

/** The one that is named or written out; null for a name that isn't known. */
export function findPlatform(asked: AskedPlatform): Platform | null {
  if (typeof asked !== "string") return asked as Platform;
  return platforms.value?.find((one) => one.name === asked) ?? null;
}

/** Yaw, pitch and roll from LVLH that the carrier usually has. */
export function usualOf(one: TwoAxes | null): Attitude {
  const [yaw_deg = 0, pitch_deg = 0, roll_deg = 0] = one?.usual_yaw_pitch_roll_deg ?? [];
  return { law: "lvlh", yaw_deg, pitch_deg, roll_deg };
}

/** What of the slews' options is also a body's. */
export function slewOfBody(slew: Slew): { slew?: Slew } {
  const { objective, lead } = slew ?? {};
  return objective || lead ? { slew: { ...(objective && { objective }), ...(lead && { lead }) } as Slew } : {};
}
