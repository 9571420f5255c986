/** The request of a campaign: targets, days, and the weights of a view's qualities. */
import { useState } from "preact/hooks";

import example from "../../../../examples/campaign_cities.json";
import { words } from "../../i18n";
import { EarthMap } from "../../map/EarthMap";
import { readable } from "../../map/labels";
import { DropZone } from "../../parts/DropZone";
import { useMaking } from "../../parts/making";
import { OrbitField } from "../../parts/OrbitField";
import { ProblemNotice } from "../../parts/ProblemNotice";
import { RequestText } from "../../parts/RequestText";
import { UtcField } from "../../parts/UtcField";
import { type CampaignRequest, fetchRequest, placesOf } from "./campaign";
import { NoTargets, targetsOf } from "./targets";
import { Weights } from "./Weights";

const EXAMPLE = example as unknown as CampaignRequest;
const SHOWN = 200;

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
  const targets = Array.isArray(request.targets) ? request.targets : [];
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
            <div class="scroll-both targets" tabIndex={0} role="group" aria-label={text.targets}>
              <table>
                <thead>
                  <tr>
                    <th scope="col">{text.columns.target}</th>
                    <th scope="col" class="number">
                      {text.columns.priority}
                    </th>
                    <th scope="col" class="number">
                      {text.columns.session}
                    </th>
                  </tr>
                </thead>
                <tbody>
                  {targets.slice(0, SHOWN).map((one, index) => (
                    <tr key={index}>
                      <td>{one.id}</td>
                      <td class="number">{one.priority ?? 1}</td>
                      <td class="number">
                        {one.min_session_s == null || one.min_session_s === one.session_s
                          ? one.session_s
                          : `${one.min_session_s}–${one.session_s}`}
                      </td>
                    </tr>
                  ))}
                </tbody>
              </table>
              {targets.length > SHOWN && <p class="small">{text.more(targets.length - SHOWN)}</p>}
            </div>
          </section>
          <section class="panel" aria-labelledby="campaign-when">
            <h2 id="campaign-when">{text.when}</h2>
            <div class="pair">
              <UtcField label={text.start} value={request.start} onValue={(start) => change({ start })} />
              <UtcField label={text.stop} value={request.stop} onValue={(stop) => change({ stop })} />
            </div>
            <OrbitField orbit={request.orbit} onOrbit={(orbit) => change({ orbit })} />
          </section>
          <Weights view={request.view ?? {}} onView={(view) => change({ view })} />
        </div>
        <div>
          <EarthMap label={text.map} hint={text.mapHint} around={known} aroundLabel={text.toTargets} fits>
            {({ projection }) => {
              const points = places.map((one) => one && projection(one));
              const named = readable(
                points.map((point, k) => point && { x: point[0] + 7, y: point[1], text: targets[k]?.id ?? "" }),
              );
              return points.map(
                (point, k) =>
                  point && (
                    <g key={k} class="fate fate-open" transform={`translate(${point[0]},${point[1]})`}>
                      <circle r={targets.length > 300 ? 2.5 : 4.5} />
                      {named[k] && (
                        <text x={7} y={4}>
                          {targets[k]?.id}
                        </text>
                      )}
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
      {error !== null && <ProblemNotice error={error} />}
      <button type="button" class="primary" disabled={isSending || targets.length === 0} onClick={() => void send()}>
        {text.send}
      </button>
    </div>
  );
}
