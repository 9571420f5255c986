/** The looks of several carriers over time, a row each; a press on a name shows that carrier alone. */
import { words } from "../../i18n";
import { digits, period } from "../../i18n/forms";
import type { TargetFate } from "./campaign";

interface Props {
  colours: ReadonlyMap<string, string>;
  fates: readonly TargetFate[];
  start: string;
  stop: string;
  chosen: string | null;
  onChoose: (id: string | null) => void;
  only: string | null;
  onOnly: (carrier: string | null) => void;
}

const WIDE = 1000; // of a row, in its own units
const LEAST = 3; // of a look, so that it is seen among days
const HIGH = 18;

export function Carriers({ colours, fates, start, stop, chosen, onChoose, only, onOnly }: Props) {
  const text = words.value.campaigns;
  const [from_ms, to_ms] = [Date.parse(start), Date.parse(stop)];
  const placeOf = (at: string) => (WIDE * (Date.parse(at) - from_ms)) / (to_ms - from_ms);
  const rows = new Map([...colours.keys()].map((carrier) => [carrier, [] as { id: string; look: Look }[]]));
  for (const { id, looks } of fates) for (const look of looks) rows.get(look.carrier ?? "")?.push({ id, look });
  return (
    <section class="panel" aria-labelledby="campaign-carriers">
      <h2 id="campaign-carriers">
        {text.carriers} <span class="count">{colours.size}</span>
      </h2>
      <p class="hint">{text.carriersHint}</p>
      <ul class="carriers">
        {[...rows].map(([carrier, looks]) => (
          <li key={carrier} class={only !== null && only !== carrier ? "carrier-pale" : ""}>
            <button
              type="button"
              class="plain carrier-name"
              aria-pressed={only === carrier}
              onClick={() => onOnly(only === carrier ? null : carrier)}
            >
              <span class="carrier-dot" style={{ background: colours.get(carrier) }} aria-hidden="true" />
              {carrier}
            </button>
            <span class="small number">
              {text.carrierTold(looks.length, digits(looks.reduce((sum, { look }) => sum + look.value, 0)))}
            </span>
            <svg viewBox={`0 0 ${WIDE} ${HIGH}`} preserveAspectRatio="none" aria-hidden="true">
              {looks.map(({ id, look }) => (
                <rect
                  key={`${id} ${look.start}`}
                  class={id === chosen ? "carrier-look carrier-now" : "carrier-look"}
                  style={{ fill: colours.get(carrier) }}
                  x={placeOf(look.start)}
                  width={Math.max(placeOf(look.stop) - placeOf(look.start), LEAST)}
                  height={HIGH}
                  onClick={() => onChoose(id === chosen ? null : id)}
                >
                  <title>{`${id} ${period(look.start, look.stop)}`}</title>
                </rect>
              ))}
            </svg>
          </li>
        ))}
      </ul>
      <p class="small carriers-span">{period(start, stop)}</p>
    </section>
  );
}

type Look = TargetFate["looks"][number];
