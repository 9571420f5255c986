/** The view of a plan: globe, charts and cameras by one time cursor. */
import type { ComponentChildren } from "preact";
import { useMemo, useRef, useState } from "preact/hooks";

import { useRequest } from "../../api/request";
import { words } from "../../i18n";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { cursor_s } from "../../time/cursor";
import { type Stretch, TimeBar } from "../../time/TimeBar";
import type { Plan } from "../plan/plan";
import { AxisSpace } from "./AxisSpace";
import { Charts, type Common } from "./Charts";
import { Sphere } from "./Gyros";
import { HorizonViews } from "./HorizonViews";
import { ImageFrame } from "./ImageFrame";
import "./viewer.css";
import { PrintSheet } from "./PrintSheet";
import { Readout } from "./Readout";
import { Scene } from "./Scene";
import { fetchView, hasAngles, lastOf, stretchesOf, type View } from "./view";

interface Props {
  plan: Plan;
  /** Charts of its own, over the same time. */
  more?: (common: Common) => ComponentChildren;
}

export default function Viewer({ plan, more }: Props) {
  const text = words.value;
  const {
    answer: view,
    error,
    ask,
  } = useRequest(plan.id, (until) => {
    cursor_s.value = 0;
    return fetchView(plan, until);
  });
  if (error !== null) return <ProblemNotice error={error} again={() => void ask()} />;
  if (!view) return <p class="loading">{text.shell.loading}</p>;
  return <Opened view={view} plan={plan} more={more} />;
}

function Opened({ view, plan, more }: Props & { view: View }) {
  const { kinds, title } = words.value.viewer;
  const box = useRef<HTMLDivElement>(null);
  const [chosen, setChosen] = useState<Stretch | null>(null);
  const stretches = useMemo(() => stretchesOf(view, plan, kinds), [view, kinds]);
  const stop_s = lastOf(view.t_s);
  const epoch_ms = Date.parse(view.epoch);
  return (
    <>
      <div class="look no-print" ref={box} role="group" aria-label={title}>
        <div class="look-grid">
          <div class="look-left">
            <ImageFrame view={view} plan={plan} />
            {hasAngles(view) && <AxisSpace view={view} stretches={stretches} />}
            {view.gyros && <Sphere view={view} gyros={view.gyros} />}
            <Scene view={view} />
            <Readout view={view} />
          </div>
          <Charts view={view} plan={plan} stretches={stretches} chosen={chosen} onWhole={() => setChosen(null)} more={more} />
        </div>
        <HorizonViews plan={plan} epoch_ms={epoch_ms} stop_s={stop_s} />
        <TimeBar epoch_ms={epoch_ms} stop_s={stop_s} stretches={stretches} within={() => box.current} onStretch={setChosen} />
      </div>
      <PrintSheet view={view} stretches={stretches} />
    </>
  );
}
