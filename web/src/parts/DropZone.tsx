/** Takes files: dropped on what stands in it, or chosen. */
import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";

interface Props {
  /** Of the button that chooses. */
  label: string;
  accept?: string;
  /** Whether several may be chosen at once. */
  multiple?: boolean;
  /** Called for each. */
  onFile: (file: File) => void;
  children?: ComponentChildren;
}

export function DropZone({ label, accept, multiple, onFile, children }: Props) {
  const [isOver, setIsOver] = useState(false);
  const take = (files: FileList | null | undefined) => {
    for (const file of [...(files ?? [])].slice(0, multiple ? undefined : 1)) onFile(file);
  };
  return (
    <div
      class={`drop-zone ${isOver ? "drop-zone-over" : ""}`}
      onDragOver={(event) => {
        event.preventDefault();
        setIsOver(true);
      }}
      onDragLeave={() => setIsOver(false)}
      onDrop={(event) => {
        event.preventDefault();
        setIsOver(false);
        take(event.dataTransfer?.files);
      }}
    >
      {children}
      <label class="button">
        {label}
        <input
          class="hidden"
          type="file"
          accept={accept}
          multiple={multiple}
          onChange={(event) => {
            take(event.currentTarget.files);
            event.currentTarget.value = "";
          }}
        />
      </label>
    </div>
  );
}
