/** The request in the making, and the session that a window offers it. */
import { beforeEach, expect, test } from "vitest";

import "./page";

const draft = await import("../src/rooms/planning/draft");
const { best, sessionIn, windowNear, windowOf } = await import("../src/rooms/planning/windows");
const platforms = await import("../src/rooms/planning/platforms");
const registered = await import("../src/parts/platforms");
type Window = Parameters<typeof sessionIn>[0];

const at = (seconds: number) => new Date(Date.UTC(2015, 1, 27, 17) + 1000 * seconds).toISOString().replace(".000", "");
const window = (from_s: number, to_s: number, probability_in_frame: number | null = 0.95, sun_elevation_deg = 40) =>
  ({
    rise: at(from_s),
    set: at(to_s),
    opened_by: "elevation",
    closed_by: "elevation",
    highest_at: at((from_s + to_s) / 2),
    probability_in_frame,
    session: { start: at(from_s), stop: at(to_s) },
    closest: { sun_elevation_deg },
    through: { at: [at(from_s), at(to_s)], angles_deg: { alpha: [0, 10], beta: [0, 5] } },
  }) as unknown as Window;
const example = draft.request.peek();

beforeEach(() => draft.load(example, null));

test("sessions are in order of time, and the chosen one stays chosen", () => {
  draft.addSession();
  draft.setTarget({ mode: "place", name: "Reno" });
  expect(draft.isComplete.value).toBe(false);
  draft.setTimes("2015-02-27T17:00:00Z", "2015-02-27T17:00:10Z");
  expect(draft.isComplete.value).toBe(true);
  expect(draft.request.value.sessions.map((one) => one.start)).toEqual(["2015-02-27T17:00:00Z", example.sessions[0]?.start]);
  expect(draft.chosen.value).toBe(0);
});

test("what the form doesn't show goes through it; of the initial state the epoch goes with the times it was for", () => {
  const initial_state = { epoch: "2015-02-27T17:30:00Z", angles_deg: { alpha: 40 } };
  draft.load({ ...example, initial_state, step_s: 0.2 } as unknown as typeof example, "before");
  expect(draft.revises.value).toBe("before");
  expect(draft.request.value).toMatchObject({ step_s: 0.2, initial_state });
  draft.setTimes("2015-02-27T17:36:20Z", "2015-02-27T17:36:40Z");
  expect(draft.request.value).toMatchObject({ step_s: 0.2 });
  expect(draft.request.value.initial_state).toEqual({ angles_deg: { alpha: 40 } });
});

test("of another target neither times nor names are kept; a plan without a name is called by its targets", () => {
  draft.setTarget({ mode: "place", name: "Reno" });
  expect(draft.session.value).toEqual({ target: { mode: "place", name: "Reno" } });
  expect(draft.made.value.name).toBe("");
  expect(draft.request.value.name).toBe("Reno");
});

test("the same target told more closely keeps its times, unless it has moved", () => {
  const before = draft.session.value;
  draft.refineTarget({ mode: "place", name: "Reno", min_elevation_deg: 30 });
  expect(draft.session.value).toMatchObject({ start: before.start, stop: before.stop });
  draft.refineTarget({ mode: "place", name: "Reno" }, { isMoved: true });
  expect(draft.session.value.start).toBeUndefined();
});

test("a session is added once: one without a target is gone back to", () => {
  draft.addSession();
  draft.chosen.value = 0;
  draft.addSession();
  expect([draft.sessions.value.length, draft.chosen.value]).toEqual([2, 1]);
});

test("a file that holds no request is none", () => {
  expect(draft.requestOf({ ...example })).not.toBeNull();
  for (const other of [null, [], {}, { ...example, sessions: [1] }, { ...example, orbit: "tle" }]) {
    expect(draft.requestOf(other)).toBeNull();
  }
});

test("the last session that is removed leaves an empty one", () => {
  draft.removeSession(0);
  expect(draft.sessions.value).toEqual([{}]);
});

test("a long window gives its middle five minutes, beside another session what that leaves", () => {
  draft.removeSession(0);
  expect(sessionIn(window(0, 100))).toEqual({ start: at(0), stop: at(100) });
  expect(sessionIn(window(0, 3600))).toEqual({ start: at(1650), stop: at(1950) });
  draft.setTimes(at(40), at(60));
  draft.addSession();
  expect(sessionIn(window(0, 100))).toEqual({ start: at(0), stop: at(40) });
  expect(sessionIn(window(50, 100))).toEqual({ start: at(60), stop: at(100) });
  expect(sessionIn(window(42, 58))).toBeNull();
  expect(sessionIn({ ...window(0, 100), session: null })).toBeNull();
});

test("between sessions there is time for the slew that the platform's axes make", () => {
  const axis = { rate_max_deg_s: 3, acceleration_max_deg_s2: 1, jerk_max_deg_s3: 1 };
  const outer = { ...axis, name: "alpha" };
  registered.platforms.value = [{ name: "iss-hrc", outer, inner: { ...axis, name: "beta" } } as never];
  draft.removeSession(0);
  draft.setTimes(at(100), at(110));
  draft.addSession();
  const { stop } = sessionIn(window(0, 130)) ?? { stop: "" };
  const left_s = 100 - (Date.parse(stop) - Date.parse(at(0))) / 1000;
  // A quarter turn, since nobody has told where the axes are: 90/3 + 3 + 1 s at least.
  expect(left_s).toBeGreaterThan(34);
  expect(sessionIn(window(70, 130))).toBeNull();
  registered.platforms.value = null;
});

test("a slew takes as long as rate, acceleration and jerk want", () => {
  expect(platforms.restToRest_s(90, 3, 1, 1)).toBeCloseTo(34, 9);
  expect(platforms.restToRest_s(10, 3, 1, 1)).toBeCloseTo(1 + Math.sqrt(41), 9); // the rate isn't reached
  expect(platforms.restToRest_s(0.5, 3, 1, 1)).toBeCloseTo(4 * Math.cbrt(0.25), 9); // nor the acceleration
  expect(platforms.restToRest_s(12, 3, 9, 1)).toBeCloseTo(4 + 2 * Math.sqrt(3), 9);
  expect(platforms.restToRest_s(0, 3, 1, 1)).toBe(0);
});

test("a session keeps off the end that a stop makes, and a long one lies in the middle of what can be held", () => {
  draft.removeSession(0);
  expect(sessionIn({ ...window(0, 100), closed_by: "reach" })).toEqual({ start: at(0), stop: at(95) });
  expect(sessionIn({ ...window(0, 100), opened_by: "sun_keep_out" })).toEqual({ start: at(5), stop: at(100) });
  expect(sessionIn({ ...window(0, 100), opened_by: "directions.dish" })).toEqual({ start: at(5), stop: at(100) });
  const held = { start: at(20), stop: at(100) }; // the axes can't follow before
  expect(sessionIn({ ...window(0, 100), session: held })).toEqual({ start: at(24), stop: at(100) });
  const star = { ...window(0, 3000), highest_at: at(2990), closed_by: "reach" };
  expect(sessionIn(star)).toEqual({ start: at(1275), stop: at(1575) });
});

test("a session is drawn in its window, or in one an hour away at most", () => {
  const windows = [window(0, 100), window(6000, 6100)];
  const session = (from_s: number) => ({ start: at(from_s), stop: at(from_s + 10) });
  expect(windowOf(windows, session(6050))).toBe(windows[1]);
  expect(windowOf(windows, session(3000))).toBeNull();
  expect(windowNear(windows, session(3000))).toBe(windows[0]);
  expect(windowNear(windows, session(10_000))).toBeNull();
  expect(windowNear(windows, {})).toBeNull();
});

test("the best window is the soonest by day that is likely to have the target in the frame", () => {
  const [poor, night, good, better] = [window(0, 1, 0.6), window(2, 3, 0.99, -20), window(4, 5, 0.91), window(6, 7, 0.99)];
  expect(best([poor, night, good, better])).toBe(good);
  expect(best([night, { ...good, session: null }])).toBe(night);
  expect(best([])).toBeNull();
});

test("where none is good it is the likeliest, and of those alike the soonest", () => {
  const [unknown, aged, fresh, alike] = [window(0, 1, null), window(2, 3, 0.18), window(4, 5, 0.66), window(6, 7, 0.68)];
  expect(best([unknown, aged, fresh, alike])).toBe(fresh);
  expect(best([unknown])).toBe(unknown);
});

test("a body is asked nothing of axes, and what was asked of them is there again for two axes", () => {
  const [first] = example.sessions;
  const asked = {
    ...example,
    initial_state: { epoch: "2015-02-27T17:34:00Z", angles_deg: { alpha: 40 } },
    slew: { objective: "minimum_time", keep_out: [{ body: "sun", half_angle_deg: 25 }] },
    final_state: "rest",
    sessions: [{ ...first, keyhole: "nearest" }],
  } as unknown as typeof example;
  draft.load(asked, null);
  draft.takeBody("smallsat-120kg");
  const { attitude: _, final_state: __, ...rest } = asked;
  expect(draft.made.value).toEqual({
    ...rest,
    platform: "smallsat-120kg",
    initial_state: { epoch: "2015-02-27T17:34:00Z" },
    slew: { objective: "minimum_time" },
    sessions: [first],
  });
  expect(draft.requestOf(draft.made.value)).not.toBeNull();
  draft.takeAxes(example.platform, { law: "lvlh", yaw_deg: 0, pitch_deg: 0, roll_deg: 0 });
  expect(draft.made.value).toEqual(asked);
});

test("two axes that come after a request of a body take the mean that is given", () => {
  const { attitude: _, ...rest } = example;
  draft.load({ ...rest, platform: "smallsat-120kg" }, null);
  draft.takeAxes("iss-hrc", { law: "lvlh", yaw_deg: -4 });
  expect(draft.made.value.attitude).toEqual({ law: "lvlh", yaw_deg: -4 });
});
