/** The measured nadir's 1 and 3 sigma ellipses, and where the prediction lies. */
import { words } from "../../i18n";
import { digits } from "../../i18n/forms";
import type { Estimate } from "./estimate";

interface Props {
  /** On the axes across nadir. */
  covariance_deg2: readonly (readonly number[])[];
  check: Estimate["check"];
}

const HALF = 100; // of the picture
const SIGMAS = [1, 3];

export function Ellipse({ covariance_deg2, check }: Props) {
  const { major_deg, minor_deg, turn_deg } = principal(covariance_deg2);
  const predicted = check && { x_deg: -check.along_deg, y_deg: -check.across_deg };
  const reach_deg = Math.max(3 * major_deg, Math.abs(predicted?.x_deg ?? 0), Math.abs(predicted?.y_deg ?? 0));
  const scale = (0.85 * HALF) / reach_deg;
  return (
    <svg
      viewBox={`${-HALF} ${-HALF} ${2 * HALF} ${2 * HALF}`}
      class="ellipse"
      role="img"
      aria-label={words.value.horizon.ellipseOf(digits(major_deg), digits(minor_deg))}
    >
      <line x1={-HALF} x2={HALF} class="axis" />
      <line y1={-HALF} y2={HALF} class="axis" />
      {SIGMAS.map((sigmas) => (
        <ellipse
          key={sigmas}
          rx={sigmas * major_deg * scale}
          ry={sigmas * minor_deg * scale}
          transform={`rotate(${-turn_deg})`}
          class="region"
        />
      ))}
      <circle r="2.5" class="measured" />
      {predicted && <circle cx={predicted.x_deg * scale} cy={-predicted.y_deg * scale} r="3" class="predicted" />}
      <text x={-HALF + 4} y={HALF - 4}>
        ±{digits(HALF / scale, 2)}°
      </text>
    </svg>
  );
}

/** Half axes of the 1-sigma ellipse, and how far the longer is turned from the first axis. */
function principal([[xx = 0, xy = 0] = [], [, yy = 0] = []]: Props["covariance_deg2"]) {
  const mean = (xx + yy) / 2;
  const spread = Math.hypot((xx - yy) / 2, xy);
  return {
    major_deg: Math.sqrt(mean + spread),
    minor_deg: Math.sqrt(Math.max(mean - spread, 0)),
    turn_deg: (Math.atan2(2 * xy, xx - yy) * 90) / Math.PI,
  };
}
