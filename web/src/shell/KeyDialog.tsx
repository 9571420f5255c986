import { useState } from "preact/hooks";

import { keyWanted } from "../api/key";
import { words } from "../i18n";
import { Dialog } from "../parts/Dialog";
import { Field } from "../parts/Field";

export function KeyDialog() {
  const text = words.value.shell;
  const [key, setKey] = useState("");
  const wanted = keyWanted.value;
  if (!wanted) return null;
  return (
    <Dialog title={text.key.title} onClose={() => wanted.answer(null)}>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          if (key.trim()) wanted.answer(key.trim());
          setKey("");
        }}
      >
        <p>{text.key.hint}</p>
        <Field label={text.key.label} error={wanted.refused ? text.key.refused : undefined}>
          {(props) => (
            <input
              {...props}
              type="password"
              autoComplete="off"
              spellcheck={false}
              value={key}
              onInput={(event) => setKey(event.currentTarget.value)}
            />
          )}
        </Field>
        <div class="row">
          <button type="submit" class="primary">
            {text.key.use}
          </button>
          <button type="button" onClick={() => wanted.answer(null)}>
            {text.cancel}
          </button>
        </div>
      </form>
    </Dialog>
  );
}
