/** Targets on the Earth; the next is clicked there, or set by Enter at the cross: a place, or a mode by its positions. */
import { useState } from "preact/hooks";

import "../../charts/charts.css";
import { words } from "../../i18n";
import { EarthMap } from "../../map/EarthMap";
import { placeNames } from "../../map/labels";
import { geometryOf, type Mode, POSITIONS } from "../../map/modes";
import type { LonLat } from "../../map/places";
import { Dots, Drafted, MANY, Shape } from "../../map/Shapes";
import { valueLabel } from "../../parts/fields/labels";
import { type CampaignTarget, modeIn } from "./campaign";

export type Kind = Mode | "ground";

interface Props {
  targets: readonly CampaignTarget[];
  /** Where each is; null where that isn't known. */
  places: readonly (LonLat | null)[];
  /** Those that can be drawn, the first to begin with. */
  kinds: readonly Kind[];
  around: readonly LonLat[];
  onAdd: (target: CampaignTarget["target"]) => void;
}

export function TargetsMap({ targets, places, kinds, around, onAdd }: Props) {
  const text = words.value.plan.drawing;
  const [kind, setKind] = useState<Kind>(kinds[0] ?? "ground");
  const [positions, setPositions] = useState<LonLat[]>([]);
  const [hasPicked, setHasPicked] = useState(false);
  const { least, most } = kind === "ground" ? { least: 1, most: 1 } : POSITIONS[kind];
  const finish = ([...all]: LonLat[]) => {
    setPositions([]);
    const [longitude_deg, latitude_deg] = all[0] ?? [0, 0];
    if (kind === "ground") onAdd({ mode: kind, latitude_deg, longitude_deg, height_m: 0 });
    else onAdd({ mode: kind, geometry: geometryOf(kind, all) } as CampaignTarget["target"]);
  };
  const set = (position: LonLat) => {
    setHasPicked(true);
    const all = [...positions, position];
    if (all.length === most) finish(all);
    else setPositions(all);
  };
  const names = targets.map((one) => one.id);
  const isMany = targets.length > MANY;
  return (
    <section aria-label={words.value.campaigns.map}>
      <div class="row draw-tools">
        <fieldset class="modes">
          <legend class="hidden">{text.next}</legend>
          {kinds.map((one) => (
            <label key={one}>
              <input
                type="radio"
                name="mode"
                checked={one === kind}
                onChange={() => {
                  setKind(one);
                  setPositions([]);
                }}
              />
              <span class={`key-mode key-${one}`}>{valueLabel(one)}</span>
            </label>
          ))}
        </fieldset>
        <span class="small" role="status">
          {positions.length === 0 ? text.howTo[kind] : text.set(positions.length)}
        </span>
        {positions.length > 0 && (
          <button type="button" onClick={() => setPositions(positions.slice(0, -1))}>
            {text.undo}
          </button>
        )}
        {positions.length > 0 && positions.length >= least && (
          <button type="button" class="primary" onClick={() => finish(positions)}>
            {text.finish}
          </button>
        )}
      </div>
      <EarthMap
        label={text.label}
        hint={text.hint}
        around={around}
        aroundLabel={words.value.campaigns.toTargets}
        fits={!hasPicked}
        onPick={set}
      >
        {(drawing) => {
          const points = places.map((one) => one && drawing.projection(one));
          const placings = placeNames(points, names, drawing.wide);
          return (
            <>
              {targets.map(({ target }, k) => {
                const mode = modeIn(target);
                return mode && "geometry" in target && <Shape key={k} mode={mode} geometry={target.geometry} drawing={drawing} />;
              })}
              {isMany && <Dots kind="fate fate-open" points={points.filter((_, k) => !modeIn(targets[k]?.target))} />}
              {points.map(
                (point, k) =>
                  point &&
                  (!isMany || placings[k]) && (
                    <g key={k} class="fate fate-open" transform={`translate(${point[0]},${point[1]})`}>
                      {!isMany && !modeIn(targets[k]?.target) && <circle r={4.5} />}
                      {placings[k] && <text {...placings[k]}>{names[k]}</text>}
                    </g>
                  ),
              )}
              {positions.length > 0 && kind !== "ground" && <Drafted mode={kind} positions={positions} drawing={drawing} />}
            </>
          );
        }}
      </EarthMap>
    </section>
  );
}
