import type { Words } from "..";

export const look: Words["look"] = {};
