/** The targets on the Earth, by what became of them. */
import { words } from "../../i18n";
import { EarthMap } from "../../map/EarthMap";
import { placeNames } from "../../map/labels";
import { Dots, MANY } from "../../map/Shapes";
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
  const colourOf = (one: TargetFate | undefined) => colours.get(one?.looks[0]?.carrier ?? "");
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
          const isMany = drawn.length > MANY;
          // Those that matter least first, so that the others lie over them.
          const marks = drawn
            .map((one, k) => {
              const [point, placing] = [points[k], placings[k]];
              const isNow = one.id === chosen;
              return (
                point &&
                (!isMany || isNow || placing) && (
                  <g
                    key={one.id}
                    class={`fate fate-${one.fate} ${isNow ? "fate-now" : ""}`}
                    transform={`translate(${point[0]},${point[1]})`}
                    style={{ "--dot": colourOf(one) }}
                    onPointerDown={(event) => event.stopPropagation()}
                    onClick={() => onChoose(isNow ? null : one.id)}
                  >
                    <title>{one.id}</title>
                    <circle r={isMany ? 3 : 5} />
                    {placing && <text {...placing}>{one.id}</text>}
                  </g>
                )
              );
            })
            .reverse();
          if (!isMany) return marks;
          const alike = new Map<string, number[]>();
          drawn.forEach((one, k) => {
            const look = `${one.fate} ${colourOf(one)}`;
            const numbers = alike.get(look);
            if (numbers) numbers.push(k);
            else alike.set(look, [k]);
          });
          const dots = [...alike].map(([key, numbers]) => {
            const first = drawn[numbers[0] ?? 0];
            return (
              <Dots
                key={key}
                kind={`fate fate-${first?.fate}`}
                colour={colourOf(first)}
                points={numbers.map((k) => points[k] ?? null)}
                onDot={(k) => onChoose(drawn[numbers[k] ?? 0]?.id ?? null)}
              />
            );
          });
          return [...dots.reverse(), ...marks];
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
