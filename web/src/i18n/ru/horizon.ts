import type { Words } from "..";

export const horizon: Words["horizon"] = {};
