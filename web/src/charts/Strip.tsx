/** One chart under its name, unit, lines' names and the figure to remember. */
import type { ComponentChildren } from "preact";

interface Props {
  name: string;
  unit: string;
  /** Names of the lines, in the order of the colours. */
  keys: readonly string[];
  /** The figure to remember. */
  fact: string;
  children: ComponentChildren;
}

export function Strip({ name, unit, keys, fact, children }: Props) {
  return (
    <div class="chart-strip">
      <h3>
        {name}, {unit}
        {keys.map((key, k) => (
          <span key={key} class={`key-line key-series-${k + 1}`}>
            {key}
          </span>
        ))}
        <span class="small">{fact}</span>
      </h3>
      {children}
    </div>
  );
}
