import type { Words } from "..";

export const telemetry: Words["telemetry"] = {};
