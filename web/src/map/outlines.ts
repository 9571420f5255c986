/** Coasts and borders (Natural Earth by world-atlas). */
import { signal } from "@preact/signals";
import { feature, mesh } from "topojson-client";
import type { Topology } from "topojson-specification";

export interface Outlines {
  land: GeoJSON.FeatureCollection | GeoJSON.Feature;
  borders: GeoJSON.MultiLineString;
}

export const outlines = signal<Outlines | null>(null);

/** Coasts and borders as lines of longitude and latitude, deg. */
export async function boundaries(): Promise<[number, number][][]> {
  const atlas = await readAtlas();
  return mesh(atlas, atlas.objects.countries as never).coordinates as [number, number][][];
}

async function readAtlas(): Promise<Topology> {
  return (await import("world-atlas/countries-50m.json")).default as unknown as Topology;
}

export async function wantOutlines(): Promise<void> {
  if (outlines.value) return;
  const atlas = await readAtlas();
  const { land, countries } = atlas.objects;
  if (!land || !countries) return;
  outlines.value = {
    land: feature(atlas, land),
    borders: mesh(atlas, countries as never, (one, other) => one !== other),
  };
}
