/** Refusals of the service, and the lack of any answer. */
import type { components } from "./schema";

export type ProblemDocument = components["schemas"]["Problem"];

const PREFIX = "urn:slewtrack:problem:";

export class Problem extends Error {
  constructor(
    readonly document: ProblemDocument,
    /** When the service wants to be asked again. */
    readonly retryAfter_s: number | null = null,
  ) {
    super(document.detail);
  }

  /** "infeasible-slew", "about:blank"... */
  get kind(): string {
    return this.document.type.replace(PREFIX, "");
  }

  get status(): number {
    return this.document.status;
  }

  get field(): string | null {
    return this.document.field ?? null;
  }

  static async of(answer: Response): Promise<Problem> {
    const wait = Number(answer.headers.get("Retry-After"));
    const after = answer.headers.has("Retry-After") && wait >= 0 ? wait : null;
    const type = answer.headers.get("Content-Type") ?? "";
    if (type.startsWith("application/problem+json")) {
      return new Problem((await answer.json()) as ProblemDocument, after);
    }
    return new Problem(
      {
        type: "about:blank",
        title: answer.statusText || `HTTP ${answer.status}`,
        status: answer.status,
        detail: (await answer.text()).slice(0, 300),
        instance: "",
      },
      after,
    );
  }
}

/** No answer: the connection is lost or the service stopped. */
export class NoAnswer extends Error {}

/** Whether the work itself failed: asked for once more, it may be done. */
export function brokeOff(error: unknown): boolean {
  return error instanceof Problem && (error.kind === "interrupted" || error.kind === "internal-error");
}

/** Whether it was only that nobody waits any more. */
export function isAbort(error: unknown): boolean {
  return error instanceof DOMException && error.name === "AbortError";
}
