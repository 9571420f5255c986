/** Addresses of the page, under a proxy's path. */
import { expect, test } from "vitest";

import "./page";

const { address, go, match, place } = await import("../src/router");

test.each([
  ["/plans/:id", "/plans/7", { id: "7" }],
  ["/plans/:id", "/plans/7/", { id: "7" }],
  ["/plans/:id", "/plans/a%20b", { id: "a b" }],
  ["/plans/:id", "/plans", null],
  ["/plans/:id", "/plans/7/table", null],
  ["/plans/:id", "/plans/%", null],
  ["/plans", "/flights", null],
  ["/", "/", {}],
])("%s of %s", (pattern, path, found) => {
  expect(match(pattern, path)).toEqual(found);
});

test("an address begins where the service says that the page begins", () => {
  expect(address("/docs")).toBe("/planner/docs");
  go("/plans/7?compare=1,2");
  expect(place.value.path).toBe("/plans/7");
  expect(place.value.query.get("compare")).toBe("1,2");
});
