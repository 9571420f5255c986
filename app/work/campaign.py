"""A child's work for a campaign: windows, the choice, and a plan request for each pass."""

import json
import re
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from app.answers.campaign import CampaignChoiceOut
from app.answers.members import to_json, to_members
from app.requests.campaign import read_campaign_request
from app.requests.json_writer import json_fields
from app.requests.plan import write_plan_request
from app.store.listing import Listing
from app.work.progress import report
from app.work.result import Part, Result
from planner.base.errors import Refusal
from planner.planning.campaigns import CampaignRequest
from planner.world.frames.time_scales import utc_from_text, utc_text

if TYPE_CHECKING:
    from planner.planning.campaigns import Campaign, ChosenPass

_CARRIED_OVER = ("platform", "orbit", "attitude", "slew")  # the last where it is as asked
_SESSION = re.compile(r"sessions\.(\d+)(\.|$)")


def choose(body: bytes, request: CampaignRequest | None = None) -> Result:
    """Read unless that is done, choose and write down; raises a Refusal."""
    from planner.planning.campaigns import choose_campaign

    request = request or read_campaign_request(body)
    document = json.loads(body)  # passes say orbit, platform and targets in its own words
    campaign = choose_campaign(request, report)
    return Result(
        content=(zlib.compress(to_json(_choice(request, campaign))),),
        parts=tuple(
            _part(document, request, number, flight)
            for number, flight in enumerate(campaign.passes)
        ),
    )


def _choice(request: CampaignRequest, campaign: "Campaign") -> CampaignChoiceOut:
    return CampaignChoiceOut(
        value=campaign.value,
        bound=campaign.bound,
        gap_share=campaign.gap_share,
        greedy_value=campaign.greedy_value,
        windows=campaign.windows,
        looks=sum(len(flight.looks) for flight in campaign.passes),
        passes=len(campaign.passes),
        unseen=campaign.unseen,
        left_out=campaign.left_out,
        assumed=request.opportunities().assumed,
        warnings=campaign.warnings,
    )


def _part(
    document: Mapping[str, Any], request: CampaignRequest, number: int, flight: "ChosenPass"
) -> Part:
    from planner.planning.campaigns import scenario_of

    scenario = scenario_of(request, flight, number)
    carried = _CARRIED_OVER if scenario.slew == request.slew else _CARRIED_OVER[:-1]
    words = {name: document[name] for name in carried if name in document}
    target_words = [
        document["targets"][look.row]["target"] if look.path is None else json_fields(look.path)
        for look in flight.looks
    ]
    if any("terrain" in told for told in (document, *target_words)):
        target_words = []  # the heights are written out: no pass holds the grid
    looks = [to_members(look) for look in flight.looks]
    return Part(
        request=write_plan_request(scenario, words, target_words),
        name=scenario.name,
        listing=_listing(scenario.platform.name, looks),
        facts={
            "pass": number,
            "start": utc_text(flight.start_utc),
            "stop": utc_text(flight.stop_utc),
            "looks": looks,
            "left_out": [],
        },
    )


def _listing(platform: str, looks: Sequence[Mapping[str, Any]]) -> Listing:
    """By the targets' ids, from the first look to the last."""
    return Listing(
        platform=platform,
        start_utc=utc_from_text(looks[0]["start"]),
        stop_utc=utc_from_text(looks[-1]["stop"]),
        targets=tuple(look["target"] for look in looks),
    )


def plan_pass(part: Part) -> tuple[Part, Result | Refusal]:
    """The pass, without what can't be flown of it, and its plan, or why it has none."""
    from app.work.plan import plan_and_pack

    while True:
        try:
            return part, plan_and_pack(part.request)
        except Refusal as refusal:
            repaired = without_refused(part, refusal.field, refusal.detail)
            if repaired is None:
                return part, refusal
            part = repaired


def without_refused(part: Part, field: str | None, detail: str) -> Part | None:
    """The pass without the look that can't be flown, or else the one of least worth; of an imaging
    mode without any of its scans.

    None when no look would be left.  field: the refusal's.
    """
    looks = part.facts["looks"]
    row = int(named[1]) if (named := _SESSION.match(field or "")) else len(looks)
    if row >= len(looks):
        row = min(range(len(looks)), key=lambda number: looks[number]["value"])
    refused = looks[row]["target"]
    kept = [look for look in looks if look["target"] != refused]
    if not kept:
        return None
    request = json.loads(part.request)
    sessions = request["sessions"]
    request["sessions"] = [s for s in sessions if (s.get("of") or s.get("id")) != refused]
    left_out = {"target": refused, "because": detail}
    return replace(
        part,
        request=json.dumps(request).encode(),
        listing=_listing(part.listing.platform, kept),
        facts={**part.facts, "looks": kept, "left_out": [*part.facts["left_out"], left_out]},
    )
