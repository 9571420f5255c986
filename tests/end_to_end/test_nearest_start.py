"""A refusal keeps its own reason, whatever the search for another start meets."""

import re
from dataclasses import replace
from datetime import timedelta

import numpy as np
import pytest
from scenarios import EPOCH, LAS_VEGAS, TLE, at, moved, scenario, session

from app.requests.examples import message
from planner.base.errors import InfeasibleSlew, NotVisible
from planner.planning.sessions import nearest_start
from planner.planning.sessions.pipeline import make_plan
from planner.world.attitude.aem import AemAttitude
from planner.world.frames.time_scales import Instants, utc_from_text
from planner.world.orbits import OemOrbit, state_vector
from planner.world.orbits.state_vector import StateVectorOrbit
from planner.world.targets import GroundTarget, MovingGroundTarget
from planner.world.targets.ground_moving import LEAD_MAX_S

ATTITUDE = message("attitude.aem")
OEM = message("orbit.oem")

OVERHEAD = replace(LAS_VEGAS, min_elevation_deg=60.0)  # from 17:36:40 to 17:38:20
NEVER = GroundTarget(latitude_deg=85.0, longitude_deg=0.0)  # the ISS turns back at 51.6 deg


def refused(asked, kind):
    with pytest.raises(kind) as refusal:
        make_plan(asked)
    return refusal.value


def state_before(hours):
    """The Las Vegas pass from a state so long before it."""
    epoch_utc = EPOCH - timedelta(hours=hours)
    states = TLE.ephemeris(epoch_utc, EPOCH).states(Instants(epoch_utc, np.zeros(1)))
    return StateVectorOrbit(
        frame="GCRF",
        epoch=epoch_utc,
        position_km=tuple((states.r_sat_eci_m[0] / 1e3).tolist()),
        velocity_km_s=tuple((states.v_sat_eci_m_s[0] / 1e3).tolist()),
    )


def test_a_node_damaged_far_from_the_session_does_not_hide_the_reason():
    damaged = OEM.replace("2015-02-27T17:42:00 3881.3", "2015-02-27T17:42:00 3891.3")
    assert damaged != OEM
    asked = scenario(session(LAS_VEGAS, 1.0, 90.0), alpha=(150.0, 0.0, 0.0))
    refusal = refused(replace(asked, orbit=OemOrbit(content=damaged)), InfeasibleSlew)
    assert refusal.axis == "alpha"
    later = moved(asked, refusal.earliest_feasible_start_utc, at(90.0))
    assert make_plan(later).verification.passed


def test_attitude_rows_damaged_where_the_session_could_go_do_not_hide_the_reason():
    damaged, count = re.subn("(17:40:00 )-0.00", r"\1-0.02", ATTITUDE)
    assert count == 1
    asked = scenario(session(OVERHEAD, 10.0, 40.0))
    assert refused(asked, NotVisible).earliest_feasible_start_utc is not None
    refusal = refused(replace(asked, attitude=AemAttitude(content=damaged)), NotVisible)
    assert refusal.limit == "visibility"
    assert "below the 60 deg asked for" in refusal.detail
    assert refusal.earliest_feasible_start_utc is None
    assert "no start that can be flown was found" in refusal.detail


def test_a_target_known_for_hours_is_not_sought_for_a_day():
    """The next pass over the boat comes when its course is no longer known."""
    boat = MovingGroundTarget(
        latitude_deg=36.0,
        longitude_deg=-115.0,
        epoch=at(640.0 - LEAD_MAX_S),
        course_deg=90.0,
        speed_m_s=0.1,
    )
    asked = scenario(session(boat, 600.0, 630.0), epoch_s=500)
    assert refused(asked, NotVisible).earliest_feasible_start_utc is None


def gone_through(refusal):
    """From when to when starts of the session moved as a whole were gone through."""
    (span,) = re.findall(
        r"from (\S+Z) to (\S+Z),? ?[^;]* moving it", refusal.detail.split(" and ")[-1]
    )
    return [utc_from_text(text) for text in span]


def test_the_refusal_says_how_far_was_searched():
    """A day to either side, as the orbit is known, but not before the slew can begin."""
    first, last = gone_through(refused(scenario(session(NEVER, 60.0, 90.0)), NotVisible))
    assert first == at(0.2)
    assert last == at(86400.0 + 60.0)


def test_a_search_that_ends_early_says_so_and_always_ends_at_the_same_place(monkeypatch):
    asked = scenario(session(OVERHEAD, 10.0, 40.0))
    whole = refused(asked, NotVisible)
    hasty = replace(nearest_start.OPTIONS, search=3_000)
    monkeypatch.setattr(nearest_start, "OPTIONS", hasty)
    cut, again = refused(asked, NotVisible), refused(asked, NotVisible)
    assert whole.earliest_feasible_start_utc is not None
    assert cut.earliest_feasible_start_utc is None
    assert "nor looked for farther off" in cut.detail
    assert gone_through(cut)[1] < whole.earliest_feasible_start_utc
    assert again.detail == cut.detail
    hasty = replace(nearest_start.OPTIONS, search=0)
    monkeypatch.setattr(nearest_start, "OPTIONS", hasty)
    assert "none was decided before the search ends" in refused(asked, NotVisible).detail


def test_an_old_state_is_propagated_once(monkeypatch):
    """A day and the reach of the search in pieces of 900 s, and the rest of each span asked."""
    pieces = []
    propagate = state_vector.propagate_segment

    def counted(*arguments):
        pieces.append(arguments[2:4])
        return propagate(*arguments)

    monkeypatch.setattr(state_vector, "propagate_segment", counted)
    asked = replace(scenario(session(NEVER, 60.0, 90.0)), orbit=state_before(24.0))
    refused(asked, NotVisible)
    whole = [piece for piece in pieces if piece[1] - piece[0] == 900.0]
    assert len(whole) == len(set(whole)) == (24 * 3600 + 90 + 6000) // 900
    assert len(pieces) - len(whole) <= 2


def test_a_state_leads_to_the_same_place_whatever_was_asked_before():
    """1e-4 m: ten times what the propagation promises per piece."""
    orbit, fresh = state_before(3.0), state_before(3.0)
    orbit.ephemeris(at(-7200.0), at(-7100.0))
    instants = Instants(EPOCH, np.array([0.0, 50.0]))
    short, long = (
        some.ephemeris(at(0.0), at(stop_s)).states(instants).r_sat_eci_m
        for some, stop_s in ((orbit, 50.0), (fresh, 5000.0))
    )
    np.testing.assert_allclose(short, long, rtol=0.0, atol=1e-4)
