/** Identity of an answer under its title, in the tab and on paper. */
import { usePaper, useSubject } from "./paper";
import "./parts.css";

interface Props {
  name: string;
  /** When, by what, on what. */
  parts: readonly string[];
  /** Its id, and its request's checksum. */
  proof: readonly string[];
}

export function Identity({ name, parts, proof }: Props) {
  const told = [name, ...parts].join(", ");
  useSubject(told);
  usePaper(told, [name, ...proof].join(", "));
  return (
    <p class="identity" data-testid="identity">
      {[...parts, ...proof].map((part) => (
        <span key={part}>{part}</span>
      ))}
    </p>
  );
}
