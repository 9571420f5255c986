/** A request as JSON, to be read and changed by hand. */
import { useState } from "preact/hooks";

import { words } from "../i18n";
import { Field } from "./Field";

interface Props {
  request: object;
  hint: string;
  rows?: number;
  onRequest: (request: object) => void;
}

/** What is typed stays as it is typed while it is no JSON object. */
export function RequestText({ request, hint, rows = 18, onRequest }: Props) {
  const [typed, setTyped] = useState<{ text: string; wrong: string | null; made: object } | null>(null);
  const shown = typed && (typed.wrong !== null || typed.made === request) ? typed.text : JSON.stringify(request, null, 2);
  return (
    <Field label={words.value.plan.take.request} hint={hint} error={typed?.wrong ?? undefined}>
      {(control) => (
        <textarea
          {...control}
          rows={rows}
          spellcheck={false}
          value={shown}
          onInput={(event) => {
            const text = event.currentTarget.value;
            const read = readObject(text);
            if (typeof read === "string") setTyped({ text, wrong: read, made: request });
            else {
              setTyped({ text, wrong: null, made: read });
              onRequest(read);
            }
          }}
        />
      )}
    </Field>
  );
}

/** The object, or why the text holds none. */
function readObject(text: string): object | string {
  try {
    const read: unknown = JSON.parse(text);
    return typeof read === "object" && read !== null && !Array.isArray(read) ? read : "{…}?";
  } catch (caught) {
    return String(caught);
  }
}
