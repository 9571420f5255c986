/** Fields without an entry of their own, folded: beside the title stand those that are set. */
import { Fields } from "./Fields";
import { membersTold } from "./labels";
import type { Members } from "./shape";

interface Props {
  title: string;
  isOpen?: boolean;
  schema: string;
  value: Members;
  path: string;
  /** Names of those with an entry of their own. */
  omit: readonly string[];
  onValue: (next: Members) => void;
}

export function FoldedFields({ title, isOpen, schema, value, path, omit, onValue }: Props) {
  const set = Object.fromEntries(Object.entries(value).filter(([name]) => !omit.includes(name)));
  return (
    <details class="fields-group" open={isOpen}>
      <summary>
        <b>{title}</b>
        <span class="small">{membersTold(schema, set)}</span>
      </summary>
      <Fields schema={schema} value={value} path={path} omit={omit} onValue={onValue} />
    </details>
  );
}
