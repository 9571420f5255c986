/** The carriers of a campaign: one, whose members are the request's own, or several, each by its id. */
import type { ComponentChildren } from "preact";
import { useRef } from "preact/hooks";

import { words } from "../../i18n";
import { Field } from "../../parts/Field";
import { OrbitField } from "../../parts/OrbitField";
import { PlatformField, PlatformMembers } from "../../parts/PlatformField";
import type { AskedPlatform, Platform } from "../../parts/platforms";
import {
  type AskedCampaign,
  type Carrier,
  type CarrierMembers,
  isOfBody,
  withAnother,
  withOneLess,
  withPlatform,
} from "./campaign";

interface Props {
  request: AskedCampaign;
  onRequest: (request: AskedCampaign) => void;
  /** Stands beside the platform of the only one. */
  children: ComponentChildren;
}

export function CarrierFields({ request, onRequest, children }: Props) {
  const text = words.value.campaigns;
  const { carriers } = request;
  const put = (place: number, own: Carrier) =>
    onRequest({ ...request, carriers: carriers?.map((one, n) => (n === place ? own : one)) });
  return (
    <>
      {carriers ? children : <OneCarrier own={request as AskedCampaign & CarrierMembers} onOwn={onRequest} beside={children} />}
      {carriers?.map((one, place) => (
        <fieldset key={place} data-testid="carrier">
          <legend>{one.id}</legend>
          <OneCarrier
            own={one}
            of={` ${place}`}
            onOwn={(own) => put(place, own)}
            beside={
              <Field label={text.carrier}>
                {(control) => (
                  <input
                    {...control}
                    value={one.id}
                    onInput={({ currentTarget }) => put(place, { ...one, id: currentTarget.value })}
                  />
                )}
              </Field>
            }
          />
          <button type="button" onClick={() => onRequest(withOneLess(request, place))}>
            {text.removeOne(one.id)}
          </button>
        </fieldset>
      ))}
      <button type="button" onClick={() => onRequest(withAnother(request))}>
        {text.addCarrier}
      </button>
    </>
  );
}

interface One<R> {
  own: R;
  /** Tells the orbit that is typed from others'. */
  of?: string;
  onOwn: (own: R) => void;
  beside: ComponentChildren;
}

function OneCarrier<R extends CarrierMembers>({ own, of, onOwn, beside }: One<R>) {
  /** As it was when a body took the place of its two axes. */
  const ofAxes = useRef<R | null>(null);
  const takePlatform = (platform: AskedPlatform, found: Platform) => {
    if (!isOfBody(own)) ofAxes.current = own;
    onOwn(withPlatform(own, platform, found, ofAxes.current));
  };
  return (
    <>
      <div class="pair">
        {beside}
        <PlatformField asked={own.platform} onPlatform={takePlatform} />
      </div>
      <PlatformMembers asked={own.platform} onMembers={(platform) => onOwn({ ...own, platform })} />
      <OrbitField orbit={own.orbit} of={of} onOrbit={(orbit) => onOwn({ ...own, orbit })} />
    </>
  );
}
