/** Numbers that are taken once they are typed. */
import { useState } from "preact/hooks";

import { type Control, Field } from "./Field";

interface NumberProps extends Partial<Control> {
  class?: string;
  "aria-label"?: string;
  least: number;
  most?: number;
  /** Between two values; 1 unless given. */
  step?: number | "any";
  value: number | null;
  placeholder?: string;
  onValue: (value: number) => void;
  /** Of one that may be left out. */
  onClear?: () => void;
}

/** One beyond its ends is not taken.  What is drawn anew while it is typed leaves it as it is. */
export function TypedNumber({ least, most, value, onValue, onClear, ...others }: NumberProps) {
  const [typed, setTyped] = useState<string | null>(null);
  return (
    <input
      {...others}
      type="number"
      min={least}
      max={most}
      value={typed ?? value ?? ""}
      onInput={(event) => setTyped(event.currentTarget.value)}
      onChange={(event) => {
        const given = event.currentTarget.valueAsNumber;
        if (given >= least && given <= (most ?? given)) onValue(given);
        else if (event.currentTarget.value === "" && Number.isNaN(given)) onClear?.();
        setTyped(null);
      }}
    />
  );
}

export function NumberField({ label, ...number }: NumberProps & { label: string }) {
  return <Field label={label}>{(control) => <TypedNumber {...control} {...number} />}</Field>;
}
