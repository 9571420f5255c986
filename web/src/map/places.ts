/** Places on a map, by longitude and latitude in degrees, as GeoJSON has them. */
export type LonLat = [number, number];

export function wrap(longitude_deg: number): number {
  return ((((longitude_deg + 180) % 360) + 360) % 360) - 180;
}

/** Where a map's middle may be. */
export function clampLatitude(latitude_deg: number): number {
  return Math.max(-80, Math.min(80, latitude_deg));
}

export interface Middle {
  at: LonLat;
  wide_deg: number;
  high_deg: number;
}

/** The middle of places and how far they reach; null without any. */
export function middleOf(places: readonly LonLat[]): Middle | null {
  const [first] = places;
  if (!first) return null;
  const [wests, easts] = [Math.min, Math.max].map((end) => end(...places.map(([lon]) => wrap(lon - first[0]))));
  const [south, north] = [Math.min, Math.max].map((end) => end(...places.map(([, lat]) => lat)));
  const [west, east, low, high] = [wests ?? 0, easts ?? 0, south ?? 0, north ?? 0];
  return {
    at: [wrap(first[0] + (west + east) / 2), (low + high) / 2],
    wide_deg: east - west,
    high_deg: high - low,
  };
}

/** Around an area, so wound that d3 takes its inside, however the ring was given. */
export function ringOf(places: readonly LonLat[]): LonLat[] {
  const [first] = places;
  if (!first) return [];
  const open = places.slice(0, first.join() === places[places.length - 1]?.join() ? -1 : undefined);
  const area = open.reduce((sum, [lon, lat], k) => {
    const [nextLon, nextLat] = open[(k + 1) % open.length] ?? first;
    return sum + wrap(lon - first[0]) * nextLat - wrap(nextLon - first[0]) * lat;
  }, 0);
  const ring = area > 0 ? [...open].reverse() : open;
  return [...ring, ring[0] ?? first];
}
