import type { Words } from "..";

export const plan: Words["plan"] = {
  plan: "Рассчитать",
  passed: "Проверен",
  failed: "Не прошёл проверку",
  csv: "Скачать CSV",
};
