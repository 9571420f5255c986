/** The carrier's attitude: its law, its mean from LVLH, or a message that was pasted or dropped; a body steers itself. */
import { useState } from "preact/hooks";

import { FIELDS } from "../../api/fields";
import { words } from "../../i18n";
import { number } from "../../i18n/forms";
import { ChoiceField } from "../../parts/ChoiceField";
import { DropZone } from "../../parts/DropZone";
import { Field } from "../../parts/Field";
import { NumberInput } from "../../parts/fields/Fields";
import { FoldedFields } from "../../parts/fields/FoldedFields";
import { faultTold, labelOf, valueLabel } from "../../parts/fields/labels";
import { beginUnion, faultOf, type Members, schemaOf } from "../../parts/fields/shape";
import type { Attitude, Body } from "../../parts/platforms";
import { attitudeTold } from "../plan/identity";
import * as draft from "./draft";
import { readMessage } from "./message";
import { body, isUnlikely, platform, takeUsual, usual } from "./platforms";

const ANGLES = ["yaw_deg", "pitch_deg", "roll_deg"] as const;
const SHAPE = FIELDS.PlanRequest?.attitude?.shape;
const LAWS = SHAPE?.kind === "union" ? Object.keys(SHAPE.of) : [];
/** Those that say the same of any law. */
const SHARED = ["orbital_period_s", "uncertainty", "corrections"];

function setLaw(law: string): void {
  if (SHAPE?.kind !== "union") return;
  const before: Members = { ...draft.attitude.peek() };
  const shared = Object.fromEntries(SHARED.flatMap((name) => (name in before ? [[name, before[name]]] : [])));
  const begun = beginUnion(FIELDS, SHAPE, law);
  const message = "content" in begun ? { content: before.content ?? "" } : {};
  draft.change({ attitude: { ...begun, ...message, ...shared } as unknown as Attitude });
  if (law === "lvlh" && usual.peek()) takeUsual();
}

/** An AEM; kept under the law that takes one, if such is chosen. */
export function takeAem(content: string): void {
  const now = draft.attitude.peek();
  if (!("content" in now)) setLaw("aem");
  draft.change({ attitude: { ...draft.attitude.peek(), content } as Attitude });
}

export function AttitudePanel() {
  return body.value ? <Steering of={body.value} /> : <CarrierPanel />;
}

function Steering({ of }: { of: Body }) {
  const text = words.value.plan.attitude;
  const { roll = { rule: "nearest" }, idle = { law: "nadir" } } = of;
  return (
    <section class="panel" aria-label={text.title}>
      <h2>{text.title}</h2>
      <p>{text.steers(of.name)}</p>
      <p class="small">
        {labelOf("BodyPlatform", "roll")}: {valueLabel(roll.rule ?? "")} · {labelOf("BodyPlatform", "idle")}:{" "}
        {valueLabel(idle.law ?? "")}
      </p>
      {draft.made.value.attitude && (
        <div class="notice notice-warn" role="status">
          <p>{text.notOfBody}</p>
          <button type="button" onClick={() => draft.takeBody(draft.platform.peek())}>
            {text.leaveOut}
          </button>
        </div>
      )}
    </section>
  );
}

function CarrierPanel() {
  const text = words.value.plan.attitude;
  const attitude = draft.attitude.value;
  const schema = SHAPE ? schemaOf(SHAPE, attitude) : null;
  const mean = usual.value;
  const usualTold = mean?.map((angle) => number(angle, 3)).join("/") ?? "";
  const isUsual = attitude.law === "lvlh" && mean?.every((angle, at) => attitude[ANGLES[at] ?? "yaw_deg"] === angle);
  const name = platform.value?.name ?? "";
  return (
    <section class="panel" aria-label={text.title}>
      <details>
        <summary>
          <h2>{text.title}</h2>
          <span class="soft">{attitudeTold(attitude)}</span>
        </summary>
        <ChoiceField label={text.law} value={attitude.law} choices={LAWS} told={valueLabel} onValue={setLaw} />
        {attitude.law === "lvlh" && (
          <>
            <div class="thirds">
              {ANGLES.map((angle) => {
                const fault = faultOf(FIELDS.LvlhAttitude?.[angle]?.shape ?? { kind: "json" }, attitude[angle]);
                return (
                  <Field key={angle} label={text[angle]} error={fault ? faultTold(fault) : undefined}>
                    {(control) => (
                      <NumberInput
                        control={control}
                        value={attitude[angle]}
                        placeholder="0"
                        onValue={(value) => draft.change({ attitude: withAngle(attitude, angle, value) })}
                      />
                    )}
                  </Field>
                );
              })}
            </div>
            <p class="hint">{text.hint}</p>
          </>
        )}
        {"content" in attitude && <Message content={attitude.content} />}
        {schema && (
          <FoldedFields
            title={text.more}
            isOpen={attitude.law === "inertial"}
            schema={schema}
            value={attitude as unknown as Members}
            path="attitude"
            omit={OWN}
            onValue={(next) => draft.change({ attitude: next as unknown as Attitude })}
          />
        )}
        {mean && !isUsual && !isUnlikely.value && (
          <button type="button" onClick={takeUsual}>
            {text.takeUsual(usualTold, name)}
          </button>
        )}
      </details>
      {isUnlikely.value && (
        <div class="notice notice-warn attitude-unlikely" role="status">
          <p>{text.unlikely(name, usualTold)}</p>
          <button type="button" onClick={takeUsual}>
            {text.takeUsual(usualTold, name)}
          </button>
        </div>
      )}
    </section>
  );
}

/** Members that this panel has entries of its own for. */
const OWN: readonly string[] = [...ANGLES, "content", "law"];

function withAngle(attitude: Attitude, name: string, value: unknown): Attitude {
  return { ...attitude, [name]: value ?? 0 } as Attitude;
}

function Message({ content }: { content: string }) {
  const text = words.value.plan.attitude;
  const [wrong, setWrong] = useState<string | null>(null);
  const read = async (file: File) => {
    const message = await readMessage(file);
    setWrong(message === null ? words.value.plan.orbit.tooLong : null);
    if (message !== null) takeAem(message);
  };
  return (
    <DropZone label={words.value.plan.orbit.file} onFile={(file) => void read(file)}>
      <Field label={text.message} hint={text.messageHint} error={wrong ?? (content.trim() ? undefined : text.noMessage)}>
        {(control) => (
          <textarea
            {...control}
            rows={3}
            spellcheck={false}
            value={content}
            onInput={(event) => takeAem(event.currentTarget.value)}
          />
        )}
      </Field>
    </DropZone>
  );
}
