/** The request of a campaign: targets, days, platform, and the weights of a view's qualities. */
import { useMemo } from "preact/hooks";

import example from "../../../../examples/campaign_cities.json";
import { Problem } from "../../api/problem";
import { words } from "../../i18n";
import { MODES } from "../../map/modes";
import { Field } from "../../parts/Field";
import { FormSurroundings } from "../../parts/fields/Fields";
import { useMaking } from "../../parts/making";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { RequestText } from "../../parts/RequestText";
import { useStateOf } from "../../parts/stateOf";
import { UtcField } from "../../parts/UtcField";
import { place } from "../../router";
import { BODY_ONLY } from "../planning/platforms";
import { CarrierFields } from "./CarrierFields";
import { type AskedCampaign, type CampaignTarget, type CarrierMembers, faultsOf, isOfBody, modeIn, placesOf } from "./campaign";
import { idFor, TargetList } from "./TargetList";
import { TargetsFile } from "./TargetsFile";
import { type Kind, TargetsMap } from "./TargetsMap";
import { SESSION_S } from "./targets";
import { Weights } from "./Weights";
import { WhenAndHow } from "./WhenAndHow";

const KINDS: readonly Kind[] = ["ground", ...MODES];
const EXAMPLE = example as unknown as AskedCampaign;
/** A revision may be revised: its request without what it revised itself. */
const AS_NEW = { revises: undefined };

export function AskCampaign() {
  const text = words.value.campaigns;
  const { request, setRequest, isSending, error, send } = useMaking("/campaigns", EXAMPLE);
  /** Of the campaign that this one revises, and until when that one stays. */
  const revises = place.value.query.get("revises");
  const [frozen, setFrozen] = useStateOf(request.start, () => request.start);
  const change = (members: Partial<AskedCampaign>) => setRequest({ ...request, ...members });
  const targets = Array.isArray(request.targets) ? request.targets : [];
  // Of the targets as they were sent: one that is changed or removed takes its fault along.
  const faults = useMemo(() => faultsOf(error, targets), [error]);
  const isOfRows =
    faults.size > 0 &&
    error instanceof Problem &&
    (error.document.errors ?? []).every(({ field }) => field.startsWith("targets."));
  const add = (target: CampaignTarget["target"]) =>
    change({ targets: [...targets, { id: idFor(target, targets), ...(!modeIn(target) && { session_s: SESSION_S }), target }] });
  const hasBody = (request.carriers ?? [request as CarrierMembers]).some(isOfBody);
  const surroundings = { axes: [], known: {}, others: hasBody ? [] : BODY_ONLY, refused: null };
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
            <CarrierFields request={request} onRequest={setRequest}>
              <Field label={text.name}>
                {(control) => (
                  <input
                    {...control}
                    value={request.name ?? ""}
                    onInput={(event) => change({ name: event.currentTarget.value })}
                  />
                )}
              </Field>
            </CarrierFields>
            <h2 id="campaign-when">{text.when}</h2>
            <WhenAndHow request={request} onChange={change} />
            {revises !== null && <UtcField label={text.frozenUntil} hint={text.frozenHint} value={frozen} onValue={setFrozen} />}
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
              onRequest={(changed) => setRequest(changed as AskedCampaign)}
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
      <button
        type="button"
        class="primary"
        disabled={isSending || targets.length === 0}
        onClick={() => void (revises === null ? send() : send({ revises, frozen_until: frozen }, AS_NEW))}
      >
        {revises === null ? text.send : text.sendRevised}
      </button>
    </div>
  );
}
