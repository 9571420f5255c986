/** The request of a campaign: targets, days, platform, and the weights of a view's qualities. */
import { useMemo, useRef, useState } from "preact/hooks";

import example from "../../../../examples/campaign_cities.json";
import { Problem } from "../../api/problem";
import { words } from "../../i18n";
import { EarthMap } from "../../map/EarthMap";
import { placeNames } from "../../map/labels";
import type { LonLat } from "../../map/places";
import { DropZone } from "../../parts/DropZone";
import { Field } from "../../parts/Field";
import { useMaking } from "../../parts/making";
import { OrbitField } from "../../parts/OrbitField";
import { PlatformField, PlatformMembers } from "../../parts/PlatformField";
import { ProblemNotice } from "../../parts/ProblemNotice";
import type { AskedPlatform, Platform } from "../../parts/platforms";
import { RequestText } from "../../parts/RequestText";
import { type CampaignRequest, type CampaignTarget, faultsOf, fetchRequest, isOfBody, placesOf, withPlatform } from "./campaign";
import { idFor, TargetList } from "./TargetList";
import { NoTargets, SESSION_S, targetsOf } from "./targets";
import { Weights } from "./Weights";
import { WhenAndHow } from "./WhenAndHow";

const EXAMPLE = example as unknown as CampaignRequest;

export function AskCampaign() {
  const text = words.value.campaigns;
  const { request, setRequest, isSending, error, send } = useMaking("/v1/campaigns", "/campaigns", EXAMPLE, fetchRequest);
  const [wrong, setWrong] = useState<string | null>(null);
  const change = (members: Partial<CampaignRequest>) => setRequest({ ...request, ...members });
  const take = async (file: File) => {
    try {
      change({ targets: targetsOf(await file.text()) });
      setWrong(null);
    } catch (caught) {
      if (!(caught instanceof NoTargets)) throw caught;
      setWrong(text.noTargets(file.name, caught.line, caught.missing));
    }
  };
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
    change({ targets: [...targets, { id: idFor(target, targets), session_s: SESSION_S, target }] });
  const [hasPicked, setHasPicked] = useState(false);
  const pick = ([longitude_deg, latitude_deg]: LonLat) => {
    setHasPicked(true);
    add({ mode: "ground", latitude_deg, longitude_deg, height_m: 0 });
  };
  const places = placesOf({ ...request, targets }, null);
  const known = places.filter((one) => one !== null);
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
            <DropZone label={text.choose} accept=".csv,.txt,.json,.geojson" onFile={(file) => void take(file)}>
              <p>{text.drop}</p>
            </DropZone>
            {wrong !== null && (
              <p class="wrong" role="alert">
                {wrong}
              </p>
            )}
            <TargetList targets={targets} faults={faults} onTargets={(targets) => change({ targets })} onAdd={add} />
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
          <EarthMap
            label={text.map}
            hint={text.askMapHint}
            around={known}
            aroundLabel={text.toTargets}
            fits={!hasPicked}
            onPick={pick}
          >
            {({ projection, wide }) => {
              const points = places.map((one) => one && projection(one));
              const names = targets.map((one) => one.id);
              const placings = placeNames(points, names, wide);
              return points.map(
                (point, k) =>
                  point && (
                    <g key={k} class="fate fate-open" transform={`translate(${point[0]},${point[1]})`}>
                      <circle r={targets.length > 300 ? 2.5 : 4.5} />
                      {placings[k] && <text {...placings[k]}>{names[k]}</text>}
                    </g>
                  ),
              );
            }}
          </EarthMap>
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
