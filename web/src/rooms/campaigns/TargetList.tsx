/** The targets asked for: added by name, changed and removed in their rows, each beside what is wrong with it. */
import { Fragment } from "preact";
import { useRef, useState } from "preact/hooks";

import { get } from "../../api/client";
import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { Combobox } from "../../parts/Combobox";
import { Field } from "../../parts/Field";
import { Fields } from "../../parts/fields/Fields";
import { membersTold, valueLabel } from "../../parts/fields/labels";
import type { Members } from "../../parts/fields/shape";
import { useKept } from "../../parts/kept";
import { TypedNumber } from "../../parts/NumberField";
import { RemoveButton } from "../../parts/RemoveButton";
import { places } from "../planning/names";
import { groundOf, schemaOfMode, textOf } from "../planning/target";
import { type CampaignTarget, type FieldError, modeIn } from "./campaign";

const SHOWN = 200;
const CANDIDATES = 6;
const LEAST_PRIORITY = 1e-6;
const SCHEMA = "CampaignTarget";
/** Members that a row's own cells change, or the map. */
const IN_ROW = ["id", "target", "priority", "session_s"];
const PLACED = ["geometry", "latitude_deg", "longitude_deg", "height_m", "name"];

interface Props {
  targets: readonly CampaignTarget[];
  /** Of those that were refused. */
  faults?: ReadonlyMap<CampaignTarget, readonly FieldError[]>;
  onTargets: (targets: CampaignTarget[]) => void;
  /** By name; unless given, none is added so, and targets have no other members than the row's. */
  onAdd?: (target: CampaignTarget["target"]) => void;
}

export function TargetList({ targets, faults = new Map(), onTargets, onAdd }: Props) {
  const text = words.value.campaigns;
  const shown = targets.map((one, number) => ({ one, number })).filter(({ one, number }) => number < SHOWN || faults.has(one));
  const [opened, setOpened] = useState<number | null>(null);
  const change = (number: number, next: CampaignTarget) => onTargets(targets.map((one, k) => (k === number ? next : one)));
  return (
    <>
      {onAdd && <AddTarget onAdd={onAdd} />}
      <div class="scroll-both targets" tabIndex={0} role="group" aria-label={text.targets}>
        <table>
          <thead>
            <tr>
              <th scope="col">{text.columns.target}</th>
              <th scope="col">{text.columns.priority}</th>
              <th scope="col">{text.columns.session}</th>
              <th scope="col">
                <span class="hidden">{text.columns.actions}</span>
              </th>
            </tr>
          </thead>
          <tbody>
            {shown.map(({ one, number }) => (
              <Fragment key={number}>
                <tr class={faults.has(one) ? "row-wrong" : ""}>
                  <th scope="row">
                    {one.id} {onAdd && <span class="small">{othersTold(one)}</span>}
                    {faults.get(one)?.map((fault) => (
                      <Fault
                        key={fault.field}
                        fault={fault}
                        onName={(name) => change(number, { ...one, target: { mode: "place", name } })}
                      />
                    ))}
                  </th>
                  <td>
                    <TypedNumber
                      class="amount"
                      step="any"
                      aria-label={text.priorityOf(one.id)}
                      least={LEAST_PRIORITY}
                      value={one.priority ?? 1}
                      onValue={(priority) => change(number, { ...one, priority })}
                    />
                  </td>
                  <td>
                    {modeIn(one.target) ? (
                      <span class={`key-mode key-${one.target.mode}`}>{valueLabel(one.target.mode)}</span>
                    ) : (
                      <Length one={one} onTarget={(next) => change(number, next)} />
                    )}
                  </td>
                  <td class="nowrap">
                    {onAdd && (
                      <button
                        type="button"
                        class="plain"
                        aria-label={text.moreOf(one.id)}
                        aria-expanded={opened === number}
                        onClick={() => setOpened(opened === number ? null : number)}
                      >
                        …
                      </button>
                    )}
                    <RemoveButton
                      label={text.removeOne(one.id)}
                      onRemove={() => onTargets(targets.filter((_, k) => k !== number))}
                    />
                  </td>
                </tr>
                {opened === number && (
                  <tr>
                    <td colSpan={4}>
                      <Others one={one} path={`targets.${number}`} onTarget={(next) => change(number, next)} />
                    </td>
                  </tr>
                )}
              </Fragment>
            ))}
          </tbody>
        </table>
        {targets.length > shown.length && <p class="small">{text.more(targets.length - shown.length)}</p>}
      </div>
    </>
  );
}

/** Looks, group and roll of a target, and what its kind has beside where it is. */
function Others({ one, path, onTarget }: { one: CampaignTarget; path: string; onTarget: (next: CampaignTarget) => void }) {
  const schema = schemaOfMode(one.target.mode);
  const mode = one.target as unknown as Members;
  return (
    <>
      <Fields
        schema={SCHEMA}
        value={one as unknown as Members}
        path={path}
        omit={modeIn(one.target) ? [...IN_ROW, "min_session_s"] : IN_ROW}
        onValue={(next) => onTarget(next as unknown as CampaignTarget)}
      />
      {schema && (
        <Fields
          schema={schema}
          value={mode}
          path={`${path}.target`}
          omit={PLACED}
          onValue={(next) => onTarget({ ...one, target: next as unknown as CampaignTarget["target"] })}
        />
      )}
    </>
  );
}

function othersTold(one: CampaignTarget): string {
  return membersTold(SCHEMA, Object.fromEntries(Object.entries(one).filter(([name]) => !IN_ROW.includes(name))));
}

function AddTarget({ onAdd }: { onAdd: NonNullable<Props["onAdd"]> }) {
  const text = words.value.campaigns;
  const [typed, setTyped] = useKept("/campaigns target", "");
  const form = useRef<HTMLFormElement>(null);
  const add = (given: string) => {
    const target = groundOf(given);
    if (target?.mode === "ground" || target?.mode === "place") onAdd(target);
    setTyped("");
  };
  return (
    <form
      ref={form}
      onSubmit={(event) => {
        event.preventDefault();
        add(typed);
      }}
    >
      <Field label={text.add} hint={text.addHint}>
        {(control) => (
          <span class="row">
            <Combobox
              control={control}
              value={typed}
              onValue={setTyped}
              onTake={add}
              onLeave={() => undefined}
              offered={words.value.plan.target.offered.ground}
              offers={places}
            />
            <button type="submit" disabled={!typed.trim()}>
              {text.addOne}
            </button>
          </span>
        )}
      </Field>
    </form>
  );
}

/** How long one look is held; the scans of an imaging mode are as long as they need. */
function Length({ one, onTarget }: { one: CampaignTarget; onTarget: (next: CampaignTarget) => void }) {
  const { session_s: length_s = null, min_session_s: least_s = null } = one;
  return (
    <>
      {least_s !== null && length_s !== null && least_s < length_s && `${least_s}–`}
      <TypedNumber
        class="amount"
        step="any"
        aria-label={words.value.campaigns.lengthOf(one.id)}
        least={0.2}
        value={length_s}
        onValue={(session_s) =>
          onTarget({ ...one, session_s, ...(least_s !== null && { min_session_s: Math.min(least_s, session_s) }) })
        }
      />
    </>
  );
}

/** What is wrong with a target; of a name also the places that it may mean. */
function Fault({ fault: { field, detail, value }, onName }: { fault: FieldError; onName: (name: string) => void }) {
  const text = words.value.campaigns;
  const asked = field.endsWith(".target.name") && typeof value === "string" ? value : null;
  const { answer: candidates } = useRequest(asked, (until) => candidatesFor(asked ?? "", until));
  return (
    <>
      <p class="wrong">{words.value.service.told(detail)}</p>
      {candidates && candidates.length > 0 && (
        <p class="row candidates">
          {text.means}
          {candidates.map((name) => (
            <button key={name} type="button" class="small-button" onClick={() => onName(name)}>
              {name}
            </button>
          ))}
        </p>
      )}
    </>
  );
}

/** Places called so, or else those that are called alike. */
async function candidatesFor(name: string, until: AbortSignal): Promise<string[]> {
  const answer = await get("/v1/places", { query: { begin: name }, signal: until });
  const names = answer.places.map((one) => one.name);
  const same = names.filter((one) => one.split(",")[0]?.toLowerCase() === name.trim().toLowerCase());
  return (same.length > 0 ? same : names).slice(0, CANDIDATES);
}

/** An id for a target that has none yet, unlike those there are. */
export function idFor(target: CampaignTarget["target"], targets: readonly CampaignTarget[]): string {
  const named = target.mode === "place" ? (target.name.split(",")[0] ?? target.name) : textOf(target);
  const taken = new Set(targets.map((one) => one.id));
  let id = named;
  for (let number = 2; taken.has(id); number++) id = `${named} ${number}`;
  return id;
}
