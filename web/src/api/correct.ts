/** A kept plan's request with what was learnt of its flight: the next plan's beginning. */
import { get, type Schemas } from "./client";

type Asked = Schemas["PlanRequest"];
/** Two axes stand on a carrier, whose attitude is asked for; a body steers itself and has none. */
export type PlanRequest = Omit<Asked, "attitude" | "platform"> & {
  attitude?: NonNullable<Asked["attitude"]>;
  platform: string | Schemas["PlatformDefinition"] | Schemas["BodyPlatform"];
};

export interface Learnt {
  corrections: readonly Schemas["CorrectionOut"][];
  /** Null where nothing was found of the drives. */
  platform?: object | null;
}

export async function correctedRequest(plan: string, { corrections, platform }: Learnt): Promise<PlanRequest> {
  const asked = (await get("/v1/plans/{id}/request", { id: plan })) as unknown as PlanRequest;
  const { attitude } = asked;
  const before = attitude && "corrections" in attitude ? (attitude.corrections ?? []) : [];
  return {
    ...asked,
    ...(attitude && { attitude: { ...attitude, corrections: [...before, ...corrections] } }),
    ...(platform && { platform }),
  } as PlanRequest;
}
