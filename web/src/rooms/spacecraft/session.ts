/** An imaging session's request and answer. */
import { get, type Schemas } from "../../api/client";
import { modeOf } from "../../map/modes";
import type { CampaignTarget } from "../campaigns/campaign";
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

export function fetchRequest(id: string, until: AbortSignal): Promise<SessionRequest> {
  return get("/v1/spacecraft/plans/{id}/request", { id, signal: until }) as Promise<SessionRequest>;
}

/** What is asked, however the request holds it. */
export function askedOf({ requests }: SessionRequest): Asked[] {
  if (Array.isArray(requests)) return requests;
  const { features } = (requests ?? {}) as { features?: unknown };
  return Array.isArray(features) ? features.flatMap((one) => ofFeature(one as GeoJSON.Feature) ?? []) : [];
}

/** The requests of a GeoJSON text; null where it holds none. */
export function askedOfGeoJson(text: string): Asked[] | null {
  let read: unknown;
  try {
    read = JSON.parse(text);
  } catch {
    return null;
  }
  const { features, type } = (read ?? {}) as { features?: unknown; type?: unknown };
  const list = type === "Feature" ? [read] : features;
  if (!Array.isArray(list)) return null;
  const asked = list.map((one, index) => ofFeature(one as GeoJSON.Feature, index));
  return asked.length > 0 && asked.every((one) => one !== null) ? asked : null;
}

/** Properties are the other members, as the service reads them; a mode that isn't said follows from the shape. */
function ofFeature({ geometry, properties, id }: GeoJSON.Feature, index = 0): Asked | null {
  if (geometry?.type !== "Polygon" && geometry?.type !== "LineString") return null;
  const mode = modeOf(geometry);
  return { name: String(id ?? `${mode} ${index + 1}`), mode, ...properties, geometry } as Asked;
}

/** As the targets of any plan, for the list and the map of them. */
export function targetsOf(asked: readonly Asked[]): CampaignTarget[] {
  return asked.map(({ name, priority, mode, geometry }) => ({
    id: name,
    priority,
    target: { mode, geometry } as CampaignTarget["target"],
  }));
}

/** Those of the targets, each with the other members that it had. */
export function askedFrom(targets: readonly CampaignTarget[], before: readonly Asked[]): Asked[] {
  const known = new Map(before.map((one) => [one.name, one]));
  return targets.map(({ id, priority = 1, target }) => ({ ...target, ...known.get(id), name: id, priority }) as Asked);
}
