/** Editor of any object of the schema: each field by its shape, the object itself the JSON that is sent. */
import { createContext } from "preact";
import { useContext, useId } from "preact/hooks";

import { FIELDS } from "../../api/fields";
import { words } from "../../i18n";
import { Field } from "../Field";
import { useStateOf } from "../stateOf";
import { UtcField } from "../UtcField";
import "./fields.css";
import { briefOf, faultTold, hintOf, labelOf, unitOf, valueLabel } from "./labels";
import {
  begin,
  beginUnion,
  type FieldSpec,
  faultOf,
  formOf,
  isMembers,
  type Members,
  numberOf,
  type Shape,
  schemaOf,
  without,
} from "./shape";

export interface Surroundings {
  /** Names that maps are about: the platform's axes. */
  axes: readonly string[];
  /** Known values of text fields, by the field's name. */
  known: Readonly<Record<string, readonly string[]>>;
  /** Fields that aren't for this platform, and values of fields: "Session.keyhole", "PlanRequest.final_state.idle". */
  others: readonly string[];
  /** What the service refused, by the field's dotted path. */
  refused: { path: string; why: string } | null;
}
export const FormSurroundings = createContext<Surroundings>({ axes: [], known: {}, others: [], refused: null });

interface FieldsProps {
  schema: string;
  value: Members;
  /** Dotted, from the request's root. */
  path: string;
  /** Fields that have forms of their own. */
  omit?: readonly string[];
  onValue: (value: Members) => void;
}

export function Fields({ schema, value, path, omit = [], onValue }: FieldsProps) {
  const { others: notHere } = useContext(FormSurroundings);
  // What is set all the same is shown, so that it can be taken out.
  const isHere = (name: string) => value[name] !== undefined || !notHere.includes(`${schema}.${name}`);
  const shown = Object.entries(FIELDS[schema] ?? {}).flatMap(([name, field]): [string, FieldSpec][] => {
    if (field.shape.kind === "constant" || omit.includes(name) || !isHere(name)) return [];
    return [[name, { ...field, shape: without(field.shape, notHere, `${schema}.${name}`) }]];
  });
  const simple = shown.filter(([, { shape }]) => isSimple(shape));
  const others = shown.filter(([, { shape }]) => !isSimple(shape));
  const one = ([name, field]: [string, FieldSpec]) => (
    <Editor
      key={name}
      shape={field.shape}
      field={field}
      name={name}
      label={labelOf(schema, name)}
      hint={hintOf(schema, name)}
      path={path ? `${path}.${name}` : name}
      value={value[name]}
      onValue={(next) => onValue(withMember(value, name, next))}
    />
  );
  return (
    <>
      {simple.length > 0 && <div class="fields">{simple.map(one)}</div>}
      {others.map(one)}
    </>
  );
}

/** undefined takes it out. */
export function withMember<M extends Members>(value: M, name: string, next: unknown): M {
  const { [name]: _, ...others } = value;
  if (next === undefined) return others as M;
  return name in value ? { ...value, [name]: next } : ({ ...others, [name]: next } as unknown as M);
}

function isSimple(shape: Shape): boolean {
  return ["number", "text", "instant", "flag", "choice"].includes(shape.kind);
}

interface EditorProps {
  shape: Shape;
  /** Of a field of a schema; an entry of a list has none. */
  field?: FieldSpec;
  name: string;
  label: string;
  hint?: string;
  path: string;
  value: unknown;
  onValue: (value: unknown) => void;
}

function Editor(props: EditorProps) {
  switch (props.shape.kind) {
    case "number":
      return <NumberEditor {...props} />;
    case "text":
      return <TextEditor {...props} />;
    case "instant":
      return <InstantEditor {...props} />;
    case "flag":
    case "choice":
      return <ChoiceEditor {...props} />;
    case "object":
      return <ObjectEditor {...props} schema={props.shape.of} />;
    case "union":
      return <UnionEditor {...props} shape={props.shape} />;
    case "either":
      return <EitherEditor {...props} shape={props.shape} />;
    case "vector":
      return <VectorEditor {...props} shape={props.shape} />;
    case "list":
      return <ListEditor {...props} shape={props.shape} />;
    case "map":
      return <MapEditor {...props} shape={props.shape} />;
    default:
      return (
        <p class="small">
          {props.label}: {words.value.fields.asItIs}
        </p>
      );
  }
}

/** What the service or the page finds wrong with it. */
function useFault({ shape, path, value }: Pick<EditorProps, "shape" | "path" | "value">): string | undefined {
  const { refused } = useContext(FormSurroundings);
  const fault = faultOf(shape, value);
  if (fault) return faultTold(fault);
  return refused?.path === path ? refused.why : undefined;
}

function withUnit(label: string, shape: Shape): string {
  const unit = unitOf(shape);
  return unit ? `${label}, ${unit}` : label;
}

function NumberEditor(props: EditorProps) {
  const { shape, field, label, hint, value, onValue } = props;
  const error = useFault(props);
  const text = words.value.fields;
  const isNone = value === null && field?.isNullable && field.unless !== undefined;
  return (
    <Field label={withUnit(label, shape)} hint={hint} error={error}>
      {(control) => (
        <span class="fields-number">
          <NumberInput
            control={control}
            value={value}
            placeholder={field?.unless === undefined ? "" : String(field.unless)}
            isDisabled={isNone === true}
            onValue={onValue}
          />
          {field?.isNullable && field.unless !== undefined && (
            <label>
              <input
                type="checkbox"
                checked={isNone}
                onChange={(event) => onValue(event.currentTarget.checked ? null : undefined)}
              />{" "}
              {text.none}
            </label>
          )}
        </span>
      )}
    </Field>
  );
}

interface NumberInputProps {
  control: object;
  value: unknown;
  placeholder?: string;
  isDisabled?: boolean;
  onValue: (value: number | string | undefined) => void;
}

/** A number as it is typed, with a point or a comma; "1." stays while it is typed. */
export function NumberInput({ control, value, placeholder, isDisabled, onValue }: NumberInputProps) {
  const [typed, setTyped] = useStateOf(value, (before?: string) =>
    before !== undefined && numberOf(before) === value ? before : value === undefined || value === null ? "" : String(value),
  );
  return (
    <input
      {...control}
      type="text"
      inputMode="decimal"
      autoComplete="off"
      spellcheck={false}
      placeholder={placeholder}
      disabled={isDisabled}
      value={typed}
      onInput={(event) => {
        setTyped(event.currentTarget.value);
        onValue(numberOf(event.currentTarget.value));
      }}
    />
  );
}

function TextEditor(props: EditorProps) {
  const { name, label, hint, field, value, onValue } = props;
  const { known } = useContext(FormSurroundings);
  const list = useId();
  const offers = known[name] ?? [];
  const text = value === undefined || value === null ? "" : String(value);
  const isLong = text.includes("\n") || name === "content";
  const take = (entry: string) => onValue(entry === "" && !field?.isRequired ? undefined : entry);
  return (
    <Field label={label} hint={hint} error={useFault(props)}>
      {(control) =>
        isLong ? (
          <textarea {...control} rows={4} spellcheck={false} value={text} onInput={(event) => take(event.currentTarget.value)} />
        ) : (
          <>
            <input
              {...control}
              type="text"
              list={offers.length ? list : undefined}
              autoComplete="off"
              value={text}
              onInput={(event) => take(event.currentTarget.value)}
            />
            {offers.length > 0 && (
              <datalist id={list}>
                {offers.map((offer) => (
                  <option key={offer} value={offer} />
                ))}
              </datalist>
            )}
          </>
        )
      }
    </Field>
  );
}

function InstantEditor(props: EditorProps) {
  const { label, hint, field, value, onValue } = props;
  return (
    <UtcField
      label={`${label}, UTC`}
      hint={hint}
      error={useFault(props)}
      value={value === undefined || value === null ? null : String(value)}
      onValue={onValue}
      onClear={field?.isRequired ? undefined : () => onValue(undefined)}
    />
  );
}

const FLAGS = ["true", "false"] as const;

function ChoiceEditor(props: EditorProps) {
  const { shape, field, label, hint, value, onValue } = props;
  const text = words.value.fields;
  const choices = shape.kind === "choice" ? shape.of : FLAGS;
  const given = value === undefined || value === null ? "" : String(value);
  const take = (choice: string) => {
    if (choice === "") onValue(undefined);
    else onValue(shape.kind === "flag" ? choice === "true" : choice);
  };
  return (
    <Field label={label} hint={hint} error={useFault(props)}>
      {(control) => (
        <select {...control} value={given} onChange={(event) => take(event.currentTarget.value)}>
          {!field?.isRequired && (
            <option value="">{field?.unless === undefined ? text.leftOut : text.unless(valueLabel(String(field.unless)))}</option>
          )}
          {given !== "" && !choices.includes(given) && <option value={given}>{given}</option>}
          {choices.map((choice) => (
            <option key={choice} value={choice}>
              {valueLabel(choice)}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}

/** A folded box: what it is, what is set in it. */
function Group({ props, isOpen, children }: { props: EditorProps; isOpen?: boolean; children: preact.ComponentChildren }) {
  const { shape, label, hint, path, value } = props;
  const { refused } = useContext(FormSurroundings);
  const isRefused = refused !== null && (refused.path === path || refused.path.startsWith(`${path}.`));
  return (
    <details class="fields-group" open={isOpen || isRefused}>
      <summary>
        <b>{withUnit(label, shape)}</b>
        <span class="small">{briefOf(shape, value)}</span>
      </summary>
      {hint && <p class="hint">{hint}</p>}
      {refused?.path === path && <p class="wrong">{refused.why}</p>}
      {children}
    </details>
  );
}

function ObjectEditor(props: EditorProps & { schema: string }) {
  const { schema, field, label, path, value, onValue } = props;
  return (
    <Group props={props} isOpen={field === undefined}>
      <Fields schema={schema} value={isMembers(value) ? value : {}} path={path} onValue={onValue} />
      {field && !field.isRequired && value !== undefined && <LeaveOut label={label} onClick={() => onValue(undefined)} />}
    </Group>
  );
}

function LeaveOut({ label, onClick }: { label: string; onClick: () => void }) {
  const text = words.value.fields;
  return (
    <button type="button" class="small-button" aria-label={text.leaveThisOut(label)} onClick={onClick}>
      {text.leaveOut}
    </button>
  );
}

function UnionEditor(props: EditorProps & { shape: Extract<Shape, { kind: "union" }> }) {
  const { shape, field, label, path, value, onValue } = props;
  const text = words.value.fields;
  const which = isMembers(value) ? String(value[shape.by]) : "";
  const schema = schemaOf(shape, value);
  return (
    <Group props={props} isOpen={field === undefined}>
      <Field label={text.kindOf(label)}>
        {(control) => (
          <select
            {...control}
            value={which}
            onChange={(event) => {
              const chosen = event.currentTarget.value;
              onValue(chosen === "" ? undefined : beginUnion(FIELDS, shape, chosen));
            }}
          >
            {!field?.isRequired && <option value="">{text.leftOut}</option>}
            {Object.keys(shape.of).map((one) => (
              <option key={one} value={one}>
                {valueLabel(one)}
              </option>
            ))}
          </select>
        )}
      </Field>
      {schema && isMembers(value) && <Fields schema={schema} value={value} path={path} onValue={onValue} />}
    </Group>
  );
}

function EitherEditor(props: EditorProps & { shape: Extract<Shape, { kind: "either" }> }) {
  const { shape, field, label, name, path, value, onValue } = props;
  const text = words.value.fields;
  const which = value === undefined || value === null ? -1 : formOf(FIELDS, shape.of, value);
  const form = shape.of[which];
  const formLabel = (one: Shape) =>
    one.kind === "constant" ? valueLabel(one.value) : one.kind === "object" ? valueLabel(one.of) : valueLabel(one.kind);
  return (
    <Group props={props}>
      <Field label={label}>
        {(control) => (
          <select
            {...control}
            value={String(which)}
            onChange={(event) => {
              const chosen = shape.of[Number(event.currentTarget.value)];
              onValue(chosen ? begin(FIELDS, chosen) : undefined);
            }}
          >
            {!field?.isRequired && <option value="-1">{text.leftOut}</option>}
            {shape.of.map((one, number) => (
              <option key={number} value={String(number)}>
                {formLabel(one)}
              </option>
            ))}
          </select>
        )}
      </Field>
      {form?.kind === "object" ? (
        <Fields schema={form.of} value={isMembers(value) ? value : {}} path={path} onValue={onValue} />
      ) : (
        form &&
        form.kind !== "constant" && (
          <Editor shape={form} name={name} label={formLabel(form)} path={path} value={value} onValue={onValue} />
        )
      )}
    </Group>
  );
}

function VectorEditor(props: EditorProps & { shape: Extract<Shape, { kind: "vector" }> }) {
  const { shape, field, name, label, hint, path, value, onValue } = props;
  const { refused } = useContext(FormSurroundings);
  const given = Array.isArray(value) ? (value as unknown[]) : [];
  const placeholders = Array.isArray(field?.unless) ? (field.unless as unknown[]) : [];
  const take = (number: number, next: unknown) => {
    const started = given.length ? given : shape.of.map((one, at) => placeholders[at] ?? begin(FIELDS, one));
    const changed = started.map((one, at) => (at === number ? next : one));
    onValue(changed.every((one) => one === undefined) ? undefined : changed.map((one) => one ?? ""));
  };
  const faults = shape.of.map((one, number) => faultOf(one, given[number])).filter((fault) => fault !== null);
  const why = faults[0] ? faultTold(faults[0]) : refused?.path.startsWith(path) ? refused.why : null;
  if (shape.of.some((one) => one.kind !== "number")) {
    return (
      <Group props={props}>
        {shape.of.map((one, number) => (
          <Editor
            key={number}
            shape={one}
            name={name}
            label={`${label} ${number + 1}`}
            path={`${path}.${number}`}
            value={given[number]}
            onValue={(next) => take(number, next)}
          />
        ))}
      </Group>
    );
  }
  return (
    <fieldset class="fields-vector">
      <legend>{withUnit(label, shape)}</legend>
      <div class="row">
        {shape.of.map((_, number) => (
          <NumberInput
            key={number}
            control={{ "aria-label": `${label} ${number + 1}`, "aria-invalid": why ? true : undefined }}
            value={given[number]}
            placeholder={placeholders[number] === undefined ? "" : String(placeholders[number])}
            onValue={(next) => take(number, next)}
          />
        ))}
        {!field?.isRequired && given.length > 0 && <LeaveOut label={label} onClick={() => onValue(undefined)} />}
      </div>
      {hint && <p class="hint">{hint}</p>}
      {why && <p class="wrong">{why}</p>}
    </fieldset>
  );
}

function ListEditor(props: EditorProps & { shape: Extract<Shape, { kind: "list" }> }) {
  const { shape, field, name, label, path, value, onValue } = props;
  const text = words.value.fields;
  const given = Array.isArray(value) ? (value as unknown[]) : [];
  const example = Array.isArray(field?.example) ? (field.example as unknown[])[0] : undefined;
  const take = (next: unknown[]) => onValue(next.length === 0 && !field?.isRequired ? undefined : next);
  return (
    <Group props={props} isOpen={field === undefined}>
      {given.map((one, number) => (
        <div key={number} class="fields-entry">
          <Editor
            shape={shape.of}
            name={name}
            label={`${label} ${number + 1}`}
            path={`${path}.${number}`}
            value={one}
            onValue={(next) => take(given.map((was, at) => (at === number ? (next ?? "") : was)))}
          />
          <button
            type="button"
            class="small-button"
            aria-label={text.removeThis(`${label} ${number + 1}`)}
            onClick={() => take(given.filter((_, at) => at !== number))}
          >
            {text.remove}
          </button>
        </div>
      ))}
      <button
        type="button"
        class="small-button"
        aria-label={text.addTo(label)}
        disabled={given.length >= (shape.most ?? Infinity)}
        onClick={() => take([...given, begin(FIELDS, shape.of, example)])}
      >
        {text.add}
      </button>
    </Group>
  );
}

function MapEditor(props: EditorProps & { shape: Extract<Shape, { kind: "map" }> }) {
  const { shape, label, path, value, onValue } = props;
  const { axes } = useContext(FormSurroundings);
  const text = words.value.fields;
  const given: Members = isMembers(value) ? value : {};
  // Maps of maps are by names of one's own, the others by axes.
  const isByAxis = shape.of.kind !== "map";
  const names = [...new Set([...(isByAxis ? axes : []), ...Object.keys(given)])];
  const take = (name: string, next: unknown) => {
    const changed = withMember(given, name, next);
    onValue(Object.keys(changed).length === 0 ? undefined : changed);
  };
  const [fresh, setFresh] = useStateOf(names.length, () => "");
  return (
    <Group props={props}>
      {names.map((name) => (
        <Editor
          key={name}
          shape={shape.of}
          name={name}
          label={name}
          path={`${path}.${name}`}
          value={given[name]}
          onValue={(next) => take(name, next)}
        />
      ))}
      {!isByAxis && (
        <div class="row">
          <input
            type="text"
            aria-label={text.newName(label)}
            value={fresh}
            onInput={(event) => setFresh(event.currentTarget.value)}
          />
          <button
            type="button"
            class="small-button"
            aria-label={text.addTo(label)}
            disabled={fresh.trim() === "" || fresh in given}
            onClick={() => take(fresh.trim(), begin(FIELDS, shape.of))}
          >
            {text.add}
          </button>
        </div>
      )}
    </Group>
  );
}
