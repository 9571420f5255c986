/** A comparison as it is asked for: its numbers, and its table, from which it is drawn. */
import { postForAnswer, type Schemas } from "../../api/client";

export type Comparison = Schemas["ComparisonResponse"];
export type ImageOffset = Schemas["ImageOffset"];

/** The flight of one axis, sample by sample. */
export interface Flown {
  t_s: number[];
  planned_deg: number[];
  flown_deg: number[];
  error_arcsec: number[];
}

export interface Compared {
  comparison: Comparison;
  flown: ReadonlyMap<string, Flown>;
  table: Blob;
  /** Asked for in another form. */
  file: (format: "png" | "svg") => Promise<Blob>;
}

export interface Asked {
  plan: string;
  /** By what they hold, the file's own names. */
  columns: Record<string, string>;
  offsets: readonly ImageOffset[];
}

const PATH = "/v1/telemetry/comparisons";

export async function compare({ plan, columns, offsets }: Asked, file: File, until: AbortSignal): Promise<Compared> {
  const request = JSON.stringify({ plan, columns, image_offsets: offsets });
  const ask = (query: Record<string, string>) => {
    const parts = new FormData();
    parts.append("request", new Blob([request], { type: "application/json" }));
    parts.append("samples", file, file.name);
    return postForAnswer(PATH, parts, { query, signal: until });
  };
  const comparison = (await (await ask({})).json()) as Comparison;
  const table = await (await ask({ format: "csv" })).blob();
  return { comparison, table, flown: flownOf(await table.text()), file: async (format) => (await ask({ format })).blob() };
}

/** Of the service's own table, whose columns are known. */
export function flownOf(table: string): Map<string, Flown> {
  const flown = new Map<string, Flown>();
  const [, ...lines] = table.split("\n").filter((line) => line && !line.startsWith("#"));
  for (const line of lines) {
    // The axis's name alone may hold a comma.
    const [error = 0, now = 0, planned = 0, t = 0] = line.split(",").slice(-4).reverse().map(Number);
    const name = line.split(",").slice(0, -4).join(",").replace(/^"|"$/g, "");
    const axis = flown.get(name) ?? { t_s: [], planned_deg: [], flown_deg: [], error_arcsec: [] };
    flown.set(name, axis);
    axis.t_s.push(t);
    axis.planned_deg.push(planned);
    axis.flown_deg.push(now);
    axis.error_arcsec.push(error);
  }
  return flown;
}
