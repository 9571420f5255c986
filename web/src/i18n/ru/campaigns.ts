import type { Words } from "..";

export const campaigns: Words["campaigns"] = {};
