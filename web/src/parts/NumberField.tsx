/** Numbers that are taken once they are typed. */
import { type Control, Field } from "./Field";
import { useTyped } from "./typed";

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

/** One beyond its ends is not taken. */
export function TypedNumber({ least, most, value, onValue, onClear, ...others }: NumberProps) {
  const typed = useTyped(value ?? "");
  return (
    <input
      {...others}
      {...typed}
      type="number"
      min={least}
      max={most}
      onChange={(event) => {
        const given = event.currentTarget.valueAsNumber;
        if (given >= least && given <= (most ?? given)) onValue(given);
        else if (Number.isNaN(given)) onClear?.();
      }}
    />
  );
}

export function NumberField({ label, ...number }: NumberProps & { label: string }) {
  return <Field label={label}>{(control) => <TypedNumber {...control} {...number} />}</Field>;
}
