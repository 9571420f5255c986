"""Windows against what they promise, and reasons of choices: points 5 to 7 of bench/truth.py."""

import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import numpy as np
from campaign import campaign_request, single_looks
from truth_elements import read_tles
from truth_rows import Row

from planner.base.errors import Refusal
from planner.planning.campaigns import choose_campaign
from planner.planning.opportunities import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
    find_opportunities,
)
from planner.planning.sessions.budget import LIKELY
from planner.planning.sessions.pipeline import make_plan
from planner.world.attitude import LvlhAttitude
from planner.world.frames.time_scales import shifted_utc
from planner.world.platforms import PLATFORMS
from planner.world.scenario import InitialState, Scenario, Session
from planner.world.targets import BodyTarget, GroundTarget, StarTarget

ABOVE_DEG = 25.0
TARGETS = 60
BEFORE_S = 300.0
GAP_GOAL, TIME_GOAL_S = 0.01, 60.0


def window_rows(data: Path, windows: int) -> Iterator[Row]:
    """Sessions of random windows of OCO-3 targets, two stars and Jupiter, whose windows open and
    close at stops, too; up to 3 days after the elements' epoch."""
    rng = np.random.default_rng(3)
    tles = list(read_tles(data / "tle" / "iss_tles.txt"))
    places = [one.target for one in campaign_request(TARGETS, 1.0, 2.0).targets]
    places += [StarTarget(name="Vega"), StarTarget(hip=32349), BodyTarget(name="jupiter")]
    platform = PLATFORMS["iss-hrc"]
    refused: Counter[str] = Counter()
    planned, likely, warned = 0, 0, 0
    while planned + refused.total() < windows:
        tle = tles[rng.integers(len(tles))]
        start = shifted_utc(tle.epoch_utc.replace(microsecond=0), float(rng.integers(259_200)))
        found = find_opportunities(
            OpportunityRequest(
                orbit=tle,
                attitude=LvlhAttitude(),
                platform=platform,
                start=start,
                stop=start + timedelta(days=1),
                targets=tuple(
                    OpportunityTarget(id=str(k), target=place) for k, place in enumerate(places)
                ),
                conditions=OpportunityConditions(min_elevation_deg=ABOVE_DEG),
            )
        )
        times_s = found.windows.sessions_s(found.start_utc)
        row = int(rng.integers(len(times_s)))
        first, last = (shifted_utc(found.start_utc, float(t_s)) for t_s in times_s[row])
        place = places[found.windows.target[row]]
        if isinstance(place, GroundTarget):
            place = replace(place, min_elevation_deg=ABOVE_DEG)
        asked = Scenario(
            orbit=tle,
            attitude=LvlhAttitude(),
            platform=platform,
            initial_state=InitialState(
                epoch=first - timedelta(seconds=BEFORE_S),
                angles_deg=dict.fromkeys(platform.axis_names, 0.0),
            ),
            sessions=(Session(target=place, start=first, stop=last),),
        )
        try:
            plan = make_plan(asked)
        except Refusal as refusal:
            refused[refusal.slug] += 1
            continue
        planned += plan.verification.passed
        is_likely = plan.budgets[0].probability_in_frame < LIKELY
        likely += is_likely
        warned += is_likely and any("stays in the frame" in text for text in plan.warnings)
    yield Row(2, "plans, elements to 3 days old: likely misses that warn", "all",
              f"{warned} of {likely}", warned == likely)  # fmt: skip
    yield Row(5, "windows whose own session plans", "all",
              f"{planned} of {windows} {dict(refused) or ''}", planned == windows)  # fmt: skip


def campaign_rows() -> Iterator[Row]:
    """OCO-3's 559 targets over 5 days."""
    for weight, name in ((1.0, "views weighed"), (0.0, "all views worth the same")):
        request = campaign_request(559, 5.0, 2.0)
        request = replace(
            request,
            conditions=replace(request.conditions, sun_elevation_min_deg=10.0),
            view=replace(request.view, ground_sample=weight),
        )
        began_s = time.process_time()
        campaign = choose_campaign(request)
        took_s = time.process_time() - began_s
        gap = campaign.gap_share
        yield Row(6, f"559 targets, {name}: below the bound", f"{GAP_GOAL:.0%}", f"{gap:.2%}",
                  gap <= GAP_GOAL)  # fmt: skip
        yield Row(6, f"559 targets, {name}: processor time", f"{TIME_GOAL_S:g} s",
                  f"{took_s:.0f} s", took_s <= TIME_GOAL_S)  # fmt: skip
        if not weight:
            continue
        single, early, centred = single_looks(request, campaign)
        yield Row(6, "looks alone in their pass, centred to 2.5 s", "where nothing competes",
                  f"{centred} of {single}; {early} begin with the window", None)  # fmt: skip
        why = sum(bool(one.closed_by and one.because) for one in campaign.unseen)
        named = sum(bool(one.displaced_by) for one in campaign.left_out)
        yield Row(7, "unseen that say why", "all", f"{why} of {len(campaign.unseen)}",
                  why == len(campaign.unseen))  # fmt: skip
        of = len(campaign.left_out)
        yield Row(7, "left out that name what displaced them", "all", f"{named} of {of}",
                  named == of)  # fmt: skip
