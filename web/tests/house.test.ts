/** Rules of the house that no linter knows. */
import { globSync, readFileSync } from "node:fs";

import { expect, test } from "vitest";

const MODULES = globSync(["src/**/*.{ts,tsx}", "tests/*.ts", "*.ts"]).filter((path) => path !== "src/api/schema.ts");

test("a file that tells what it holds tells it as a statement", () => {
  expect(MODULES.length).toBeGreaterThan(100);
  const indirect = MODULES.filter((path) =>
    /^\/\*\* (What|How|Whether|When|Where|Which|Who|Why)\b/.test(readFileSync(path, "utf8")),
  );
  expect(indirect).toEqual([]);
});
