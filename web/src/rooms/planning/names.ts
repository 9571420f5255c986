/** Offers for a name that is being typed, from the places and stars that the service knows. */
import { get } from "../../api/client";
import { number } from "../../i18n/forms";
import type { Offer } from "../../parts/Combobox";
import { groundOf } from "./target";

const LEAST_LETTERS = 2;

export function places(begun: string, until: AbortSignal): Promise<Offer[]> | null {
  const begin = begun.trim();
  if (begin.length < LEAST_LETTERS || /^[\d+.-]/.test(begin) || groundOf(begin)?.mode !== "place") return null;
  return get("/v1/places", { query: { begin }, signal: until }).then((answer) =>
    answer.places.map(({ name, words, other_name, latitude_deg, longitude_deg }) => ({
      value: name,
      told: `${other_name === null ? "" : `${other_name} · `}${words === name ? "" : `${words} · `}${number(latitude_deg, 2)}, ${number(longitude_deg, 2)}`,
    })),
  );
}

export function stars(begun: string, until: AbortSignal): Promise<Offer[]> | null {
  const begin = begun.trim();
  if (begin.length < LEAST_LETTERS || /^(hip\b|\d)/i.test(begin)) return null;
  return get("/v1/stars", { query: { begin }, signal: until }).then((answer) =>
    answer.stars.map(({ name, hip }) => ({ value: name, told: `HIP ${hip}` })),
  );
}
