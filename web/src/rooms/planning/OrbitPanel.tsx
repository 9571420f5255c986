/** The carrier's orbit and attitude: pasted, or dropped as a file. */
import { useState } from "preact/hooks";
import { orbitOf, reachOf, textOf } from "../../api/orbit";
import { words } from "../../i18n";
import { instant, number } from "../../i18n/forms";
import { DropZone } from "../../parts/DropZone";
import { Field } from "../../parts/Field";
import * as draft from "./draft";

const ANGLES = ["yaw_deg", "pitch_deg", "roll_deg"] as const;
const LONGEST_BYTES = 8 * 1024 * 1024; // what the service takes

export function OrbitPanel() {
  const text = words.value.plan.orbit;
  const [typed, setTyped] = useState<string | null>(null);
  const [wrong, setWrong] = useState<string | null>(null);
  const take = (content: string) => {
    const orbit = orbitOf(content);
    setWrong(orbit ? null : text.unknown);
    setTyped(orbit ? null : content);
    if (orbit) draft.setOrbit(orbit);
  };
  const read = async (file: File) => {
    if (file.size > LONGEST_BYTES) setWrong(text.tooLong);
    else take(await file.text());
  };
  const known = reachOf(draft.orbit.value);
  const shown = typed ?? textOf(draft.orbit.value);
  return (
    <section class="panel" aria-label={text.title}>
      <details open={wrong !== null}>
        <summary>
          <h2>{text.title}</h2>
          <span class="soft">
            {draft.orbit.value.source.toUpperCase()}
            {known && ` · ${instant(known.from_ms)}`}
          </span>
        </summary>
        <DropZone label={text.file} onFile={(file) => void read(file)}>
          <Field label={text.label} hint={text.hint} error={wrong ?? undefined}>
            {(props) => (
              <textarea
                {...props}
                rows={3}
                spellcheck={false}
                value={shown.length > 2000 ? `${shown.slice(0, 2000)}…` : shown}
                onInput={(event) => take(event.currentTarget.value)}
              />
            )}
          </Field>
        </DropZone>
        <Attitude />
      </details>
    </section>
  );
}

function Attitude() {
  const text = words.value.plan.attitude;
  const attitude = draft.attitude.value;
  if (attitude.law !== "lvlh") return <p class="hint">{text.other(attitude.law)}</p>;
  return (
    <fieldset>
      <legend>{text.title}</legend>
      <div class="thirds">
        {ANGLES.map((name) => (
          <Field key={name} label={text[name]}>
            {(props) => (
              <input
                {...props}
                type="number"
                step="0.1"
                min={-360}
                max={360}
                value={number(attitude[name] ?? 0, 6).replace(",", ".")}
                onChange={(event) => {
                  const value = event.currentTarget.valueAsNumber;
                  if (Number.isFinite(value)) draft.attitude.value = { ...attitude, [name]: value };
                }}
              />
            )}
          </Field>
        ))}
      </div>
      <p class="hint">{text.hint}</p>
    </fieldset>
  );
}
