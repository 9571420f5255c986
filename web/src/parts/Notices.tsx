/** Sentences to be read before all else, of one kind; nothing where there are none. */
interface Props {
  label: string;
  told: readonly string[];
  kind?: "notice-warn" | "";
}

export function Notices({ label, told, kind = "notice-warn" }: Props) {
  if (told.length === 0) return null;
  return (
    <section class={`notice ${kind}`} aria-label={label}>
      <ul>
        {told.map((one) => (
          <li key={one}>{one}</li>
        ))}
      </ul>
    </section>
  );
}
