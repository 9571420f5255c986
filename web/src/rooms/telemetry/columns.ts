/** Columns of a telemetry file: their names, and what each may hold. */
const TIMES = ["t_s", "utc", "unix_s"] as const;
const UNITS = ["deg", "rad", "mrad", "arcmin", "arcsec"] as const;
const HEAD_BYTES = 65_536;

/** Names in the first line that is no comment; UTF-8, or UTF-16 with its mark, as the service reads it. */
export async function namesIn(file: Blob): Promise<string[]> {
  const bytes = new Uint8Array(await file.slice(0, HEAD_BYTES).arrayBuffer());
  const mark = (bytes[0] ?? 0) * 256 + (bytes[1] ?? 0);
  const text = new TextDecoder(mark === 0xfffe ? "utf-16le" : mark === 0xfeff ? "utf-16be" : "utf-8").decode(bytes);
  const head = text.split(/\r?\n/).find((line) => line.trim() && !line.startsWith("#")) ?? "";
  const separator = ["\t", ";", ","].find((one) => head.includes(one)) ?? ",";
  return head
    .split(separator)
    .map((name) => name.trim().replace(/^"|"$/g, ""))
    .filter(Boolean);
}

/** All that a column may hold, as the service names it. */
export function meaningsFor(axes: readonly string[]): string[] {
  const units = (axis: string) => UNITS.flatMap((unit) => [`${axis}_${unit}`, `${axis}_rate_${unit}_s`]);
  return [...TIMES, ...axes.flatMap(units)];
}

/** The same of a body: its attitude's quaternion, in any order, and its gyros' rates. */
export function meaningsForBody(): string[] {
  const parts = [1, 2, 3, 4].map((part) => `q_${part}`);
  const rates = (axis: string) => UNITS.map((unit) => `omega_body_${unit}_s_${axis}`);
  return [...TIMES, ...parts, ...["x", "y", "z"].flatMap(rates)];
}

/** What a column holds: as it was chosen, or as its name says; "" for none. */
export function meaningOf(name: string, chosen: Readonly<Record<string, string>>, meanings: readonly string[]): string {
  return chosen[name] ?? meanings.find((one) => one.toLowerCase() === name.toLowerCase()) ?? "";
}

/** The `columns` of a request: those that the file names otherwise. */
export function renamed(names: readonly string[], chosen: Readonly<Record<string, string>>): Record<string, string> {
  return Object.fromEntries(names.flatMap((name) => (chosen[name] ? [[chosen[name], name]] : [])));
}
