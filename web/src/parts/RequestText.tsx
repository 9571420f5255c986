/** A request as JSON, to be read and changed by hand. */
import { useState } from "preact/hooks";

import { save } from "../api/download";
import { words } from "../i18n";
import { place } from "../router";
import { Field } from "./Field";
import { isKept, useKept } from "./kept";

/** Characters: at each change the browser lays the whole text out anew, two million in seconds. */
const LONGEST = 200_000;

interface Props {
  request: object;
  hint: string;
  rows?: number;
  onRequest: (request: object) => void;
}

/** What is typed stays as it is typed while it is no JSON object. */
export function RequestText({ request, hint, rows = 18, onRequest }: Props) {
  const { path, query } = place.value;
  const [wrong, setWrong] = useKept<{ text: string; why: string } | null>(`${path} text`, null, query.get("from"));
  const [typed, setTyped] = useState<{ text: string; made: object } | null>(null);
  const shown = wrong?.text ?? (typed?.made === request ? typed.text : JSON.stringify(request, null, 2));
  const text = words.value.plan.request;
  if (shown.length > LONGEST)
    return (
      <p class="row">
        {text.tooLong(Math.round(shown.length / 1000))}
        <button type="button" onClick={() => save(new Blob([shown], { type: "application/json" }), "request.json")}>
          {text.save}
        </button>
      </p>
    );
  return (
    <>
      <Field label={words.value.plan.take.request} hint={hint} error={wrong?.why}>
        {(control) => (
          <textarea
            {...control}
            rows={rows}
            spellcheck={false}
            value={shown}
            onInput={(event) => {
              const given = event.currentTarget.value;
              const read = readObject(given);
              setWrong(typeof read === "string" ? { text: given, why: read } : null);
              if (typeof read === "string") return;
              setTyped({ text: given, made: read });
              onRequest(read);
            }}
          />
        )}
      </Field>
      {!isKept.value && <p class="notice notice-warn">{text.notKept}</p>}
    </>
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
