/** A job's server-sent events, resumed after a broken connection as EventSource would. */
import { BUSY, send } from "./client";
import { NoAnswer, Problem } from "./problem";

export interface JobEvent {
  id: string | null;
  kind: string;
  data: Record<string, unknown>;
}

const ENDS = new Set(["done", "refused", "failed", "cancelled"]);
const TRIES = 3;

/**
 * path: ".../events". EventSource itself can't send an API key. While the service has no place for
 * one stream more, the job itself is asked how it stands.
 */
export async function* follow(path: string, until?: AbortSignal): AsyncGenerator<JobEvent> {
  let last: string | null = null;
  for (let failures = 0; ; ) {
    const headers: Record<string, string> = { Accept: "text/event-stream" };
    if (last !== null) headers["Last-Event-ID"] = last;
    try {
      const answer = await send("GET", path, { headers, signal: until, tries: 1 });
      for await (const event of read(answer)) {
        failures = 0;
        last = event.id ?? last;
        yield event;
        if (event.kind === "state" && ENDS.has(String(event.data.state))) return;
      }
    } catch (error) {
      if (until?.aborted) throw error;
      if (error instanceof Problem) {
        if (!BUSY.has(error.status)) throw error;
        const job = await send("GET", path.replace(/\/events$/, ""), { signal: until });
        const data = (await job.json()) as Record<string, unknown>;
        yield { id: last, kind: "state", data };
        if (ENDS.has(String(data.state))) return;
        failures = 0;
      } // else the connection broke
    }
    if (++failures >= TRIES) throw new NoAnswer(path);
    await new Promise((resolve) => setTimeout(resolve, 2000));
  }
}

async function* read(answer: Response): AsyncGenerator<JobEvent> {
  if (!answer.body) return;
  const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
  let rest = "";
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    const parts = (rest + value).split(/\r?\n\r?\n/);
    rest = parts.pop() ?? "";
    for (const part of parts) {
      const event = parse(part);
      if (event) yield event;
    }
  }
}

function parse(text: string): JobEvent | null {
  let id: string | null = null;
  let kind = "message";
  const data: string[] = [];
  for (const line of text.split(/\r?\n/)) {
    const [name, ...value] = line.split(":");
    const content = value.join(":").replace(/^ /, "");
    if (name === "id") id = content;
    else if (name === "event") kind = content;
    else if (name === "data") data.push(content);
  }
  if (data.length === 0) return null;
  return { id, kind, data: JSON.parse(data.join("\n")) as Record<string, unknown> };
}
