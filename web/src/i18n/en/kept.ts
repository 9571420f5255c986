export const kept = {};
