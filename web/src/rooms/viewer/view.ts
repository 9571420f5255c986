/** The view of a plan, and its values at an instant. */
import { get, type Schemas, send } from "../../api/client";
import { targetTold } from "../../i18n/labels";
import type { Stretch } from "../../time/TimeBar";
import type { Plan } from "../plan/plan";

export type View = Schemas["PlanViewResponse"];
export type HorizonCamera = Schemas["HorizonCamera"];
type Numbers = readonly (number | null)[];

const TABLE_STEP_S = 0.2;
const EVERY_ROW_UP_TO = 5000;
const NOTHING_THERE_DEG = 180; // the margin told where there is nothing to keep away from
const SEEN_UP_TO = 60; // sessions and cones, of which each is as long as the table

/** Every row of the table, or as many as the service thinks enough for a longer one. */
export async function fetchView(plan: Plan, signal: AbortSignal): Promise<View> {
  const isShort = plan.table.t_s.length <= EVERY_ROW_UP_TO && plan.summary.sessions.length <= SEEN_UP_TO;
  const query = isShort ? { step_s: TABLE_STEP_S } : {};
  return get("/v1/plans/{id}/view", { id: plan.id, query, signal });
}

/** The service's CZML, as it is. */
export async function fetchCzml(id: string, signal: AbortSignal): Promise<object> {
  return (await send("GET", "/v1/plans/{id}/view", { id, query: { format: "czml" }, signal })).json() as Promise<object>;
}

/** The horizon cameras as they were asked about. */
export async function fetchCameras(id: string, signal: AbortSignal): Promise<HorizonCamera[]> {
  const request = (await get("/v1/plans/{id}/request", { id, signal })) as { horizon_cameras?: HorizonCamera[] };
  return request.horizon_cameras ?? [];
}

/** Whether its axes have angles: those of a spacecraft that turns as a whole turn with it. */
export function hasAngles(view: View): boolean {
  return Object.values(view.axes).some((axis) => axis.angle_deg.some((angle) => angle !== null));
}

/** An exclusion's margin where it is one: null where there is nothing to keep away from, or it doesn't count. */
export function marginsKept(view: View, { imaging_only, margin_deg }: View["exclusions"][number]): (number | null)[] {
  const counts = (row: number) => !imaging_only || view.activity[row] === "track";
  return margin_deg.map((margin, row) => (margin !== null && margin < NOTHING_THERE_DEG && counts(row) ? margin : null));
}

/** Whether anything on the Earth is looked at. */
export function hasPlaces(view: View): boolean {
  return view.targets.some((one) => one.latitude_deg.some((latitude) => latitude !== null));
}

export function lastOf(t_s: readonly number[]): number {
  return t_s[t_s.length - 1] ?? 0;
}

/** Number of the row that holds at an instant. */
export function rowAt(view: View, t_s: number): number {
  const row = Math.floor(t_s / view.step_s + 1e-6);
  const last = view.t_s.length - 1;
  return Math.min(Math.max(t_s >= lastOf(view.t_s) ? last : row, 0), last);
}

/** The row whose ellipse is shown: the cursor's in a session, else that of the next session's start, or of the last one's end. */
export function frameRowAt(view: View, t_s: number): number | null {
  const { sigma_major_arcsec: major } = view.pointing;
  const isTold = (row: number) => major[row] != null && view.activity[row] === "track";
  const row = rowAt(view, t_s);
  if (isTold(row)) return row;
  const next = major.findIndex((_, index) => index > row && isTold(index));
  if (next >= 0) return next;
  const last = major.findLastIndex((_, index) => isTold(index));
  return last < 0 ? null : last;
}

/** A column between its rows; null where either of them is. */
export function valueAt(view: View, values: Numbers, t_s: number): number | null {
  const row = rowAt(view, t_s);
  const [low, high] = [values[row], values[row + 1]];
  if (low == null) return null;
  if (high === undefined) return low;
  if (high === null) return t_s === view.t_s[row] ? low : null;
  const [from_s, to_s] = [view.t_s[row] ?? 0, view.t_s[row + 1] ?? 1];
  return low + ((t_s - from_s) / (to_s - from_s)) * (high - low);
}

/** The same of longitudes, which jump at the date line. */
export function longitudeAt(view: View, values: Numbers, t_s: number): number | null {
  const row = rowAt(view, t_s);
  const [low, high] = [values[row], values[row + 1]];
  if (low == null || high == null || Math.abs(high - low) < 180) return valueAt(view, values, t_s);
  return low;
}

/** What the table does, one after the other. */
export function stretchesOf(view: View, plan: Plan, kinds: Record<string, string>): Stretch[] {
  const epoch_ms = Date.parse(view.epoch);
  return plan.segments.map((segment) => {
    const { kind, session, start, stop } = segment;
    const name = kind === "track" && session !== null ? view.targets.find((one) => one.session === session)?.name : null;
    return {
      kind,
      label: (name && targetTold(name)) || (kinds[kind] ?? kind),
      start_s: (Date.parse(start) - epoch_ms) / 1000,
      stop_s: (Date.parse(stop) - epoch_ms) / 1000,
    };
  });
}

/** A slew's column laid on the view's rows: null before and after it. */
export function onRows(t_s: readonly number[], slew_t_s: readonly number[], values: readonly number[]): (number | null)[] {
  const [first, last] = [slew_t_s[0] ?? 0, lastOf(slew_t_s)];
  let next = 0;
  return t_s.map((t) => {
    if (t < first - 1e-6 || t > last + 1e-6) return null;
    while (next < slew_t_s.length - 2 && (slew_t_s[next + 1] ?? 0) < t) next++;
    const [low_s, high_s] = [slew_t_s[next] ?? 0, slew_t_s[next + 1] ?? 0];
    const [low, high] = [values[next] ?? 0, values[next + 1] ?? values[next] ?? 0];
    return high_s > low_s ? low + ((t - low_s) / (high_s - low_s)) * (high - low) : low;
  });
}
