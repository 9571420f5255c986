/** Numbers, times and plurals as they are read, in both languages. */
import { afterEach, expect, test } from "vitest";

import { clock, digits, instant, named, number, percent, rfc3339 } from "../src/i18n/forms";
import { counted, language } from "../src/i18n/language";

afterEach(() => {
  language.value = "en";
});

test("times are UTC, to the second that is nearest", () => {
  expect(clock("2015-02-27T18:36:20.900+01:00")).toBe("17:36:20");
  expect(instant("2015-02-27T17:36:20.900Z")).toBe("2015-02-27 17:36:21 UTC");
});

test.each([
  [1_425_058_580_000, "2015-02-27T17:36:20Z"],
  [1_425_058_580_200, "2015-02-27T17:36:20.2Z"],
  [1_425_058_600_000, "2015-02-27T17:36:40Z"],
])("a request's instants keep tenths: %i", (ms, text) => {
  expect(rfc3339(ms)).toBe(text);
});

test("numbers follow the language, what isn't there is a dash", () => {
  expect(number(1234.56)).toBe("1234.6");
  expect([number(null), number(Number.NaN), digits(undefined), percent(null)]).toEqual(["–", "–", "–", "–"]);
  expect(digits(0.00012345)).toBe("1.23e-4");
  expect(digits(-12345.6)).toBe("-12300");
  language.value = "ru";
  expect(number(0.25, 2)).toBe("0,25");
});

test("a probability that isn't sure is never told as sure", () => {
  expect(percent(1)).toBe("100 %");
  expect(percent(0.99999)).toBe("> 99.9 %");
  expect(percent(0.954, 0)).toBe("95 %");
});

test("plurals have the forms of their language", () => {
  const rows = [1, 2, 5, 11, 21].map((count) => counted(count, "окно", "окна", "окон"));
  expect(rows).toEqual(["1 окно", "2 окон", "5 окон", "11 окон", "21 окон"]);
  language.value = "ru";
  const russian = [1, 2, 5, 11, 21].map((count) => counted(count, "окно", "окна", "окон"));
  expect(russian).toEqual(["1 окно", "2 окна", "5 окон", "11 окон", "21 окно"]);
});

test("a name without words of the page's own is the service's", () => {
  expect(named({ csv: "Table" }, "csv")).toBe("Table");
  expect(named({ csv: "Table" }, "tsv")).toBe("tsv");
});
