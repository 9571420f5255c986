export const horizon = {};
