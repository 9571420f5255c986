/** Progress of work; without a share it only says that it goes on. */
export function Bar({ label, percent }: { label: string; percent: number | null }) {
  return (
    <div class="progress">
      <span>{label}</span>
      <progress aria-label={label} max={100} value={percent ?? undefined} />
    </div>
  );
}
