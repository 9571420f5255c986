/** A campaign's request and answer: where its targets are, and what becomes of each. */
import { get, type Schemas } from "../../api/client";
import { Problem } from "../../api/problem";
import { isMode, type Mode, pointsOf } from "../../map/modes";
import { type LonLat, middleOf } from "../../map/places";
import { type AskedPlatform, findPlatform, type Platform, slewOfBody, usualOf } from "../../parts/platforms";

export type CampaignRequest = Omit<Schemas["CampaignRequest"], "platform"> & { platform: AskedPlatform };
export type CampaignTarget = Schemas["CampaignTarget"];
export type Campaign = Schemas["CampaignResponse"];
export type Choice = Schemas["CampaignChoiceOut"];
type FleetChoice = Schemas["FleetChoiceOut"];

export type FieldError = Schemas["FieldError"];

export const PATH = "/v1/campaigns/{id}";

export function fetchCampaign(id: string, signal: AbortSignal): Promise<Campaign> {
  return get(PATH, { id, signal });
}

const OWN = [
  "platform",
  "orbit",
  "attitude",
  "rest_angles_deg",
  "initial_q_body_from_eci_xyzw",
  "slew",
  "pixel_arcsec",
  "resources",
] as const;
/** What each of several carriers has, and a campaign of one in their place. */
export type CarrierMembers = Pick<CampaignRequest, (typeof OWN)[number]>;
export type Carrier = CarrierMembers & { id: string };
/** Of several, `carriers` have those members. */
export type AskedCampaign = Omit<CampaignRequest, keyof CarrierMembers> & Partial<CarrierMembers> & { carriers?: Carrier[] };

/** With another platform; ofAxes: as it was when a body took the place of its two axes. */
export function withPlatform<R extends CarrierMembers>(own: R, platform: AskedPlatform, found: Platform, ofAxes: R | null): R {
  if (found.kind === "body") {
    const { attitude: _, rest_angles_deg: __, slew, ...rest } = own;
    return { ...rest, platform, ...slewOfBody(slew) } as R;
  }
  if (!isOfBody(own)) return { ...own, platform };
  const { attitude, rest_angles_deg, slew } = ofAxes ?? { attitude: usualOf(found) };
  const { initial_q_body_from_eci_xyzw: _, ...rest } = own;
  return {
    ...rest,
    platform,
    ...(attitude && { attitude }),
    ...(rest_angles_deg && { rest_angles_deg }),
    ...((slew || own.slew) && { slew: { ...slew, ...own.slew } }),
  } as R;
}

/** Whether a spacecraft is asked for that turns as a whole. */
export function isOfBody({ platform }: Pick<CarrierMembers, "platform">): boolean {
  return findPlatform(platform)?.kind === "body";
}

/** With one carrier more, like the last. */
export function withAnother(request: AskedCampaign): AskedCampaign {
  const { carriers = [{ id: "1", ...ownOf(request) }], ...all } = request;
  const taken = new Set(carriers.map((one) => one.id));
  let number = carriers.length + 1;
  while (taken.has(String(number))) number += 1;
  const own = new Set<string>(request.carriers ? [] : OWN);
  const common = Object.fromEntries(Object.entries(all).filter(([name]) => !own.has(name))) as AskedCampaign;
  return { ...common, carriers: [...carriers, { ...(carriers.at(-1) as Carrier), id: String(number) }] };
}

/** Without one of them; one that is left has its members in the campaign itself. */
export function withOneLess({ carriers = [], ...common }: AskedCampaign, place: number): AskedCampaign {
  const left = carriers.filter((_, n) => n !== place);
  const [only] = left;
  return left.length === 1 && only ? { ...common, ...ownOf(only) } : { ...common, carriers: left };
}

function ownOf(carrier: Partial<CarrierMembers>): CarrierMembers {
  return Object.fromEntries(OWN.flatMap((name) => (name in carrier ? [[name, carrier[name]]] : []))) as unknown as CarrierMembers;
}

/** chosen: in a plan, or to be; refused: chosen, but not planned; open: not decided yet. */
export const FATES = ["chosen", "left_out", "unseen", "refused", "open"] as const;
export type Fate = (typeof FATES)[number];

export interface TargetFate {
  id: string;
  fate: Fate;
  /** On the map; null in space, and for places that aren't found yet. */
  place: LonLat | null;
  priority: number;
  /** scan: which of how many, of an imaging mode. */
  looks: {
    scan: string;
    /** Of several; null where there is but one. */
    carrier: string | null;
    start: string;
    stop: string;
    plan: string;
    elevation_deg: number | null;
    quality: number | null;
    value: number;
  }[];
  because: string | null;
  /** What of the platform would run out, of a target left out for it. */
  lacks: "battery" | "memory" | "momentum" | "duty_cycle" | null;
  bestElevation_deg: number | null;
}

export function fatesOf(request: AskedCampaign, campaign: Campaign): TargetFate[] {
  const { choice } = campaign;
  const unseen = new Map(choice?.unseen.map((one) => [one.target, one]));
  const leftOut = new Map(choice?.left_out.map((one) => [one.target, one]));
  const refused = new Map(campaign.passes.flatMap((one) => one.left_out.map((look) => [look.target, look.because])));
  const looks = new Map<string, TargetFate["looks"]>();
  for (const one of campaign.passes) {
    const { plan, looks: chosen, problem } = one;
    for (const look of chosen) {
      const { target, start, stop, elevation_deg, quality, value } = look;
      if (problem) refused.set(target, problem.detail);
      else {
        const of = looks.get(target) ?? [];
        of.push({
          scan: scanTold(look),
          carrier: "carrier" in one ? one.carrier : null,
          start,
          stop,
          plan,
          elevation_deg: elevation_deg ?? null,
          quality: quality ?? null,
          value,
        });
        looks.set(target, of);
      }
    }
  }
  const places = placesOf(request, choice);
  return request.targets.map(({ id, priority = 1 }, number) => {
    const given = looks.get(id) ?? [];
    const fate: Fate =
      given.length > 0
        ? "chosen"
        : refused.has(id)
          ? "refused"
          : unseen.has(id)
            ? "unseen"
            : leftOut.has(id)
              ? "left_out"
              : "open";
    return {
      id,
      fate,
      place: places[number] ?? null,
      priority,
      looks: given,
      because: refused.get(id) ?? unseen.get(id)?.because ?? leftOut.get(id)?.because ?? null,
      lacks: leftOut.get(id)?.lacks ?? null,
      bestElevation_deg: unseen.get(id)?.best_elevation_deg ?? null,
    };
  });
}

/** Those whose id holds the text, and of one carrier, if any is named, those that it looks at. */
export function fatesWith(fates: readonly TargetFate[], text: string, carrier: string | null): TargetFate[] {
  const sought = text.trim().toLowerCase();
  return fates.filter(
    ({ id, looks }) => id.toLowerCase().includes(sought) && (carrier === null || looks.some((look) => look.carrier === carrier)),
  );
}

/** A colour for each carrier of several, as unlike its neighbours' as can be; no colours of one. */
export function coloursOf(choice: Choice | FleetChoice | null): Map<string, string> {
  const ids = choice && "carriers" in choice ? choice.carriers.map((one) => one.id) : [];
  return new Map(ids.map((id, number) => [id, `hsl(${Math.round(number * 137.5) % 360} 70% 45%)`]));
}

/** The id of the target that a field belongs to. */
export function nameIn(request: AskedCampaign | null, field: string): string {
  return request?.targets[numberOf(field)]?.id ?? field;
}

function numberOf(field: string): number {
  return Number(/^targets\.(\d+)/.exec(field)?.[1] ?? NaN);
}

/** Where the targets are, in the request's order. */
export function placesOf(request: Pick<CampaignRequest, "targets">, choice: Choice | null): (LonLat | null)[] {
  const places = request.targets.map(({ target }): LonLat | null => {
    if ("geometry" in target)
      return middleOf(pointsOf((target.geometry as { coordinates?: unknown } | null)?.coordinates))?.at ?? null;
    return target.mode === "ground" || target.mode === "station" ? [target.longitude_deg, target.latitude_deg] : null;
  });
  for (const { field, members } of choice?.assumed ?? []) {
    const number = numberOf(field);
    const { latitude_deg, longitude_deg } = members as Record<string, unknown>;
    if (number in places && typeof latitude_deg === "number" && typeof longitude_deg === "number") {
      places[number] = [longitude_deg, latitude_deg];
    }
  }
  return places;
}

/** The imaging mode that a target is; null for others. */
export function modeIn(target: CampaignTarget["target"] | undefined): Mode | null {
  return target && isMode(target.mode) ? target.mode : null;
}

/** "2/3" for a scan of several, as its session's name in the plan ends; else nothing. */
export function scanTold({ part, parts }: Campaign["passes"][number]["looks"][number]): string {
  return parts !== null && parts > 1 ? `${part}/${parts}` : "";
}

/** What was wrong with each target of a refused request. */
export function faultsOf(error: unknown, targets: readonly CampaignTarget[]): Map<CampaignTarget, FieldError[]> {
  const faults = new Map<CampaignTarget, FieldError[]>();
  if (!(error instanceof Problem)) return faults;
  const { errors = [], field, detail } = error.document;
  for (const fault of errors.length > 0 || !field ? errors : [{ field, detail, value: null }]) {
    const target = targets[numberOf(fault.field)];
    if (target) faults.set(target, [...(faults.get(target) ?? []), fault]);
  }
  return faults;
}
