/** Takes one entry out of a list; label: of which. */
export function RemoveButton({ label, onRemove }: { label: string; onRemove: () => void }) {
  return (
    <button type="button" class="plain" aria-label={label} onClick={onRemove}>
      ✕
    </button>
  );
}
