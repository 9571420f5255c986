import { Field } from "./Field";

interface Props {
  label: string;
  least: number;
  most: number;
  value: number;
  onValue: (value: number) => void;
}

/** A number once it is typed; one beyond its ends is not taken. */
export function NumberField({ label, least, most, value, onValue }: Props) {
  return (
    <Field label={label}>
      {(control) => (
        <input
          {...control}
          type="number"
          min={least}
          max={most}
          value={value}
          onChange={(event) => {
            const given = event.currentTarget.valueAsNumber;
            if (given >= least && given <= most) onValue(given);
          }}
        />
      )}
    </Field>
  );
}
