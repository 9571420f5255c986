/** Windows as bars over time and in a list, of which one may be taken, and what the search warns of. */
import type { ComponentChildren } from "preact";

import { words } from "../i18n";
import { Overview } from "./Overview";
import { PassFigures } from "./PassFigures";
import type { Pass } from "./sight";

interface Props<P extends Pass> {
  windows: readonly (P & { session: object | null })[];
  taken: P | null;
  from_ms: number;
  to_ms: number;
  label: string;
  onTake: (window: P) => void;
  /** What is told of one beside its figures. */
  more: (window: P) => ComponentChildren;
  /** Between the bars and the list. */
  children?: ComponentChildren;
  warnings: readonly string[];
}

export function WindowList<P extends Pass>({ windows, warnings, ...shown }: Props<P>) {
  return (
    <>
      {windows.length > 0 && <List windows={windows} {...shown} />}
      {warnings.map((one) => (
        <p key={one} class="hint">
          {words.value.service.told(one)}
        </p>
      ))}
    </>
  );
}

type Shown<P extends Pass> = Omit<Props<P>, "warnings">;

function List<P extends Pass>({ windows, taken, from_ms, to_ms, label, onTake, more, children }: Shown<P>) {
  return (
    <>
      <Overview passes={windows} taken={(one) => one === taken} from_ms={from_ms} to_ms={to_ms} onTake={onTake} />
      {children}
      <ul class="window-list" aria-label={label} tabIndex={0}>
        {windows.map((one, index) => (
          <li key={index}>
            <button type="button" class="window" aria-pressed={one === taken} disabled={!one.session} onClick={() => onTake(one)}>
              <PassFigures pass={one} />
              {more(one)}
            </button>
          </li>
        ))}
      </ul>
    </>
  );
}
