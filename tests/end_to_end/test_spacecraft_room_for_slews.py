"""Room for the slews: between two looks, from the start's attitude, in the session."""

import dataclasses
import re

import numpy as np
import pytest
from spacecraft_cases import EPOCH, four_modes, line, session

from planner.base import effort
from planner.base.errors import InfeasibleSlew, SearchEnded, Unreachable
from planner.spacecraft.plan import plan_imaging
from planner.spacecraft.requests import (
    AreaRequest,
    CorridorRequest,
    GeoLineString,
    GeoPolygon,
    SpacecraftSettings,
)
from planner.world.frames.time_scales import elapsed_s

STRIP, STEREO, *_ = four_modes()


@pytest.mark.parametrize(
    "closer",
    [
        {"gap_s": 1.0},  # less than a scan
        {"look_angle_deg": 4.0},
        {"look_angle_deg": 15.0, "geometry": line(230.0, half_km=130.0)},  # 48 s a look
    ],
)
def test_looks_too_close_for_the_turn_between_are_refused_with_the_gap_that_works(closer):
    """Once a plan without an interval, which said that other requests were worth more."""
    pair = dataclasses.replace(STEREO, **closer)
    with pytest.raises(InfeasibleSlew, match="the slew between about") as why:
        plan_imaging(session([pair], 460.0, simulation_runs=0))
    assert why.value.field == "requests.0"
    gap_s = float(re.search(r"works: 'stereo' with a gap_s of (\d+)", why.value.detail)[1])
    wider = dataclasses.replace(pair, look_angle_deg=None, gap_s=gap_s)
    plan = plan_imaging(session([wider], 460.0, simulation_runs=0))
    assert [window.look for window in plan.windows] == [0, 1]


def test_what_has_no_room_for_its_own_turn_is_left_out_for_that_reason():
    pair = dataclasses.replace(STEREO, gap_s=12.0, priority=9.0)
    plan = plan_imaging(session([STRIP, pair], 460.0, simulation_runs=0))
    assert [window.request for window in plan.windows] == ["strip"]
    [left_out] = plan.left_out
    assert "the slew between" in left_out.reason


@pytest.mark.parametrize("q", [(0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0)])
def test_a_far_initial_attitude_delays_the_first_scan_rather_than_bar_it(q):
    """The time to the scan nearest overhead, 80 s, is little for 180 deg."""
    plan = plan_imaging(session([STRIP], 300.0, initial_q_body_from_eci_xyzw=q, simulation_runs=0))
    assert [window.request for window in plan.windows] == ["strip"]
    [onto] = [slew for slew in plan.slews if slew.onto == 0]
    np.testing.assert_allclose(plan.table.rate_rad_s[0], 0.0, atol=1e-9)
    assert plan.slews[0].start_utc == EPOCH
    settling_s = elapsed_s(plan.windows[0].start_utc, onto.stop_utc)
    assert settling_s > 2.6 - 1e-6


@pytest.mark.parametrize(("side_deg", "swath_m"), [(0.3, 100.0), (20.0, 12e3), (170.0, 100.0)])
def test_more_scans_than_a_session_holds_are_counted_not_tried(side_deg, swath_m):
    """Up to 120,000 strips, each of which was laid before anything was refused."""
    east, north = line(90.0).coordinates[0]
    x, y = side_deg / 2.0, min(side_deg, 20.0) / 2.0
    ring = ((-x, -y), (x, -y), (x, y), (-x, y), (-x, -y))
    geometry = GeoPolygon(coordinates=(tuple((east + a, north + b) for a, b in ring),))
    settings = SpacecraftSettings(swath_m=swath_m)
    with pytest.raises(
        Unreachable, match=r"more than 50 of one session|across, more than 500"
    ) as why:
        plan_imaging(
            session([AreaRequest(name="wide", geometry=geometry)], 3600.0, settings=settings)
        )
    assert why.value.field == "requests.0"


def test_more_legs_than_a_session_holds_are_counted():
    east, north = line(90.0).coordinates[0]
    legs = tuple((east + 0.012 * (k % 2), north + 0.012 * k) for k in range(64))
    corridor = CorridorRequest(name="zigzag", geometry=GeoLineString(coordinates=legs))
    with pytest.raises(Unreachable, match="it takes 63 scans, more than 50"):
        plan_imaging(session([corridor], 300.0))


def test_a_session_too_much_work_says_what_is_less(monkeypatch):
    monkeypatch.setattr(effort, "PLAN", 6_000)
    asked = session([STRIP], 300.0, objective="minimum_time", simulation_runs=0)
    settings = SpacecraftSettings(momentum_n_m_s=(10.0, 0.0, 0.0))
    with pytest.raises(SearchEnded, match='for the objective "smooth", or for less momentum'):
        plan_imaging(dataclasses.replace(asked, settings=settings))


def test_a_table_that_was_not_flown_says_so():
    plan = plan_imaging(session([STRIP], 300.0, simulation_runs=0))
    assert plan.stabilisation.share_steady is None
    [warning] = plan.warnings
    assert "not flown in closed loop" in warning
