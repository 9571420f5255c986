"""Flights that lose their target altogether still report numbers, and why."""

from dataclasses import fields, replace

import numpy as np
import pytest
from scenarios import LAS_VEGAS, STILL, scenario, session

from planner.inflight.flights.nominal import nominal_session
from planner.inflight.flights.request import MovingObject
from planner.inflight.flights.runs import fly_runs
from planner.inflight.flights.scene import session_scenes
from planner.inflight.flights.summary import summarise
from planner.planning.sessions.pipeline import make_plan
from planner.world.attitude import AttitudeUncertainty, LvlhAttitude
from planner.world.platforms import ISS_HRC, AxisDrive

# Each at an end of its range, beyond which a fifth more or less would be drawn.
DRIVES = {
    "held by friction": {"coulomb_deg_s2": 100.0, "breakaway_deg_s2": 100.0},
    "pulled away by cables": {"cable_tension_deg_s2": 100.0},
    "pulled back by cables": {"cable_tension_deg_s2": -100.0, "cable_stiffness_per_s2": 10.0},
    "in syrup": {"viscous_per_s": 100.0},
}


@pytest.fixture(scope="module")
def plan():
    return make_plan(
        replace(scenario(session(LAS_VEGAS, 140, 150)), attitude=LvlhAttitude(uncertainty=STILL))
    )


def found(plan, **changes):
    """The flight as planned, and four that are not."""
    flown = replace(plan, scenario=replace(plan.scenario, **changes))
    [scene] = session_scenes(flown)
    shown = nominal_session(scene, MovingObject(speed_m_s=20.0))
    return shown, summarise(fly_runs([scene], 1, 0, 4))


def numbers(shown, flights):
    for member in fields(shown):
        if member.name not in ("rate_error_rad_s", "gyros"):  # which two axes don't have
            yield member.name, getattr(shown, member.name)
    [one] = flights.sessions
    yield from (("smear", one.smear_px), ("miss", one.miss_m), ("misses", one.misses.edges_rad))
    for cause in flights.contributors:
        yield from ((f"{cause.cause} {name}", x) for name, x in vars(cause).items())


@pytest.mark.parametrize("name", DRIVES)
def test_drives_that_can_not_move_their_axes(plan, name):
    drive = replace(AxisDrive(), **DRIVES[name])
    shown, flights = found(plan, platform=replace(ISS_HRC, drives=(drive, drive)))
    for what, value in numbers(shown, flights):
        assert isinstance(value, str) or np.all(np.isfinite(value)), what
    assert shown.held == flights.in_frame.value == 0
    assert shown.saturated_s.max() == pytest.approx(20.0, abs=0.1)  # the session and its lead


def test_an_attitude_that_nobody_knows(plan):
    lost = AttitudeUncertainty(sigma_body_deg=(90.0, 90.0, 90.0))
    shown, flights = found(plan, attitude=LvlhAttitude(uncertainty=lost))
    for what, value in numbers(shown, flights):
        assert isinstance(value, str) or np.all(np.isfinite(value)), what
    assert shown.held == shown.frames
    assert not shown.saturated_s.any()
    by_cause = {one.cause: one.share for one in flights.contributors}
    assert by_cause["attitude"] > 0.9
