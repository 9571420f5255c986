import { Field } from "./Field";

interface Props<Choice extends string> {
  label: string;
  value: Choice;
  choices: readonly Choice[];
  told: (choice: Choice) => string;
  onValue: (choice: Choice) => void;
}

/** One of several, which are all there are. */
export function ChoiceField<Choice extends string>({ label, value, choices, told, onValue }: Props<Choice>) {
  return (
    <Field label={label}>
      {(control) => (
        <select {...control} value={value} onChange={(event) => onValue(event.currentTarget.value as Choice)}>
          {choices.map((one) => (
            <option key={one} value={one}>
              {told(one)}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}
