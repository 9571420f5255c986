/** The request to the estimator, and the parts of it that a plan can fill in. */
import { get, post, postForAnswer, type Schemas } from "../../api/client";
import { period } from "../../i18n/forms";
import { isOfBody, type Plan } from "../plan/plan";

export type HorizonRequest = Schemas["HorizonRequest"];
export type Estimate = Schemas["EstimateResponse"];
type InertialLaw = Schemas["InertialAttitude"] & { omega_body_deg_s: [number, number, number] };

/** The request, or what is wrong with the text. */
export function readRequest(text: string): HorizonRequest | string {
  try {
    const read: unknown = JSON.parse(text);
    if (typeof read === "object" && read !== null && Array.isArray((read as HorizonRequest).cameras)) {
      return read as HorizonRequest;
    }
    return "cameras?";
  } catch (caught) {
    return String(caught);
  }
}

export async function estimate(request: HorizonRequest, frames: File[], until: AbortSignal): Promise<Estimate> {
  const form = new FormData();
  form.append("request", new Blob([JSON.stringify({ ...request, overlay: true })], { type: "application/json" }));
  for (const frame of frames) form.append("images", frame, frame.name);
  const answer = await postForAnswer("/v1/horizon/estimates", form, { signal: until });
  return (await answer.json()) as Estimate;
}

/** The number of a table's row nearest to an instant; null outside of it. */
export function rowNearest({ epoch, step_s, t_s }: Plan["table"], at: string): number | null {
  const row = Math.round((Date.parse(at) - Date.parse(epoch)) / 1000 / step_s);
  return row >= 0 && row < t_s.length ? row : null;
}

/** From a table's first row to its last. */
export function spanOf(table: Plan["table"]): string {
  return period(table.epoch, instantOf(table, table.t_s.length - 1));
}

function instantOf({ epoch, step_s }: Plan["table"], row: number): string {
  return new Date(Date.parse(epoch) + row * step_s * 1000).toISOString();
}

/** How a body is turned in a row of its table, and how it turns, as a law that holds there. */
function lawOfRow(table: Plan["table"], row: number): InertialLaw {
  const columns = table as unknown as Record<string, number[]>;
  const part = (name: string) => columns[name]?.[row] ?? Number.NaN;
  const turn = (axis: string) => part(`q_eci_from_body_${axis}`);
  const rate = (axis: string) => part(`omega_body_deg_s_${axis}`);
  return {
    law: "inertial",
    epoch: instantOf(table, row),
    q_body_from_eci_xyzw: [-turn("x"), -turn("y"), -turn("z"), turn("w")],
    omega_body_deg_s: [rate("x"), rate("y"), rate("z")],
  };
}

/** Where the plan's carrier is at the request's epoch, and how it is turned: by its law, or a body's table. */
export async function filledFromPlan(plan: Plan, request: HorizonRequest, sigma_deg: number): Promise<HorizonRequest> {
  const [camera] = request.cameras;
  if (!camera) return request;
  const { orbit, attitude: ofCarrier } = await get("/v1/plans/{id}/request", { id: plan.id });
  const ofBody = isOfBody(plan) ? lawOfRow(plan.table, rowNearest(plan.table, request.epoch) ?? 0) : null;
  const attitude = ofBody ?? ofCarrier;
  const { position_itrf_km, q_body_from_eci_xyzw } = await post(
    "/v1/horizon/images",
    { orbit, attitude, camera, at: request.epoch },
    { headers: { Accept: "application/json" } },
  );
  return {
    ...request,
    ...(ofBody && { rate_body_deg_s: ofBody.omega_body_deg_s }),
    position: { frame: "ITRF", position_km: position_itrf_km as HorizonRequest["position"]["position_km"] },
    predicted: {
      q_body_from_eci_xyzw: q_body_from_eci_xyzw as NonNullable<HorizonRequest["predicted"]>["q_body_from_eci_xyzw"],
      sigma_deg,
    },
  };
}
