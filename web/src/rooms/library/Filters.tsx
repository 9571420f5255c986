/** The list's filters: kind, words, state, days. */
import { useState } from "preact/hooks";

import { JOB_STATES } from "../../api/lists";
import { words } from "../../i18n";
import { named } from "../../i18n/forms";
import { ChoiceField } from "../../parts/ChoiceField";
import { Field } from "../../parts/Field";
import { KINDS, type Kind, type Wanted } from "./records";

interface Props {
  kind: Kind;
  onKind: (kind: Kind) => void;
  onWanted: (wanted: Wanted) => void;
  onReload: () => void;
}

export function Filters({ kind, onKind, onWanted, onReload }: Props) {
  const text = words.value;
  const [typed, setTyped] = useState({ text: "", state: "", after: "", before: "" });
  const change = (part: Partial<typeof typed>) => {
    const next = { ...typed, ...part };
    setTyped(next);
    onWanted({
      text: next.text.trim() || undefined,
      state: next.state || undefined,
      after: next.after ? `${next.after}T00:00:00Z` : undefined,
      before: next.before ? `${next.before}T23:59:59Z` : undefined,
    });
  };
  return (
    <form class="panel filters" role="search" onSubmit={(event) => event.preventDefault()}>
      <ChoiceField
        label={text.library.kind}
        value={kind}
        choices={KINDS}
        told={(one) => text.library.kinds[one]}
        onValue={onKind}
      />
      <Field label={text.library.search}>
        {(control) => (
          <input
            {...control}
            type="search"
            placeholder={text.library.searchHint}
            value={typed.text}
            onInput={(event) => change({ text: event.currentTarget.value })}
          />
        )}
      </Field>
      <Field label={text.library.state}>
        {(control) => (
          <select {...control} value={typed.state} onChange={(event) => change({ state: event.currentTarget.value })}>
            <option value="">{text.library.anyState}</option>
            {JOB_STATES.map((state) => (
              <option key={state} value={state}>
                {named(text.shell.states, state)}
              </option>
            ))}
          </select>
        )}
      </Field>
      {(["after", "before"] as const).map((edge) => (
        <Field key={edge} label={text.library[edge]}>
          {(control) => (
            <input
              {...control}
              type="date"
              value={typed[edge]}
              onChange={(event) => change({ [edge]: event.currentTarget.value })}
            />
          )}
        </Field>
      ))}
      <button type="button" onClick={onReload}>
        {text.library.reload}
      </button>
    </form>
  );
}
