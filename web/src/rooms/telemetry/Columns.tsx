/** Columns of the file, each with what it holds: by its name, or as it is chosen. */
import { words } from "../../i18n";
import { Field } from "../../parts/Field";
import { meaningOf } from "./columns";

interface Props {
  names: readonly string[];
  meanings: readonly string[];
  chosen: Record<string, string>;
  onChosen: (chosen: Record<string, string>) => void;
}

export function Columns({ names, meanings, chosen, onChosen }: Props) {
  const text = words.value.telemetry;
  return (
    <fieldset class="columns">
      <legend>{text.columns}</legend>
      <p class="hint">{text.columnsHint}</p>
      <div class="columns-list">
        {names.map((name) => (
          <Field key={name} label={<code>{name}</code>}>
            {(control) => (
              <select
                {...control}
                value={meaningOf(name, chosen, meanings)}
                onChange={(event) => onChosen({ ...chosen, [name]: event.currentTarget.value })}
              >
                <option value="">{text.notRead}</option>
                {meanings.map((one) => (
                  <option key={one} value={one}>
                    {one}
                  </option>
                ))}
              </select>
            )}
          </Field>
        ))}
      </div>
    </fieldset>
  );
}
