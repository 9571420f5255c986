/** The targets on the Earth, by what became of them. */
import { words } from "../../i18n";
import { EarthMap } from "../../map/EarthMap";
import { placeNames } from "../../map/labels";
import { FATES, type TargetFate } from "./campaign";

interface Props {
  fates: readonly TargetFate[];
  chosen: string | null;
  onChoose: (id: string | null) => void;
  /** Of several carriers: a target has the colour of the one that looks at it first. */
  colours: ReadonlyMap<string, string>;
}

export function FateMap({ fates, chosen, onChoose, colours }: Props) {
  const text = words.value.campaigns;
  const known = FATES.filter((fate) => fates.some((one) => one.fate === fate));
  const drawn = [...fates].sort(
    (a, b) =>
      Number(b.id === chosen) - Number(a.id === chosen) ||
      FATES.indexOf(a.fate) - FATES.indexOf(b.fate) ||
      b.priority - a.priority,
  );
  return (
    <section aria-label={text.map}>
      <EarthMap
        label={text.map}
        hint={text.mapHint}
        around={fates.flatMap((one) => (one.place ? [one.place] : []))}
        aroundLabel={text.toTargets}
        fits
      >
        {({ projection, wide }) => {
          const points = drawn.map((one) => one.place && projection(one.place));
          const placings = placeNames(
            points,
            drawn.map((one) => one.id),
            wide,
          );
          // Those that matter least first, so that the others lie over them.
          return drawn
            .map((one, k) => {
              const [point, placing] = [points[k], placings[k]];
              return (
                point && (
                  <g
                    key={one.id}
                    class={`fate fate-${one.fate} ${one.id === chosen ? "fate-now" : ""}`}
                    transform={`translate(${point[0]},${point[1]})`}
                    onPointerDown={(event) => event.stopPropagation()}
                    onClick={() => onChoose(one.id === chosen ? null : one.id)}
                  >
                    <title>{one.id}</title>
                    <circle r={fates.length > 300 ? 3 : 5} style={{ fill: colours.get(one.looks[0]?.carrier ?? "") }} />
                    {placing && <text {...placing}>{one.id}</text>}
                  </g>
                )
              );
            })
            .reverse();
        }}
      </EarthMap>
      <ul class="fate-legend">
        {known.map((fate) => (
          <li key={fate}>
            <svg width={12} height={12} viewBox="-6 -6 12 12" aria-hidden="true" class={`fate fate-${fate}`}>
              <circle r={5} />
            </svg>
            {text.fates[fate]} <span class="count">{fates.filter((one) => one.fate === fate).length}</span>
          </li>
        ))}
      </ul>
    </section>
  );
}
