import type { Words } from "..";

export const kept: Words["kept"] = {};
