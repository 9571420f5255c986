export const plan = {
  plan: "Plan",
  passed: "Passed",
  failed: "Not passed",
  csv: "Download CSV",
};
