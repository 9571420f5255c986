/** Columns of a telemetry file, a comparison's table, and names of kept work. */
import { expect, test } from "vitest";

import "./page";

const { namesIn, meaningsFor, meaningOf, renamed } = await import("../src/rooms/telemetry/columns");
const { flownOf } = await import("../src/rooms/telemetry/compare");
const { faultsOf } = await import("../src/rooms/campaigns/campaign");
const { labelOf } = await import("../src/i18n/labels");
const { Problem } = await import("../src/api/problem");

const utf16 = (text: string) => new Uint8Array([0xff, 0xfe, ...[...text].flatMap((one) => [one.charCodeAt(0), 0])]);

test.each([
  ["t_s,alpha_deg\n1,2", ["t_s", "alpha_deg"]],
  ["# recorded\nTime;AZ, deg;EL\n1;2;3", ["Time", "AZ, deg", "EL"]],
  ['\uFEFFTime\t"EL beta"\r\n1\t2', ["Time", "EL beta"]],
  [utf16("Time,AZ\n1,2"), ["Time", "AZ"]],
])("names of columns are those that the service reads: %j", async (content, names) => {
  expect(await namesIn(new Blob([content as BlobPart]))).toEqual(names);
});

test("a column is what its name says, in any case, unless another meaning is chosen", () => {
  const meanings = meaningsFor(["alpha", "beta"]);
  expect(meaningOf("ALPHA_deg", {}, meanings)).toBe("alpha_deg");
  expect(meaningOf("Time", {}, meanings)).toBe("");
  const chosen = { Time: "t_s", "AZ alpha": "alpha_rate_arcsec_s", note: "" };
  expect(meaningOf("AZ alpha", chosen, meanings)).toBe("alpha_rate_arcsec_s");
  expect(renamed(["Time", "AZ alpha", "note", "beta_deg"], chosen)).toEqual({ t_s: "Time", alpha_rate_arcsec_s: "AZ alpha" });
});

test("the table is read by axis, whatever the axis is called", () => {
  const table =
    '# note\naxis,t_s,planned_deg,flown_deg,error_arcsec\nalpha,0.1,1,1.001,3.6\n"b, outer",0.2,2,2,0\nalpha,0.3,1,1,0\n';
  const flown = flownOf(table);
  expect([...flown.keys()]).toEqual(["alpha", "b, outer"]);
  expect(flown.get("alpha")).toEqual({ t_s: [0.1, 0.3], planned_deg: [1, 1], flown_deg: [1.001, 1], error_arcsec: [3.6, 0] });
});

test("each fault of a refused campaign belongs to its target", () => {
  const targets = ["a", "b", "c"].map((id) => ({ id, session_s: 20, target: { mode: "place" as const, name: id } }));
  const errors = [0, 2, 2].map((row, k) => ({ field: `targets.${row}.target.name`, detail: `fault ${k}`, value: "x" }));
  const refused = { type: "about:blank", title: "", status: 422, detail: "", instance: "" };
  const faults = faultsOf(new Problem({ ...refused, errors }), targets);
  expect(targets.map((one) => faults.get(one)?.map((fault) => fault.detail))).toEqual([
    ["fault 0"],
    undefined,
    ["fault 1", "fault 2"],
  ]);
  expect(faultsOf(new Problem({ ...refused, field: "step_s" }), targets).size).toBe(0);
});

test("work without a name is called after its targets, and by its day", () => {
  const work = { id: "7", name: "", targets: ["Graz", "Linz"], start: "2015-02-27T17:36:20Z", stop: "2015-02-27T17:37:50.4Z" };
  expect(labelOf(work)).toBe("Graz, Linz, 27 Feb 2015 17:36:20–17:37:50.4 UTC");
  expect(labelOf({ ...work, targets: [], start: null })).toBe("7");
});
