/** The values of a plan's view between its rows, and how sharp a pass is seen. */
import { expect, test } from "vitest";

import "./page";

const { frameRowAt, hasAngles, longitudeAt, marginsKept, onRows, rowAt, valueAt } = await import("../src/rooms/viewer/view");
const { lightOf, quality, sample_m } = await import("../src/windows/sight");
type View = Parameters<typeof rowAt>[0];
type Pass = Parameters<typeof quality>[0];

const view = { t_s: [0, 0.2, 0.4, 0.6], step_s: 0.2 } as unknown as View;

test.each([
  [-1, 0],
  [0, 0],
  [0.2, 1],
  [0.39, 1],
  [0.6, 3],
  [9, 3],
])("at %f s row %i holds", (t_s, row) => {
  expect(rowAt(view, t_s)).toBe(row);
});

test("the frame shows the session that is, else that which comes, else that which was", () => {
  const of = (major: (number | null)[], activity: string[]) =>
    ({ ...view, activity, pointing: { sigma_major_arcsec: major } }) as unknown as View;
  const held = of([null, 5, 6, null], ["slew", "track", "track", "brake"]);
  expect([0, 0.2, 0.4, 0.6].map((t_s) => frameRowAt(held, t_s))).toEqual([1, 1, 2, 2]);
  expect(frameRowAt(of([null, null, null, null], ["wait", "wait", "wait", "wait"]), 0)).toBeNull();
});

test("a column goes straight between its rows, and isn't known beside one that isn't", () => {
  expect(valueAt(view, [0, 10, null, 30], 0.1)).toBeCloseTo(5, 12);
  expect(valueAt(view, [0, 10, null, 30], 0.3)).toBeNull();
  expect(valueAt(view, [0, 10, null, 30], 0.2)).toBe(10);
  expect(valueAt(view, [0, 10, 20, 30], 5)).toBe(30);
  expect(longitudeAt(view, [179, -179, -178, -177], 0.1)).toBe(179);
});

test("a slew's column is known in the slew only", () => {
  expect(onRows([0, 1, 2, 3, 4], [1, 3], [10, 30])).toEqual([null, 10, 20, 30, null]);
});

test("an exclusion has a margin while it counts, and there is something to keep away from", () => {
  const held = { ...view, activity: ["slew", "track", "track", "slew"] } as unknown as View;
  const of = (imaging_only: boolean) => ({ imaging_only, margin_deg: [5, 180, -1, 7] }) as unknown as View["exclusions"][number];
  expect(marginsKept(held, of(false))).toEqual([5, null, -1, 7]);
  expect(marginsKept(held, of(true))).toEqual([null, null, -1, null]);
});

test("axes that turn with the spacecraft have no angles", () => {
  const of = (angle_deg: (number | null)[]) => ({ ...view, axes: { x: { angle_deg } } }) as unknown as View;
  expect([hasAngles(of([null, null])), hasAngles(of([0, 1]))]).toEqual([false, true]);
});

test("light is told by the Sun's elevation at the target", () => {
  expect([15, 0, -6, -7, null].map(lightOf)).toEqual(["day", "low", "twilight", "night", null]);
});

test("straight below the carrier a pixel is as small as it can be", () => {
  const closest = { ground_sample_along_m: 4, ground_sample_across_m: 4, range_km: 420, off_nadir_deg: 0 };
  const pass = { place: {}, closest } as unknown as Pass;
  expect([sample_m(pass), quality(pass)]).toEqual([4, 1]);
  const aside = { ...pass, closest: { ...closest, ground_sample_along_m: 10, off_nadir_deg: 60 } } as Pass;
  expect(sample_m(aside)).toBe(10);
  expect(quality(aside)).toBeCloseTo(0.2, 12);
  expect([sample_m({ ...pass, place: null }), quality({ ...pass, place: null })]).toEqual([null, null]);
});
