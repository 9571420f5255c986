/** A table in a panel, declared by its columns; the first names the row. */
import type { ComponentChildren } from "preact";

import { period } from "../i18n/forms";

/** A heading, what stands under it, and in which class. */
export type Column<Row> = [
  heading: string,
  told: (row: Row, index: number) => ComponentChildren,
  kind?: "number" | "mono nowrap",
];

interface Props<Row> {
  title: string;
  rows: readonly Row[];
  columns: readonly Column<Row>[];
  class?: string;
}

export function TablePanel<Row>({ title, rows, columns, class: name = "" }: Props<Row>) {
  return (
    <section class={`panel scroll-x ${name}`} tabIndex={0} aria-label={title}>
      <h2>{title}</h2>
      <table class="declared">
        <thead>
          <tr>
            {columns.map(([heading, , kind], at) => (
              <th key={at} scope="col" class={kind === "number" ? kind : undefined}>
                {heading}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {rows.map((row, index) => (
            <tr key={index}>
              {columns.map(([, told, kind], at) =>
                at === 0 ? (
                  <th key={at} scope="row">
                    {told(row, index)}
                  </th>
                ) : (
                  <td key={at} class={kind}>
                    {told(row, index)}
                  </td>
                ),
              )}
            </tr>
          ))}
        </tbody>
      </table>
    </section>
  );
}

/** Of a row's times, the zone understood. */
export function timesOf({ start, stop }: { start: string; stop: string }): string {
  return period(start, stop).replace(" UTC", "");
}
