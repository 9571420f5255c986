"""Las Vegas, 27 February 2015: Sumarokov 2016, Figs. 3 and 4."""

import math
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from planner.frames.time_scales import elapsed_s, utc_text
from planner.opportunities import find_opportunities
from planner.opportunities.request import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
)
from planner.opportunities.windows import Windows
from reproduction.example_plans import LAS_VEGAS, closest, plan_of, view_of
from reproduction.statements import Picture, Statement, holds

PAPER = "Sumarokov 2016"
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


def statements() -> list[Statement]:
    return [*_dates(), *_pass(), *_frame()]


def _dates() -> list[Statement]:
    passes = daylight_passes()
    early_days = (TRIALS_UTC - CAPTION_UTC).days
    return [
        Statement(
            paper=PAPER,
            place="Fig. 3, p. 93",
            name="date",
            says="a session over Las Vegas on 27 February 2015",
            ours=float(len(passes)),
            unit="daylight passes that day",
            verdict=holds(len(passes) > 0),
            why="higher than 30 deg, the Sun 10 deg or more above the horizon, by the elements "
            "published for that day",
        ),
        Statement(
            paper=PAPER,
            place="Fig. 4",
            name="caption's date",
            says="the caption has Las Vegas in February 2014, the text a session of February 2015 "
            "and trials since the end of November 2014",
            stated=0.0,
            ours=float(early_days),
            unit="days before the trials began",
            verdict="differs",
            why="the caption's year is a misprint for 2015: the camera was mounted in January "
            "2014, but nothing was pointed by this method before the trials",
        ),
    ]


def _pass() -> list[Statement]:
    plan, view = plan_of(LAS_VEGAS), view_of(LAS_VEGAS)
    track = view.targets[0]
    row, at_s = closest(track, view.t_s)
    at_utc = plan.table.epoch_utc + timedelta(seconds=at_s)
    rows = track.in_session.nonzero()[0]
    first_deg, last_deg = np.rad2deg(track.elevation_rad[rows[[0, -1]]]).tolist()
    sun_deg = math.degrees(float(track.sun_elevation_rad[row]))
    slow_s = {
        axis: sum(
            stretch.stop_s - stretch.start_s
            for session in plan.verification.sessions
            for stretch in session.slow_stretches
            if stretch.axis == axis
        )
        for axis in ("alpha", "beta")
    }
    return [
        Statement(
            paper=PAPER,
            place="Fig. 3",
            name="closest approach",
            says="the session over Las Vegas; no time of day is told",
            ours=elapsed_s(at_utc, DAY_UTC),
            unit="s of the day, UTC",
            tolerance=1.0,
            verdict="agrees",
            why=f"{utc_text(at_utc, 1)}: the {_rank()} daylight pass of that day, the ISS "
            f"{float(track.range_m[row]) / 1e3:.0f} km away and the Sun {sun_deg:.0f} deg high",
        ),
        Statement(
            paper=PAPER,
            place="Fig. 3",
            name="greatest elevation",
            says="the same; no elevation is told",
            ours=float(np.rad2deg(track.elevation_rad[rows].max())),
            unit="deg",
            tolerance=0.1,
            verdict="agrees",
            why=f"{first_deg:.0f} deg where our session begins, {last_deg:.0f} where it ends: the "
            "city is passed nearly overhead, so that beta hardly has to move",
        ),
        Statement(
            paper=PAPER,
            place="Fig. 3 b",
            name="slow beta",
            says="beta moves slowly, where friction and cables count",
            ours=slow_s["beta"],
            unit="s below 1 arcmin/s",
            tolerance=0.2,
            verdict=holds(slow_s["beta"] > slow_s["alpha"]),
            why="by our command table of 90 s, told as `slow_stretches`; alpha "
            f"{slow_s['alpha']:.1f} s",
        ),
    ]


def _rank() -> str:
    passes = daylight_passes()
    of_session = math.radians(80.0)  # none but this is so high
    higher = int(np.sum(passes.highest_rad > of_session))
    return "highest" if higher == 1 else "only" if len(passes) == 1 else "one"


def _frame() -> list[Statement]:
    track = view_of(LAS_VEGAS).targets[0]
    best_m = float(np.min(track.ground_sample_across_m[track.in_session]))
    return [
        Statement(
            paper=PAPER,
            place="Fig. 4, p. 94",
            name="cars",
            says="cars are told apart, of single ones cab and body: a lorry is so long",
            ours=LORRY_M / best_m,
            unit="pixels",
            tolerance=0.1,
            verdict="agrees",
            why=f"{LORRY_M:.0f} m at the pass's best ground sample, {best_m:.2f} m; its cab of "
            f"{CAB_M} m takes {CAB_M / best_m:.1f} pixels, a car of 4.5 m {4.5 / best_m:.1f}",
        )
    ]


def pictures(folder: Path) -> list[Picture]:
    return []
