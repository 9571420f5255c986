/** An imaging session's request and answer. */
import { get, type Schemas } from "../../api/client";
import type { CampaignTarget } from "../campaigns/campaign";
import { NoTargets, targetsOf } from "../campaigns/targets";
import { fetchPlan, type Plan } from "../plan/plan";

export type SessionRequest = Schemas["ImagingPlanRequest"];
export type Asked = Schemas["StripRequest"] | Schemas["StereoRequest"] | Schemas["AreaRequest"] | Schemas["CorridorRequest"];
export type Session = Schemas["SpacecraftPlanResponse"];

export const PATH = "/v1/spacecraft/plans/{id}";

/** The session with the plan that it is, or the job that makes both. */
export async function fetchSession(id: string, signal: AbortSignal) {
  const session = await get(PATH, { id, signal });
  return "table" in session ? { ...session, plan: (await fetchPlan(id, signal)) as Plan } : session;
}

/** What is asked, however the request holds it; nothing of features that are half typed. */
export function askedOf({ requests }: SessionRequest): Asked[] {
  if (Array.isArray(requests)) return requests;
  try {
    return askedFrom(targetsOf(JSON.stringify(requests ?? {})), []);
  } catch (caught) {
    if (!(caught instanceof NoTargets)) throw caught;
    return [];
  }
}

/** As the targets of any plan, for the list and the map of them. */
export function shownAs(asked: readonly Asked[]): CampaignTarget[] {
  const targetOf = ({ mode, geometry }: Asked) => ({ mode, geometry }) as CampaignTarget["target"];
  return asked.map((one) => ({ id: one.name, priority: one.priority, target: targetOf(one) }));
}

/** Those of the targets, each with the other members that it had. */
export function askedFrom(targets: readonly CampaignTarget[], before: readonly Asked[]): Asked[] {
  const known = new Map(before.map((one) => [one.name, one]));
  return targets.map(({ id, priority = 1, target }) => ({ ...target, ...known.get(id), name: id, priority }) as Asked);
}
