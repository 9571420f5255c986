/** A plan flown many times, as the service answers it. */
import type { Schemas } from "../../api/client";
import { percent } from "../../i18n/forms";

export type Flights = Schemas["FlightsResponse"];

/** An interval's ends as they are written. */
export function intervalText(interval: readonly number[] | null): [string, string] {
  return [percent(interval?.[0]), percent(interval?.[1])];
}
