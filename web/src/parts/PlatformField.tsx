/** The choice of a platform by its name, and its members where it is written out. */
import { useEffect } from "preact/hooks";

import { words } from "../i18n";
import { Field } from "./Field";
import { Fields } from "./fields/Fields";
import type { Members } from "./fields/shape";
import { type AskedPlatform, findPlatform, learnPlatforms, type Platform, platforms } from "./platforms";

const WRITTEN_OUT = "";

interface Props {
  asked: AskedPlatform;
  /** asked: as the request has it from now on; found: the same, written out. */
  onPlatform: (asked: AskedPlatform, found: Platform) => void;
}

export function PlatformField({ asked, onPlatform }: Props) {
  const text = words.value.plan.request;
  useEffect(() => {
    const until = new AbortController();
    // Without them a form lacks the names, the usual attitude and the axes; whatever else is wrong shows elsewhere.
    void learnPlatforms(until.signal).catch(() => undefined);
    return () => until.abort();
  }, []);
  /** Another registered one, or the one that is there in numbers, to be changed. */
  const take = (name: string) => {
    const found = findPlatform(name === WRITTEN_OUT ? asked : name);
    if (found) onPlatform(name === WRITTEN_OUT ? { ...found } : name, found);
  };
  return (
    <Field label={text.platform} hint={text.platformHint}>
      {(control) => (
        <select
          {...control}
          value={typeof asked === "string" ? asked : WRITTEN_OUT}
          onChange={(event) => take(event.currentTarget.value)}
        >
          {(platforms.value ?? []).map((one) => (
            <option key={one.name} value={one.name}>
              {one.name}
            </option>
          ))}
          <option value={WRITTEN_OUT}>{text.writtenOut}</option>
        </select>
      )}
    </Field>
  );
}

/** Nothing where the platform goes by its name. */
export function PlatformMembers({ asked, onMembers }: { asked: AskedPlatform; onMembers: (next: AskedPlatform) => void }) {
  if (typeof asked === "string") return null;
  return (
    <details class="fields-group">
      <summary>
        <b>{words.value.plan.request.platformOf(asked.name)}</b>
      </summary>
      <Fields
        key={asked.kind}
        schema={asked.kind === "body" ? "BodyPlatform" : "PlatformDefinition"}
        value={asked as unknown as Members}
        path="platform"
        onValue={(next) => onMembers(next as unknown as AskedPlatform)}
      />
    </details>
  );
}
