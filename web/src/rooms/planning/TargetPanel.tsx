/** The chosen session's target: a place, coordinates, a star or a body. */
import { Problem } from "../../api/problem";
import { words } from "../../i18n";
import { Combobox } from "../../parts/Combobox";
import { Field } from "../../parts/Field";
import { useStateOf } from "../../parts/stateOf";
import * as draft from "./draft";
import { places, stars } from "./names";
import { BODIES, groundOf, type Kind, kindOf, starOf, type Target, textOf } from "./target";
import { found, searchError } from "./windows";

const KINDS: readonly Kind[] = ["ground", "star", "body"];

export function TargetPanel() {
  const text = words.value.plan.target;
  const target = draft.target.value;
  const [kind, setKind] = useStateOf<Kind>(target, (before = "ground") => {
    const now = target ? kindOf(target) : "other";
    return now === "other" ? before : now;
  });
  const count = draft.sessions.value.length;
  return (
    <section class="panel" aria-label={text.title}>
      <h2>
        {text.title}
        {count > 1 && <span class="soft"> · {text.ofSession(draft.chosen.value + 1, count)}</span>}
      </h2>
      <fieldset class="choice">
        <legend class="hidden">{text.kind}</legend>
        {KINDS.map((one) => (
          <label key={one}>
            <input type="radio" name="kind" checked={kind === one} onChange={() => setKind(one)} />
            <span>{text.kinds[one]}</span>
          </label>
        ))}
      </fieldset>
      {kind === "body" ? <BodyField target={target} /> : <TextField key={kind} kind={kind} target={target} />}
      {found.value?.assumed && <p class="hint">{text.taken(found.value.assumed)}</p>}
    </section>
  );
}

function TextField({ kind, target }: { kind: "ground" | "star"; target: Target | undefined }) {
  const text = words.value.plan.target;
  const own = target && kindOf(target) === kind ? textOf(target) : "";
  const [typed, setTyped] = useStateOf(own, () => own);
  const take = (entry: string) => {
    const next = kind === "star" ? starOf(entry) : groundOf(entry);
    if (next && entry !== own) draft.setTarget(next);
  };
  const error = searchError.value;
  const isWrong = error instanceof Problem && error.field?.startsWith("targets.0.target");
  const offers = isWrong ? offersOf(error.document.detail) : [];
  return (
    <form
      onSubmit={(event) => {
        event.preventDefault();
        take(typed);
      }}
    >
      <Field label={text.labels[kind]} hint={text.hints[kind]} error={isWrong ? error.document.detail : undefined}>
        {(props) => (
          <span class="entry">
            <Combobox
              control={props}
              value={typed}
              onValue={setTyped}
              onTake={take}
              onLeave={() => take(typed)}
              offered={text.offered[kind]}
              offers={kind === "star" ? stars : places}
            />
            <button type="submit">{text.find}</button>
          </span>
        )}
      </Field>
      {offers.length > 0 && (
        <div class="row" role="group" aria-label={text.meant}>
          {offers.map((offer) => (
            <button key={offer} type="button" class="small-button" onClick={() => take(offer)}>
              {offer}
            </button>
          ))}
        </div>
      )}
    </form>
  );
}

/** The names that a refusal offers: 'Springfield, Ohio, US' (39.92, -83.81), or "do you mean Vega?" */
function offersOf(detail: string): string[] {
  const named = [...detail.matchAll(/'([^']+, [A-Z]{2})'/g)].map((match) => match[1] ?? "");
  const star = /do you mean ([^'?]+)\?/.exec(detail)?.[1];
  return named.length ? [...new Set(named)] : (star?.split(" or ") ?? []);
}

function BodyField({ target }: { target: Target | undefined }) {
  const text = words.value.plan.target;
  return (
    <Field label={text.labels.body}>
      {(props) => (
        <select
          {...props}
          value={target?.mode === "body" ? target.name : ""}
          onChange={(event) => draft.setTarget({ mode: "body", name: event.currentTarget.value })}
        >
          <option value="" disabled>
            {text.choose}
          </option>
          {BODIES.map((body) => (
            <option key={body} value={body}>
              {text.bodies[body]}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}
