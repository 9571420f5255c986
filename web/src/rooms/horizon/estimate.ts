/** The request to the estimator, and the parts of it that a plan can fill in. */
import { get, post, postForAnswer, type Schemas } from "../../api/client";

export type HorizonRequest = Schemas["HorizonRequest"];
export type Estimate = Schemas["EstimateResponse"];

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

/** Where the plan's carrier is at the request's epoch, and how its law has it turned. */
export async function filledFromPlan(id: string, request: HorizonRequest, sigma_deg: number): Promise<HorizonRequest> {
  const [camera] = request.cameras;
  if (!camera) return request;
  const { orbit, attitude } = await get("/v1/plans/{id}/request", { id });
  const { position_itrf_km, q_body_from_eci_xyzw } = await post(
    "/v1/horizon/images",
    { orbit, attitude, camera, at: request.epoch },
    { headers: { Accept: "application/json" } },
  );
  return {
    ...request,
    position: { frame: "ITRF", position_km: position_itrf_km as HorizonRequest["position"]["position_km"] },
    predicted: {
      q_body_from_eci_xyzw: q_body_from_eci_xyzw as NonNullable<HorizonRequest["predicted"]>["q_body_from_eci_xyzw"],
      sigma_deg,
    },
  };
}
