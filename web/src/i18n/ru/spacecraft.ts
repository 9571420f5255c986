import type { Words } from "..";

export const spacecraft: Words["spacecraft"] = {};
