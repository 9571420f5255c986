/** The rows that were sent: used, dropped, reordered. */
import { words } from "../../i18n";
import { instant, number } from "../../i18n/forms";
import type { Comparison } from "./compare";

export function Samples({ samples }: Pick<Comparison, "samples">) {
  const text = words.value.telemetry;
  const dropped = Object.entries(samples.dropped).filter(([, count]) => count > 0);
  return (
    <section class="panel" aria-labelledby="samples">
      <h2 id="samples">{text.rows}</h2>
      <p>{text.used(samples.used, samples.read, instant(samples.start), instant(samples.stop), number(samples.step_s, 3))}</p>
      <ul>
        {dropped.map(([reason, count]) => (
          <li key={reason}>{text.dropped(count, reason)}</li>
        ))}
        {samples.reordered > 0 && <li>{text.reordered(samples.reordered)}</li>}
        {samples.wrapped > 0 && <li>{text.wrapped(samples.wrapped)}</li>}
        {samples.gaps.length > 0 && <li>{text.gaps(samples.gaps.length)}</li>}
        {samples.columns.map((column) => (
          <li key={column.name}>
            <code>{column.name}</code>: {column.axis}, {text.columnKinds[column.kind]}, {column.unit}
          </li>
        ))}
        {samples.ignored_columns.length > 0 && <li>{text.ignored(samples.ignored_columns.join(", "))}</li>}
      </ul>
    </section>
  );
}
