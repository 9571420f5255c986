/** A plan as the service answers it. */
import { get, type Schemas } from "../../api/client";

export type Plan = Schemas["PlanResponse"];
export type { PlanRequest } from "../../api/correct";

/** The plan, or null while it is being made. */
export async function fetchPlan(id: string, signal?: AbortSignal): Promise<Plan | Schemas["JobResponse"]> {
  return get("/v1/plans/{id}", { id, signal });
}

/** Whether it moves a spacecraft that turns as a whole, by the table's columns. */
export function isOfBody({ table }: Plan): boolean {
  return "q_eci_from_body_w" in table;
}

export function isPlan(answer: Plan | Schemas["JobResponse"]): answer is Plan {
  return "table" in answer;
}
