/** Offsets of the target in images, from which the attitude's correction is learnt. */
import { words } from "../../i18n";
import { Field } from "../../parts/Field";
import { RemoveButton } from "../../parts/RemoveButton";
import { UtcField } from "../../parts/UtcField";
import type { ImageOffset } from "./compare";

interface Props {
  /** Of the first, unless another is typed. */
  epoch: string;
  offsets: readonly ImageOffset[];
  onOffsets: (offsets: ImageOffset[]) => void;
}

const SIGMA_DEG = 0.001;

export function Offsets({ epoch, offsets, onOffsets }: Props) {
  const text = words.value.telemetry;
  const change = (number: number, part: Partial<ImageOffset>) =>
    onOffsets(offsets.map((one, k) => (k === number ? { ...one, ...part } : one)));
  return (
    <fieldset class="columns">
      <legend>{text.offsets}</legend>
      <p class="hint">{text.offsetsHint}</p>
      {offsets.map((one, number) => {
        const [along = 0, across = 0] = one.offset_deg;
        return (
          <div key={number} class="row offset">
            <UtcField label={text.offsetAt} value={one.epoch} onValue={(epoch) => change(number, { epoch })} />
            <Degrees label={text.offsetAlong} value={along} onValue={(deg) => change(number, { offset_deg: [deg, across] })} />
            <Degrees label={text.offsetAcross} value={across} onValue={(deg) => change(number, { offset_deg: [along, deg] })} />
            <Degrees
              label={text.offsetSigma}
              value={one.sigma_deg ?? SIGMA_DEG}
              onValue={(sigma_deg) => change(number, { sigma_deg })}
            />
            <RemoveButton
              label={text.removeOffset(number + 1)}
              onRemove={() => onOffsets(offsets.filter((_, k) => k !== number))}
            />
          </div>
        );
      })}
      <button
        type="button"
        onClick={() => onOffsets([...offsets, { epoch, offset_deg: [0, 0], sigma_deg: SIGMA_DEG } as ImageOffset])}
      >
        {text.addOffset}
      </button>
    </fieldset>
  );
}

function Degrees({ label, value, onValue }: { label: string; value: number; onValue: (value: number) => void }) {
  return (
    <Field label={label}>
      {(control) => (
        <input
          {...control}
          type="number"
          step="any"
          value={value}
          onInput={(event) => {
            const typed = event.currentTarget.valueAsNumber;
            if (Number.isFinite(typed)) onValue(typed);
          }}
        />
      )}
    </Field>
  );
}
