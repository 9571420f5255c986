/** Asks for the comparison twice: its numbers, and its picture. */
import { postForAnswer, type Schemas } from "../../api/client";

export type Comparison = Schemas["ComparisonResponse"];

export interface Compared {
  comparison: Comparison;
  /** Address of the picture, to be revoked. */
  picture: string;
}

const PATH = "/v1/telemetry/comparisons";

/** The request beside a file; columns: JSON or nothing, sent as typed, for the service to refuse. */
export function requestOf(plan: string, columns: string): string {
  return columns.trim() ? `{"plan": ${JSON.stringify(plan)}, "columns": ${columns}}` : JSON.stringify({ plan });
}

export async function compare(request: string, file: File, until: AbortSignal): Promise<Compared> {
  const form = () => {
    const parts = new FormData();
    parts.append("request", new Blob([request], { type: "application/json" }));
    parts.append("samples", file, file.name);
    return parts;
  };
  const answer = await postForAnswer(PATH, form(), { signal: until });
  const comparison = (await answer.json()) as Comparison;
  const drawn = await postForAnswer(PATH, form(), { query: { format: "svg" }, signal: until });
  return { comparison, picture: URL.createObjectURL(await drawn.blob()) };
}
