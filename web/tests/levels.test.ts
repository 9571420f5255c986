/** Levels of axes, on the screen and on paper. */
import { expect, test } from "vitest";

import { labels, ticks } from "../src/charts/levels";

test.each([
  [
    [-0.0005, 0, 0.0005, 0.001],
    ["−0.0005", "0.0000", "0.0005", "0.0010"],
  ],
  [
    [-0.0001, -0, 0.0001],
    ["−0.0001", "0.0000", "0.0001"],
  ],
  [
    [0, 0.00025, 0.0005],
    ["0.00000", "0.00025", "0.00050"],
  ],
  [
    [-100, 0, 100],
    ["−100", "0", "100"],
  ],
  [
    [0, 2.5, 5],
    ["0.0", "2.5", "5.0"],
  ],
  [
    [0.1, 0.2, 0.30000000000000004],
    ["0.1", "0.2", "0.3"],
  ],
])("levels have the decimals that tell them apart: %j", (levels, told) => {
  expect(labels(levels)).toEqual(told);
});

test.each([
  [[-0.024, 0.011] as const, 2.6],
  [[-62, 21] as const, 2.6],
  [[-1.1, 1.1] as const, 2],
  [[3, 3.9] as const, 2],
])("an axis has two levels at least: %j", (span, room) => {
  const found = ticks(span, room);
  expect(found.length).toBeGreaterThan(1);
  expect(found.every((one) => one >= span[0] && one <= span[1] && !Object.is(one, -0))).toBe(true);
});
