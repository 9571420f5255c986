/** The request as a whole: its name and platform, its file, and templates to begin with. */
import { useState } from "preact/hooks";

import { save } from "../../api/download";
import { FIELDS } from "../../api/fields";
import { words } from "../../i18n";
import { DropZone } from "../../parts/DropZone";
import { Field } from "../../parts/Field";
import { pathTold } from "../../parts/fields/labels";
import { unknownIn } from "../../parts/fields/shape";
import { PlatformField, PlatformMembers } from "../../parts/PlatformField";
import { usualOf } from "../../parts/platforms";
import { RequestText } from "../../parts/RequestText";
import * as draft from "./draft";
import { readMessage } from "./message";
import { failure } from "./refusal";
import { deleteTemplate, saveTemplate, templates } from "./templates";

export function RequestPanel() {
  const text = words.value.plan.request;
  const asked = draft.platform.value;
  const made = draft.made.value;
  return (
    <section class="panel" aria-label={text.title}>
      <details>
        <summary>
          <h2>{text.title}</h2>
          <span class="soft">
            {made.name || draft.targetsTold() || text.unnamed} · {typeof asked === "string" ? asked : asked.name}
          </span>
        </summary>
        <div class="pair">
          <Field label={text.name} hint={text.nameHint}>
            {(control) => (
              <input
                {...control}
                type="text"
                value={made.name ?? ""}
                placeholder={draft.targetsTold()}
                onInput={(event) => draft.change({ name: event.currentTarget.value })}
              />
            )}
          </Field>
          <PlatformField
            asked={asked}
            onPlatform={(next, found) => (found.kind === "body" ? draft.takeBody(next) : draft.takeAxes(next, usualOf(found)))}
          />
        </div>
        <PlatformMembers asked={asked} onMembers={(platform) => draft.change({ platform })} />
        <FileEntry />
        <Templates />
      </details>
      <Carried />
    </section>
  );
}

/** Members that no field here shows, by their names. */
function Carried() {
  const text = words.value.plan.request;
  const made = draft.made.value;
  const unknown = unknownIn(FIELDS, "PlanRequest", made);
  return (
    <>
      {unknown.length > 0 && (
        <p class="notice notice-warn">
          {text.carried} <b>{unknown.map((path) => pathTold("PlanRequest", made, path)).join(", ")}</b>
        </p>
      )}
    </>
  );
}

function FileEntry() {
  const text = words.value.plan.request;
  const [wrong, setWrong] = useState<string | null>(null);
  const take = async (file: File) => {
    const content = await readMessage(file);
    const request = content === null ? null : readRequest(content);
    setWrong(content === null ? words.value.plan.orbit.tooLong : request ? null : text.noRequest(file.name));
    if (request) begin(request);
  };
  return (
    <>
      <DropZone label={text.open} accept=".json,application/json" onFile={(file) => void take(file)}>
        <p class="small">{text.openHint}</p>
        <button
          type="button"
          onClick={() =>
            save(
              new Blob([`${JSON.stringify(draft.request.value, null, 2)}\n`], { type: "application/json" }),
              `${draft.request.value.name || "plan"}.json`,
            )
          }
        >
          {text.save}
        </button>
      </DropZone>
      {wrong && (
        <p class="wrong" role="alert">
          {wrong}
        </p>
      )}
      <details class="fields-group">
        <summary>
          <b>{text.json}</b>
        </summary>
        <RequestText
          request={draft.made.value}
          hint={text.jsonHint}
          onRequest={(next) => {
            const request = draft.requestOf(next);
            setWrong(request ? null : text.noRequest("JSON"));
            if (request) draft.made.value = request;
          }}
        />
      </details>
    </>
  );
}

function readRequest(content: string): draft.DraftRequest | null {
  try {
    return draft.requestOf(JSON.parse(content));
  } catch {
    return null; // which is said
  }
}

/** A request from outside takes the place of what is there. */
function begin(request: draft.DraftRequest): void {
  failure.value = null;
  draft.load(request, null);
}

function Templates() {
  const text = words.value.plan.request;
  const [name, setName] = useState("");
  const [wrong, setWrong] = useState<string | null>(null);
  const keep = () => {
    try {
      saveTemplate({ name: name.trim(), request: draft.made.value, conditions: draft.conditions.value });
      setWrong(null);
      setName("");
    } catch (error) {
      setWrong(text.noRoom(String(error)));
    }
  };
  return (
    <fieldset>
      <legend>{text.templates}</legend>
      <form
        class="row"
        onSubmit={(event) => {
          event.preventDefault();
          keep();
        }}
      >
        <input
          type="text"
          aria-label={text.templateName}
          placeholder={text.templateName}
          value={name}
          onInput={(event) => setName(event.currentTarget.value)}
        />
        <button type="submit" disabled={name.trim() === ""}>
          {text.saveTemplate}
        </button>
      </form>
      {wrong && (
        <p class="wrong" role="alert">
          {wrong}
        </p>
      )}
      <ul class="templates" aria-label={text.templates}>
        {templates.value.map((one) => (
          <li key={one.name} class="row">
            <button
              type="button"
              onClick={() => {
                begin(one.request);
                draft.conditions.value = one.conditions;
              }}
            >
              {one.name}
            </button>
            <button
              type="button"
              class="plain"
              aria-label={text.deleteTemplate(one.name)}
              onClick={() => deleteTemplate(one.name)}
            >
              ×
            </button>
          </li>
        ))}
      </ul>
      <p class="hint">{text.templatesHint}</p>
    </fieldset>
  );
}
