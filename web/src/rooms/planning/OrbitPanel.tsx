/** The carrier's orbit: pasted, or dropped as a file. */
import { useState } from "preact/hooks";

import { FIELDS } from "../../api/fields";
import { type Orbit, orbitOf, reachOf, textOf } from "../../api/orbit";
import { words } from "../../i18n";
import { instant } from "../../i18n/forms";
import { DropZone } from "../../parts/DropZone";
import { Field } from "../../parts/Field";
import { Fields } from "../../parts/fields/Fields";
import { type Members, schemaOf } from "../../parts/fields/shape";
import { takeAem } from "./AttitudePanel";
import * as draft from "./draft";
import { isAem, readMessage } from "./message";

const MOST_SHOWN = 2000;
/** Members that the text holds. */
const TEXT = ["content", "line1", "line2"];

export function OrbitPanel() {
  const text = words.value.plan.orbit;
  const [typed, setTyped] = useState<string | null>(null);
  const [wrong, setWrong] = useState<string | null>(null);
  const [isOther, setIsOther] = useState(false);
  const take = (content: string) => {
    const isAttitude = isAem(content);
    const orbit = isAttitude ? null : orbitOf(content);
    setIsOther(isAttitude);
    setWrong(orbit || isAttitude ? null : text.unknown);
    setTyped(orbit || isAttitude ? null : content);
    if (isAttitude) takeAem(content);
    if (orbit) draft.setOrbit(orbit);
  };
  const read = async (file: File) => {
    const message = await readMessage(file);
    if (message === null) setWrong(text.tooLong);
    else take(message);
  };
  const orbit = draft.orbit.value;
  const known = reachOf(orbit);
  const shown = typed ?? textOf(orbit);
  const shape = FIELDS.PlanRequest?.orbit?.shape;
  const schema = shape ? schemaOf(shape, orbit) : null;
  const others = Object.keys(FIELDS[schema ?? ""] ?? {}).filter((name) => name !== "source" && !TEXT.includes(name));
  return (
    <section class="panel" aria-label={text.title}>
      <details open={wrong !== null || isOther}>
        <summary>
          <h2>{text.title}</h2>
          <span class="soft">
            {orbit.source.toUpperCase()}
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
                value={shown.length > MOST_SHOWN ? `${shown.slice(0, MOST_SHOWN)}…` : shown}
                onInput={(event) => take(event.currentTarget.value)}
              />
            )}
          </Field>
        </DropZone>
        {isOther && (
          <p class="hint" role="status">
            {text.wasAttitude}
          </p>
        )}
        {schema && others.length > 0 && (
          <Fields
            schema={schema}
            value={orbit as unknown as Members}
            path="orbit"
            omit={TEXT}
            onValue={(next) => draft.change({ orbit: next as unknown as Orbit })}
          />
        )}
      </details>
    </section>
  );
}
