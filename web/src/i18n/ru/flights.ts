import type { Words } from "..";

export const flights: Words["flights"] = {};
