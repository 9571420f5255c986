/** Numbers, times and plurals as they are read, in both languages. */
import { afterEach, expect, test } from "vitest";

import { clock, digits, fixed, instant, marginTold, named, number, percent, period, rfc3339, rowClock } from "../src/i18n/forms";
import { counted, language } from "../src/i18n/language";

afterEach(() => {
  language.value = "en";
});

test("times are UTC, to the second that is nearest", () => {
  expect(clock("2015-02-27T18:36:20.900+01:00")).toBe("17:36:20");
  expect(instant("2015-02-27T17:36:20.900Z")).toBe("2015-02-27 17:36:21 UTC");
});

test("a row's instant has its tenths, and a period its day, both where it ends on another", () => {
  expect([rowClock("2015-02-27T17:36:20Z"), rowClock("2015-02-27T17:34:26.600Z")]).toEqual(["17:36:20", "17:34:26.6"]);
  expect(period("2015-02-27T17:36:20Z", "2015-02-27T17:37:50.4Z")).toBe("27 Feb 2015 17:36:20–17:37:50.4 UTC");
  expect(period("2015-02-28T23:59:00Z", "2015-03-01T00:01:00Z")).toBe("28 Feb 2015 23:59:00–1 Mar 2015 00:01:00 UTC");
  language.value = "ru";
  expect(period("2015-02-27T17:36:20Z", "2015-02-27T17:37:50Z")).toMatch(/^27 февр\. 2015 г\. 17:36:20/);
});

test("what rounds to nothing has no sign", () => {
  expect([fixed(-1e-9, 5), fixed(-0.5, 2), fixed(null, 2), digits(-0)]).toEqual(["0.00000", "−0.50", "–", "0"]);
});

test("a margin too small for whole percents keeps its digits", () => {
  expect([marginTold(0.67), marginTold(0.0002), marginTold(0)]).toEqual(["67 %", "0.02 %", "0 %"]);
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
  expect([number(0.25, 2), digits(-1.314e-5)]).toEqual(["0,25", "-1,31e-5"]);
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
