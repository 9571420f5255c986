/** The type of the page's words in any language: a key that is missing or too many doesn't compile. */
import type { EN } from "./en";

type Like<T> = {
  [K in keyof T]: T[K] extends string
    ? string
    : T[K] extends (...given: infer G) => string
      ? (...given: G) => string
      : Like<T[K]>;
};
export type Words = Like<typeof EN>;
