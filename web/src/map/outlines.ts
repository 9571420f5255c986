/** Coasts and borders (Natural Earth by world-atlas), coarse at first, finer for who looks closer. */
import { signal } from "@preact/signals";
import { feature, mesh } from "topojson-client";
import type { Topology } from "topojson-specification";

export interface Outlines {
  land: GeoJSON.FeatureCollection | GeoJSON.Feature;
  borders: GeoJSON.MultiLineString;
}

export const outlines = signal<Outlines | null>(null);
let isDetailed = false;

async function read(module: Promise<{ default: unknown }>): Promise<Outlines | null> {
  const atlas = (await module).default as Topology;
  const { land, countries } = atlas.objects;
  if (!land || !countries) return null;
  return {
    land: feature(atlas, land),
    borders: mesh(atlas, countries as never, (one, other) => one !== other),
  };
}

/** Coasts and borders in detail, as lines of longitude and latitude, deg. */
export async function boundaries(): Promise<[number, number][][]> {
  const atlas = (await import("world-atlas/countries-50m.json")).default as unknown as Topology;
  return mesh(atlas, atlas.objects.countries as never).coordinates as [number, number][][];
}

export async function wantOutlines(): Promise<void> {
  outlines.value ??= await read(import("world-atlas/countries-110m.json"));
}

export function wantDetail(): void {
  if (isDetailed) return;
  isDetailed = true;
  void read(import("world-atlas/countries-50m.json")).then(
    (finer) => {
      outlines.value = finer ?? outlines.value;
    },
    () => {
      isDetailed = false; // asked for again when one looks closer again
    },
  );
}
