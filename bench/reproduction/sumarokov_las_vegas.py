"""Las Vegas, 27 February 2015: Sumarokov 2016, Figs. 3 and 4."""

import math
from datetime import UTC, datetime, timedelta

import numpy as np

from planner.planning.opportunities import find_opportunities
from planner.planning.opportunities.request import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
)
from planner.planning.opportunities.windows import Windows
from planner.world.frames.time_scales import elapsed_s, utc_text
from reproduction.example_plans import LAS_VEGAS, closest, plan_of, view_of
from reproduction.statements import Numbers

DAY_UTC = datetime(2015, 2, 27, tzinfo=UTC)
TRIALS_UTC = datetime(2014, 11, 24, tzinfo=UTC)  # "since the end of November 2014"
CAPTION_UTC = datetime(2014, 2, 28, tzinfo=UTC)  # the last day that Fig. 4's caption allows
DAYLIGHT = OpportunityConditions(min_elevation_deg=30.0, sun_elevation_min_deg=10.0)
LORRY_M, CAB_M = 16.0, 2.5


def daylight_passes() -> Windows:
    """Over Las Vegas, on the local day of the paper's session."""
    scenario = plan_of(LAS_VEGAS).scenario
    local_midnight_utc = DAY_UTC + timedelta(hours=8)  # Pacific standard time
    request = OpportunityRequest(
        platform=scenario.platform,
        orbit=scenario.orbit,
        attitude=scenario.attitude,
        targets=(OpportunityTarget(id="Las Vegas", target=scenario.sessions[0].target),),
        start=local_midnight_utc,
        stop=local_midnight_utc + timedelta(days=1),
        conditions=DAYLIGHT,
        samples=3,
    )
    return find_opportunities(request).windows


def numbers() -> Numbers:
    plan, view = plan_of(LAS_VEGAS), view_of(LAS_VEGAS)
    track = view.targets[0]
    row, at_s = closest(track, view.t_s)
    at_utc = plan.table.epoch_utc + timedelta(seconds=at_s)
    rows = track.in_session.nonzero()[0]
    first_deg, last_deg = np.rad2deg(track.elevation_rad[rows[[0, -1]]]).tolist()
    alpha_s, beta_s = (
        sum(
            stretch.stop_s - stretch.start_s
            for session in plan.verification.sessions
            for stretch in session.slow_stretches
            if stretch.axis == axis
        )
        for axis in ("alpha", "beta")
    )
    best_m = float(np.min(track.ground_sample_across_m[track.in_session]))
    return {
        "date": float(len(daylight_passes())),
        "caption's date": float((TRIALS_UTC - CAPTION_UTC).days),
        "closest approach": elapsed_s(at_utc, DAY_UTC),
        "greatest elevation": float(np.rad2deg(track.elevation_rad[rows].max())),
        "slow beta": beta_s,
        "cars": LORRY_M / best_m,
        "at": utc_text(at_utc, 1),
        "range_km": float(track.range_m[row]) / 1e3,
        "sun_deg": math.degrees(float(track.sun_elevation_rad[row])),
        "first_deg": first_deg,
        "last_deg": last_deg,
        "slow_alpha_s": alpha_s,
        "best_m": best_m,
        "cab_px": CAB_M / best_m,
        "car_px": 4.5 / best_m,
    }
