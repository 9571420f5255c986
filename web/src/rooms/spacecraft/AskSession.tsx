/** The request of an imaging session: drawn, dropped as GeoJSON, or written as JSON. */
import eightAreas from "../../../../examples/spacecraft_eight_areas.json";
import fourModes from "../../../../examples/spacecraft_four_modes.json";
import stripAndStereo from "../../../../examples/spacecraft_strip_and_stereo.json";
import { words } from "../../i18n";
import { MODES, pointsOf } from "../../map/modes";
import { Fields } from "../../parts/fields/Fields";
import type { Members } from "../../parts/fields/shape";
import { useMaking } from "../../parts/making";
import { OrbitField } from "../../parts/OrbitField";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { RequestText } from "../../parts/RequestText";
import { type CampaignTarget, placesOf } from "../campaigns/campaign";
import { idFor, TargetList } from "../campaigns/TargetList";
import { TargetsFile } from "../campaigns/TargetsFile";
import { TargetsMap } from "../campaigns/TargetsMap";
import "../campaigns/campaigns.css";
import "./spacecraft.css";
import { PassesPanel } from "./PassesPanel";
import { askedFrom, askedOf, type SessionRequest, shownAs } from "./session";

const EXAMPLES = { fourModes, eightAreas, stripAndStereo } as unknown as Record<"fourModes", SessionRequest>;
/** Members that have forms of their own, and the only spacecraft. */
const OTHERS = ["requests", "orbit", "spacecraft"];
const KINDS = MODES.filter((mode) => mode !== "tri_stereo");

export default function AskSession() {
  const text = words.value.spacecraft;
  const { request, setRequest, isSending, error, send } = useMaking("/spacecraft/plans", EXAMPLES.fourModes);
  const change = (members: Partial<SessionRequest>) => setRequest({ ...request, ...members });
  const asked = askedOf(request);
  const targets = shownAs(asked);
  const ask = (next: readonly CampaignTarget[]) => change({ requests: askedFrom(next, asked) });
  /** In place of those of the same name. */
  const take = (given: CampaignTarget[]) => {
    const others = asked.filter((one) => !given.some(({ id }) => id === one.name));
    change({ requests: [...others, ...askedFrom(given, [])] });
  };
  return (
    <div class="room">
      <h1>{words.value.shell.rooms.spacecraft}</h1>
      <p>{text.what}</p>
      <div class="ask-beside">
        <div>
          <section class="panel" aria-labelledby="session-asked">
            <div class="row heading">
              <h2 id="session-asked">
                {text.asked} <span class="count">{asked.length}</span>
              </h2>
              <button type="button" class="plain" disabled={asked.length === 0} onClick={() => ask([])}>
                {text.removeAll}
              </button>
            </div>
            {asked.length > 0 ? <TargetList targets={targets} onTargets={ask} /> : <p class="hint">{text.none}</p>}
            <TargetsFile text={text} accept=".geojson,.json" onTargets={take} />
          </section>
          <section class="panel" aria-labelledby="session-when">
            <h2 id="session-when">{text.session}</h2>
            <Fields
              schema="ImagingPlanRequest"
              value={request as unknown as Members}
              path=""
              omit={OTHERS}
              onValue={(next) => setRequest(next as unknown as SessionRequest)}
            />
            <OrbitField orbit={request.orbit} onOrbit={(orbit) => change({ orbit })} />
          </section>
          <PassesPanel request={request} onTimes={change} />
        </div>
        <div>
          <TargetsMap
            targets={targets}
            places={placesOf({ targets }, null)}
            kinds={KINDS}
            around={targets.flatMap(({ target }) => ("geometry" in target ? pointsOf(target.geometry.coordinates) : []))}
            onAdd={(target) => ask([...targets, { id: idFor(target, targets), target }])}
          />
          <div class="panel">
            <div class="row examples">
              <span class="small">{text.examples}</span>
              {Object.entries(EXAMPLES).map(([name, example]) => (
                <button key={name} type="button" class="plain" onClick={() => setRequest(example)}>
                  {text.example[name as "fourModes"]}
                </button>
              ))}
            </div>
            <RequestText
              request={request}
              hint={text.jsonHint}
              rows={12}
              onRequest={(changed) => setRequest(changed as SessionRequest)}
            />
          </div>
        </div>
      </div>
      {error !== null && <ProblemNotice error={error} />}
      <button type="button" class="primary" disabled={isSending || asked.length === 0} onClick={() => void send()}>
        {text.send}
      </button>
    </div>
  );
}
