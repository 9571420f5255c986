/** The requested areas on the Earth; positions of the next are clicked, or set by Enter at the cross. */
import { useState } from "preact/hooks";

import { words } from "../../i18n";
import { EarthMap } from "../../map/EarthMap";
import type { LonLat } from "../../map/places";
import { type Asked, drawn, MODES, type Mode, POSITIONS, positionsOf, shapeOf } from "./session";

export function DrawMap({ asked, onAsked }: { asked: readonly Asked[]; onAsked: (asked: Asked[]) => void }) {
  const text = words.value.spacecraft;
  const [mode, setMode] = useState<Mode>("strip");
  const [positions, setPositions] = useState<LonLat[]>([]);
  const { least, most } = POSITIONS[mode];
  const finish = (all: LonLat[]) => {
    setPositions([]);
    onAsked([...asked, drawn(mode, all, asked)]);
  };
  const set = (position: LonLat) => {
    const all = [...positions, position];
    if (all.length === most) finish(all);
    else setPositions(all);
  };
  return (
    <section aria-label={text.map}>
      <div class="row draw-tools">
        <fieldset class="modes">
          <legend class="hidden">{text.next}</legend>
          {MODES.map((one) => (
            <label key={one}>
              <input
                type="radio"
                name="mode"
                checked={one === mode}
                onChange={() => {
                  setMode(one);
                  setPositions([]);
                }}
              />
              <span class={`key-mode key-${one}`}>{text.modes[one]}</span>
            </label>
          ))}
        </fieldset>
        <span class="small" role="status">
          {positions.length === 0 ? text.howTo[mode] : text.set(positions.length)}
        </span>
        {positions.length > 0 && (
          <button type="button" onClick={() => setPositions(positions.slice(0, -1))}>
            {text.undo}
          </button>
        )}
        {positions.length >= least && (
          <button type="button" class="primary" onClick={() => finish(positions)}>
            {text.finish}
          </button>
        )}
      </div>
      <EarthMap
        label={text.drawLabel}
        hint={text.mapHint}
        around={asked.flatMap(positionsOf)}
        aroundLabel={text.toAsked}
        fits
        onPick={set}
      >
        {({ projection, path }) => (
          <>
            {asked.map((one, number) => (
              <g key={number} class={`asked-shape mode-${one.mode}`}>
                <path d={path(shapeOf(one)) ?? ""} />
                <Name name={one.name} at={projection(positionsOf(one)[0] ?? [0, 0])} />
              </g>
            ))}
            {positions.length > 0 && (
              <g class={`asked-shape draft mode-${mode}`}>
                <path d={path({ type: "LineString", coordinates: positions }) ?? ""} />
                {positions.map((one, number) => {
                  const point = projection(one);
                  return point && <circle key={number} cx={point[0]} cy={point[1]} r={4} />;
                })}
              </g>
            )}
          </>
        )}
      </EarthMap>
    </section>
  );
}

function Name({ name, at }: { name: string; at: [number, number] | null }) {
  return (
    at && (
      <text x={at[0] + 8} y={at[1] + 4}>
        {name}
      </text>
    )
  );
}
