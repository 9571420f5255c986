/** Every target: when it is looked at, or why it isn't. */
import { useEffect, useRef, useState } from "preact/hooks";

import { words } from "../../i18n";
import { digits, number, percent, period } from "../../i18n/forms";
import { Field } from "../../parts/Field";
import { Link } from "../../parts/Link";
import { FATES, type Fate, type TargetFate } from "./campaign";

interface Props {
  fates: readonly TargetFate[];
  chosen: string | null;
  onChoose: (id: string | null) => void;
  /** What a target's name must hold to be among these. */
  sought: string;
  onSought: (text: string) => void;
}

const SHOWN = 200;

export function Fates({ fates, chosen, onChoose, sought, onSought }: Props) {
  const text = words.value.campaigns;
  const [only, setOnly] = useState<Fate | "">("");
  const [isWhole, setIsWhole] = useState(false);
  const now = useRef<HTMLTableRowElement>(null);
  useEffect(() => now.current?.scrollIntoView({ block: "nearest" }), [chosen]);
  const wanted = fates.filter((one) => only === "" || one.fate === only);
  const at = wanted.findIndex((one) => one.id === chosen);
  const shown = isWhole || at >= SHOWN ? wanted : wanted.slice(0, SHOWN);
  return (
    <section class="panel fates" aria-labelledby="campaign-fates">
      <div class="row heading">
        <h2 id="campaign-fates">{text.targets}</h2>
        <Field label={text.sought} class="in-line">
          {(control) => (
            <input {...control} type="search" value={sought} onInput={(event) => onSought(event.currentTarget.value)} />
          )}
        </Field>
        <Field label={text.show} class="in-line">
          {(control) => (
            <select {...control} value={only} onChange={(event) => setOnly(event.currentTarget.value as Fate | "")}>
              <option value="">{text.all}</option>
              {FATES.filter((fate) => fates.some((one) => one.fate === fate)).map((fate) => (
                <option key={fate} value={fate}>
                  {text.fates[fate]}
                </option>
              ))}
            </select>
          )}
        </Field>
      </div>
      <div class="scroll-both fate-list" tabIndex={0} role="group" aria-label={text.targets}>
        <table>
          <thead>
            <tr>
              <th scope="col">{text.columns.target}</th>
              <th scope="col">{text.columns.outcome}</th>
              <th scope="col" class="number">
                {text.columns.elevation}
              </th>
              <th scope="col" class="number">
                {text.columns.quality}
              </th>
              <th scope="col" class="number">
                {text.columns.value}
              </th>
            </tr>
          </thead>
          <tbody>
            {shown.map((one) => (
              <tr key={one.id} ref={one.id === chosen ? now : undefined} class={one.id === chosen ? "row-now" : ""}>
                <th scope="row">
                  <button
                    type="button"
                    class="plain"
                    aria-pressed={one.id === chosen}
                    onClick={() => onChoose(one.id === chosen ? null : one.id)}
                  >
                    {one.id}
                  </button>
                </th>
                <td>
                  <span class={`fate-word fate-word-${one.fate}`}>
                    {one.lacks === null ? text.fates[one.fate] : text.leftOutFor[one.lacks]}
                  </span>
                  {one.looks.map((look) => (
                    <div key={look.start}>
                      {look.carrier} {look.scan}{" "}
                      <Link to={`/plans/${look.plan}`}>{period(look.start, look.stop).replace(" UTC", "")}</Link>
                    </div>
                  ))}
                  {one.because && <div class="small">{words.value.service.told(one.because)}</div>}
                </td>
                <td class="number">{degrees(one.looks[0]?.elevation_deg ?? one.bestElevation_deg)}</td>
                <td class="number">{percent(one.looks[0]?.quality ?? null, 0)}</td>
                <td class="number">
                  {one.looks.length > 0 ? digits(one.looks.reduce((sum, look) => sum + look.value, 0)) : "–"}
                  <span class="small"> / {digits(one.priority)}</span>
                </td>
              </tr>
            ))}
          </tbody>
        </table>
        {shown.length < wanted.length && (
          <button type="button" onClick={() => setIsWhole(true)}>
            {text.more(wanted.length - shown.length)}
          </button>
        )}
      </div>
    </section>
  );
}

function degrees(angle: number | null): string {
  return angle === null ? "–" : `${number(angle)}°`;
}
