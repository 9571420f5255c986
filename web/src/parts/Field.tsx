import type { ComponentChildren, JSX } from "preact";
import { useId } from "preact/hooks";

export interface Control {
  id: string;
  "aria-describedby": string | undefined;
  "aria-invalid": boolean | undefined;
}

interface Props {
  label: ComponentChildren;
  hint?: ComponentChildren;
  /** What is wrong with the value, as the service or the page says. */
  error?: ComponentChildren;
  class?: string;
  /** The control itself, which takes these attributes. */
  children: (control: Control) => JSX.Element;
}

/** A labelled control; its hint and its error are read out with it. */
export function Field({ label, hint, error, class: name = "", children }: Props) {
  const id = useId();
  const told = [hint && `${id}-hint`, error && `${id}-error`].filter(Boolean).join(" ");
  return (
    <div class={`field ${name}`}>
      <label for={id}>{label}</label>
      {children({ id, "aria-describedby": told || undefined, "aria-invalid": error ? true : undefined })}
      {hint && (
        <p class="hint" id={`${id}-hint`}>
          {hint}
        </p>
      )}
      {error && (
        <p class="wrong" id={`${id}-error`}>
          {error}
        </p>
      )}
    </div>
  );
}
