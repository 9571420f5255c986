/** Snippets say to another programme what the page has asked. */
import { execFileSync } from "node:child_process";

import { expect, test } from "vitest";

import { curl, python } from "../src/api/snippets";

const REQUEST = JSON.stringify({ name: 'it\'s a "test" \\ $HOME `id`', sessions: [] });

test("a shell hands on the request as it is", () => {
  const command = curl("http://service.test/", REQUEST).replace(/^curl/, "printf '%s\\n'");
  const words = execFileSync("sh", ["-c", command], { encoding: "utf8" }).trimEnd().split("\n");
  expect(words.at(-1)).toBe(REQUEST);
  expect(words).toContain("http://service.test/v1/plans");
});

test("the Python snippet holds the request as JSON and calls what is asked", () => {
  const text = python("http://service.test/", REQUEST, "spacecraft.plan");
  expect(JSON.parse(/r"""\n([\s\S]*?)\n"""/.exec(text)?.[1] ?? "")).toEqual(JSON.parse(REQUEST));
  expect(text).toContain('slewtrack.Client("http://service.test")');
  expect(text).toContain("client.spacecraft.plan(REQUEST)");
});
