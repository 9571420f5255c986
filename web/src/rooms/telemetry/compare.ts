/** Asks for the comparison twice: its numbers, and its picture. */
import { postForAnswer, type Schemas } from "../../api/client";

export type Comparison = Schemas["ComparisonResponse"];

export interface Compared {
  comparison: Comparison;
  /** Address of the picture, to be revoked. */
  picture: string;
}

const PATH = "/v1/telemetry/comparisons";

export async function compare(plan: string, file: File, until: AbortSignal): Promise<Compared> {
  const form = () => {
    const parts = new FormData();
    parts.append("request", new Blob([JSON.stringify({ plan })], { type: "application/json" }));
    parts.append("samples", file, file.name);
    return parts;
  };
  const answer = await postForAnswer(PATH, form(), { signal: until });
  const comparison = (await answer.json()) as Comparison;
  const drawn = await postForAnswer(PATH, form(), { query: { format: "svg" }, signal: until });
  return { comparison, picture: URL.createObjectURL(await drawn.blob()) };
}
