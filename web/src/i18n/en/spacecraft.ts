export const spacecraft = {};
