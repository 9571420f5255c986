/** Offers for a name that is being typed, from the places and stars that the service knows. */
import { get } from "../../api/client";
import { number } from "../../i18n/forms";
import type { Offer } from "../../parts/Combobox";
import { groundOf, type Point, pointOf } from "./target";

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

/** The point that coordinates or a place's name mean, of places of one name the most populous; null for neither. */
export async function resolvePoint(text: string, until?: AbortSignal): Promise<Point | null> {
  const point = pointOf(text);
  if (point || text.trim().length < LEAST_LETTERS) return point;
  const { places } = await get("/v1/places", { query: { begin: text.trim() }, signal: until });
  const [first] = places;
  return first ? { latitude_deg: first.latitude_deg, longitude_deg: first.longitude_deg, height_m: first.height_m } : null;
}
