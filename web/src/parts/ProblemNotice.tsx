import type { ComponentChildren } from "preact";

import { NoAnswer, Problem } from "../api/problem";
import { words } from "../i18n";

interface Props {
  error: unknown;
  /** Asks again; offered where that may help. */
  again?: () => void;
  /** A dotted field of the request as the page names it. */
  fieldTold?: (field: string) => string;
  /** The ways out, below. */
  children?: ComponentChildren;
}

/** A refusal, a failure or a lost connection in words, with the way out. */
export function ProblemNotice({ error, again, fieldTold, children }: Props) {
  const text = words.value.shell;
  const { title, advice, detail, field, instance } = told(error);
  // The first is the one that the detail is about.
  const others = error instanceof Problem ? (error.document.errors ?? []).slice(1) : [];
  return (
    <div class="notice notice-error" role="alert">
      <p class="notice-title">{title}</p>
      {advice && <p>{advice}</p>}
      {detail && <p class={advice ? "small" : undefined}>{detail}</p>}
      {field && (
        <p class="small">
          {text.problem.field}: {fieldTold && `${fieldTold(field)} `}
          <code>{field}</code>
        </p>
      )}
      {others.length > 0 && (
        <ul>
          {others.map((one) => (
            <li key={`${one.field} ${one.detail}`}>
              {fieldTold?.(one.field) ?? one.field}: {words.value.service.told(one.detail)}
            </li>
          ))}
        </ul>
      )}
      {children}
      {again && mayHelpAgain(error) && (
        <button type="button" onClick={again}>
          {text.again}
        </button>
      )}
      {instance && (
        <p class="small">
          {text.problem.reference}: <code>{instance}</code>
        </p>
      )}
    </div>
  );
}

/** Whether the same request may be answered otherwise: it was ours or nobody's fault. */
function mayHelpAgain(error: unknown): boolean {
  if (!(error instanceof Problem)) return true;
  return (error.status >= 500 && error.kind !== "store-damaged") || error.status === 429;
}

function told(error: unknown) {
  const text = words.value.shell.problem;
  if (error instanceof Problem) {
    const { title, detail, status, instance } = error.document;
    const kind = status === 429 ? "tooMany" : status === 404 ? "gone" : error.kind;
    const titles: Record<string, string> = { ...text.kinds, tooMany: text.tooMany, gone: text.gone };
    const advice: Record<string, string> = text.advice;
    return {
      title: titles[kind] ?? title,
      advice: advice[kind] ?? null,
      detail: words.value.service.told(detail),
      field: error.field,
      instance: status >= 500 ? instance : null,
    };
  }
  if (error instanceof NoAnswer) {
    return { title: text.noAnswer, advice: text.noAnswerDetail, detail: null, field: null, instance: null };
  }
  throw error; // ours: the room's boundary shows it
}
