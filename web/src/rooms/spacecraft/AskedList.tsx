/** The requested areas, one line each. */
import { words } from "../../i18n";
import { named } from "../../i18n/forms";
import { RemoveButton } from "../../parts/RemoveButton";
import { type Asked, positionsOf } from "./session";

const LEAST_PRIORITY = 1e-6;

export function AskedList({ asked, onAsked }: { asked: readonly Asked[]; onAsked: (asked: Asked[]) => void }) {
  const text = words.value.spacecraft;
  if (asked.length === 0) return <p class="hint">{text.none}</p>;
  return (
    <div class="scroll-both asked" tabIndex={0} role="group" aria-label={text.asked}>
      <table>
        <thead>
          <tr>
            <th scope="col">{text.columns.request}</th>
            <th scope="col">{text.columns.mode}</th>
            <th scope="col" class="number">
              {text.columns.positions}
            </th>
            <th scope="col">{text.columns.priority}</th>
            <th scope="col">
              <span class="hidden">{text.columns.actions}</span>
            </th>
          </tr>
        </thead>
        <tbody>
          {asked.map((one, number) => (
            <tr key={number}>
              <th scope="row">{one.name}</th>
              <td>
                <span class={`key-mode key-${one.mode}`}>{named(text.modes, one.mode)}</span>
              </td>
              <td class="number">{positionsOf(one).length}</td>
              <td>
                <input
                  type="number"
                  class="priority"
                  aria-label={text.priorityOf(one.name)}
                  min={LEAST_PRIORITY}
                  step="any"
                  value={one.priority ?? 1}
                  onChange={(event) => {
                    const priority = event.currentTarget.valueAsNumber;
                    if (priority >= LEAST_PRIORITY)
                      onAsked(asked.map((other, k) => (k === number ? { ...other, priority } : other)));
                  }}
                />
              </td>
              <td>
                <RemoveButton label={text.removeOne(one.name)} onRemove={() => onAsked(asked.filter((_, k) => k !== number))} />
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
