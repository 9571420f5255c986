/** An orbit, folded: what it is and of when; pasted, or dropped as a file. */
import { type Orbit, orbitOf, reachOf, textOf } from "../api/orbit";
import { words } from "../i18n";
import { instant } from "../i18n/forms";
import { place } from "../router";
import { DropZone } from "./DropZone";
import { Field } from "./Field";
import { useKept } from "./kept";

interface Props {
  orbit: Orbit;
  /** Tells it from others of the same form. */
  of?: string;
  onOrbit: (orbit: Orbit) => void;
}

export function OrbitField({ orbit, of = "", onOrbit }: Props) {
  const text = words.value.plan.orbit;
  const { path, query } = place.value;
  const [typed, setTyped] = useKept<string | null>(`${path} orbit${of}`, null, query.get("from"));
  const take = (content: string) => {
    const read = orbitOf(content);
    setTyped(read ? null : content);
    if (read) onOrbit(read);
  };
  const known = reachOf(orbit);
  return (
    <details class="orbit" open={typed !== null || undefined}>
      <summary>
        <h3>{text.title}</h3>
        <span class="small">
          {orbit.source.toUpperCase()}
          {known && ` · ${instant(known.from_ms)}`}
        </span>
      </summary>
      <DropZone label={text.file} onFile={(file) => void file.text().then(take)}>
        <Field label={text.label} error={typed === null ? undefined : text.unknown}>
          {(control) => (
            <textarea
              {...control}
              rows={3}
              spellcheck={false}
              value={typed ?? textOf(orbit)}
              onInput={(event) => take(event.currentTarget.value)}
            />
          )}
        </Field>
      </DropZone>
    </details>
  );
}
