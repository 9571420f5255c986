/** The rate error while the camera images: the worst of all closed-loop runs over each look. */
import { useMemo } from "preact/hooks";

import { Strip } from "../../charts/Strip";
import { type Line, TimeChart } from "../../charts/TimeChart";
import { words } from "../../i18n";
import { digits } from "../../i18n/forms";
import type { Common } from "../viewer/Charts";
import type { Session } from "./session";

const HEIGHT = 112;
const BODY = ["X", "Y", "Z"];
/** What the camera's image takes. */
const LIMIT_DEG_S = 0.001;
const LIMITS = [0, LIMIT_DEG_S];
/** A row's half, so that a look's own rows are inside it. */
const EDGE_S = 0.1;

export function RateErrors({ session, common }: { session: Session; common: Common }) {
  const text = words.value.spacecraft.errors;
  const { stabilisation, windows } = session;
  const { epoch_ms, t_s } = common;
  const lines = useMemo<Line[]>(() => {
    const spans = windows.map((one) => [one.start, one.stop].map((utc) => (Date.parse(utc) - epoch_ms) / 1000));
    const looks = t_s.map((t) => spans.findIndex(([from = 0, to = 0]) => t >= from - EDGE_S && t <= to + EDGE_S));
    return BODY.map((label, axis) => ({
      label,
      values: looks.map((look) => stabilisation.windows[look]?.rate_error_deg_s[axis] ?? null),
      colour: `series-${axis + 1}`,
      width: 2,
    }));
  }, [stabilisation, windows, epoch_ms, t_s]);
  if (stabilisation.runs === 0) return null;
  return (
    <Strip
      name={text.title}
      unit="°/s"
      keys={BODY}
      fact={text.worst(digits(stabilisation.worst_deg_s, 2), digits(LIMIT_DEG_S), stabilisation.runs)}
    >
      <TimeChart {...common} label={text.told} lines={lines} limits={LIMITS} withLimits height={HEIGHT} />
    </Strip>
  );
}
