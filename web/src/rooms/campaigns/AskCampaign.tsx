/** The request of a campaign: targets, days, platform, and the weights of a view's qualities. */
import { useMemo, useRef } from "preact/hooks";

import example from "../../../../examples/campaign_cities.json";
import { Problem } from "../../api/problem";
import { words } from "../../i18n";
import { MODES } from "../../map/modes";
import { Field } from "../../parts/Field";
import { FormSurroundings } from "../../parts/fields/Fields";
import { useMaking } from "../../parts/making";
import { OrbitField } from "../../parts/OrbitField";
import { PlatformField, PlatformMembers } from "../../parts/PlatformField";
import { ProblemNotice } from "../../parts/ProblemNotice";
import type { AskedPlatform, Platform } from "../../parts/platforms";
import { RequestText } from "../../parts/RequestText";
import { BODY_ONLY } from "../planning/platforms";
import {
  type CampaignRequest,
  type CampaignTarget,
  faultsOf,
  fetchRequest,
  isOfBody,
  modeIn,
  placesOf,
  withPlatform,
} from "./campaign";
import { idFor, TargetList } from "./TargetList";
import { TargetsFile } from "./TargetsFile";
import { type Kind, TargetsMap } from "./TargetsMap";
import { SESSION_S } from "./targets";
import { Weights } from "./Weights";
import { WhenAndHow } from "./WhenAndHow";

const KINDS: readonly Kind[] = ["ground", ...MODES];
const EXAMPLE = example as unknown as CampaignRequest;

export function AskCampaign() {
  const text = words.value.campaigns;
  const { request, setRequest, isSending, error, send } = useMaking("/v1/campaigns", "/campaigns", EXAMPLE, fetchRequest);
  const change = (members: Partial<CampaignRequest>) => setRequest({ ...request, ...members });
  /** The request as it was when a body took the place of its two axes. */
  const ofAxes = useRef<CampaignRequest | null>(null);
  const takePlatform = (platform: AskedPlatform, found: Platform) => {
    if (!isOfBody(request)) ofAxes.current = request;
    setRequest(withPlatform(request, platform, found, ofAxes.current));
  };
  const targets = Array.isArray(request.targets) ? request.targets : [];
  // Of the targets as they were sent: one that is changed or removed takes its fault along.
  const faults = useMemo(() => faultsOf(error, targets), [error]);
  const isOfRows =
    faults.size > 0 &&
    error instanceof Problem &&
    (error.document.errors ?? []).every(({ field }) => field.startsWith("targets."));
  const add = (target: CampaignTarget["target"]) =>
    change({ targets: [...targets, { id: idFor(target, targets), ...(!modeIn(target) && { session_s: SESSION_S }), target }] });
  const surroundings = { axes: [], known: {}, others: isOfBody(request) ? [] : BODY_ONLY, refused: null };
  const places = placesOf({ ...request, targets }, null);
  return (
    <div class="room">
      <h1>{words.value.shell.rooms.campaigns}</h1>
      <p>{text.what}</p>
      <div class="ask-beside">
        <div>
          <section class="panel" aria-labelledby="campaign-targets">
            <h2 id="campaign-targets">
              {text.targets} <span class="count">{targets.length}</span>
            </h2>
            <TargetsFile text={text} accept=".csv,.txt,.json,.geojson" onTargets={(targets) => change({ targets })} />
            <FormSurroundings.Provider value={surroundings}>
              <TargetList targets={targets} faults={faults} onTargets={(targets) => change({ targets })} onAdd={add} />
            </FormSurroundings.Provider>
          </section>
          <section class="panel" aria-labelledby="campaign-when">
            <div class="pair">
              <Field label={text.name}>
                {(control) => (
                  <input
                    {...control}
                    value={request.name ?? ""}
                    onInput={(event) => change({ name: event.currentTarget.value })}
                  />
                )}
              </Field>
              <PlatformField asked={request.platform} onPlatform={takePlatform} />
            </div>
            <PlatformMembers asked={request.platform} onMembers={(platform) => change({ platform })} />
            <h2 id="campaign-when">{text.when}</h2>
            <WhenAndHow request={request} onChange={change} />
            <OrbitField orbit={request.orbit} onOrbit={(orbit) => change({ orbit })} />
          </section>
          <Weights view={request.view ?? {}} onView={(view) => change({ view })} />
        </div>
        <div>
          <TargetsMap targets={targets} places={places} kinds={KINDS} around={places.filter((one) => one !== null)} onAdd={add} />
          <div class="panel">
            <RequestText
              request={request}
              hint={text.jsonHint}
              rows={14}
              onRequest={(changed) => setRequest(changed as CampaignRequest)}
            />
          </div>
        </div>
      </div>
      {error !== null && !isOfRows && <ProblemNotice error={error} />}
      {faults.size > 0 && (
        <p class="notice notice-error" role="alert">
          {text.faults(faults.size)}
        </p>
      )}
      <button type="button" class="primary" disabled={isSending || targets.length === 0} onClick={() => void send()}>
        {text.send}
      </button>
    </div>
  );
}
