/** Lists of kept jobs of each kind, and the address that shows one of them. */
import { get, type Schemas } from "../../api/client";

export type Job = Schemas["JobResponse"];

export const KINDS = ["plans", "spacecraft", "campaigns"] as const;
export type Kind = (typeof KINDS)[number];

/** The address of a kind at the service. */
export const SERVICE_PATHS = {
  plans: "/v1/plans",
  spacecraft: "/v1/spacecraft/plans",
  campaigns: "/v1/campaigns",
} as const;

/** The address of a kind's room. */
export const ROOM_PATHS: Record<Kind, string> = {
  plans: "/plans",
  spacecraft: "/spacecraft/plans",
  campaigns: "/campaigns",
};

export interface Wanted {
  text?: string;
  state?: string;
  /** RFC 3339. */
  after?: string;
  before?: string;
}

export interface Records {
  jobs: Job[];
  /** `cursor` of what comes after; null at the end. */
  next: string | null;
}

const PAGE = 25;

export async function list(kind: Kind, wanted: Wanted, cursor?: string, signal?: AbortSignal): Promise<Records> {
  const query = { ...wanted, limit: PAGE, cursor };
  if (kind === "campaigns") {
    const { campaigns, next } = await get(SERVICE_PATHS.campaigns, { query, signal });
    return { jobs: campaigns, next };
  }
  const { plans, next } = await get(SERVICE_PATHS[kind], { query, signal });
  return { jobs: plans, next };
}

export function isAtWork(job: Job): boolean {
  return job.state === "queued" || job.state === "running";
}
