import { tellerBy } from "../patterns";
import type { Words } from "../words";
import patterns from "./service.json";

/** What has no pattern stays as the service says it. */
export const service: Words["service"] = { told: tellerBy(patterns) };
