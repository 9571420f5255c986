/** Identity of an answer under its title, in the tab and on paper. */
import { words } from "../i18n";
import { instant } from "../i18n/forms";
import { usePaper, useSubject } from "./paper";
import "./parts.css";

interface Props {
  name: string;
  /** When, by what, on what. */
  parts: readonly string[];
  /** Its id, and its request's checksum. */
  proof: readonly string[];
  /** When it was asked for and by whom, null where the service knows no keys; without `by` nothing was planned. */
  made: { at: string; by?: string | null };
}

export function Identity({ name, parts, proof, made }: Props) {
  const text = words.value.plan.one.identity;
  const told = [name, ...parts].join(", ");
  const when = instant(made.at);
  const begun = made.by === undefined ? text.computed(when) : text.planned(when, made.by);
  useSubject(told);
  usePaper(told, [name, ...proof].join(", "), `${begun} · ${text.approved} ____________`);
  return (
    <p class="identity" data-testid="identity">
      {[...parts, ...proof].map((part) => (
        <span key={part}>{part}</span>
      ))}
    </p>
  );
}
