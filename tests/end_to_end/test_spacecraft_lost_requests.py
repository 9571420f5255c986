"""A request that can't be flown costs itself only; a spacecraft's own limits are flown."""

import dataclasses
import math

import numpy as np
import pytest
from imaging_cases import sun_synchronous
from spacecraft_cases import four_modes, line, session

from planner.base import effort
from planner.base.errors import InfeasibleSlew
from planner.spacecraft.imaging import choice
from planner.spacecraft.imaging.candidates import candidates
from planner.spacecraft.imaging.session import make_session
from planner.spacecraft.imaging.timeline import DoesNotFit, build_timeline
from planner.spacecraft.plan import plan_imaging
from planner.spacecraft.requests import CorridorRequest, SpacecraftSettings, StripRequest
from planner.spacecraft.vehicle import SPACECRAFT, AgileSpacecraft

STRIP, STEREO, *_ = four_modes()


def low(requests, seconds, **more):
    """From 406 km, where a scan against the flight turns the body at (7.2 + 4.6) / 406 rad/s."""
    asked = session(requests, seconds, simulation_runs=0, **more)
    return dataclasses.replace(asked, orbit=sun_synchronous(406.0))


def test_a_scan_faster_than_the_body_may_turn_costs_its_request_only():
    """It broke the axis rate in the table, and the session ended as a failure of ours."""
    backwards = CorridorRequest(
        name="back", geometry=line(200.0, azimuth_deg=180.0), scan_speed_m_s=4648.0, priority=9.0
    )
    plan = plan_imaging(low([StripRequest(name="strip", geometry=line(90.0)), backwards], 300.0))
    assert [window.request for window in plan.windows] == ["strip"]
    [left_out] = plan.left_out
    assert "to scan 'back' the body would have to turn faster" in left_out.reason
    with pytest.raises(InfeasibleSlew, match=r"turn faster than the 1\.58 deg/s") as why:
        candidates(backwards, 0, make_session(low([backwards], 300.0)))
    assert (why.value.limit, why.value.field) == ("rate", "requests.0")


def test_a_scan_is_refused_by_the_limit_that_it_lacks():
    """A slow one at full rate, with hardly the torque that turns the momentum held; once it was
    said to lack the rate."""
    slow = CorridorRequest(
        name="slow", geometry=line(200.0, azimuth_deg=180.0), scan_speed_m_s=2500.0
    )
    weak = SpacecraftSettings(torque_max_n_m=1.3)
    with pytest.raises(InfeasibleSlew, match=r"with more than the 1\.3 N m there are") as why:
        candidates(slow, 0, make_session(low([slow], 400.0, settings=weak)))
    assert (why.value.limit, why.value.field) == ("torque", "requests.0")
    assert candidates(slow, 0, make_session(low([slow], 400.0)))


def test_of_a_reversible_detectors_scans_those_too_fast_are_none():
    strip = StripRequest(name="strip", geometry=line(90.0), scan_speed_m_s=4648.0)
    asked = low([strip], 300.0, settings=SpacecraftSettings(reversible_scan=True))
    made = make_session(asked)
    found = candidates(strip, 0, made)
    assert found
    for one in found:
        for share in (0.0, 0.5, 1.0):
            states = made.ends(one.arc, one.starts_s, share * one.arc.duration_s)
            omega_body_rad_s = states[:, 4:7]
            assert np.rad2deg(np.abs(omega_body_rad_s).max()) <= 1.58


def test_a_request_whose_slews_never_fit_leaves_the_others(monkeypatch):
    """Each try takes a sixth of the work there is."""

    def costly(made, chosen):
        for one in chosen:
            if one.request == 1:
                effort.charge(effort.PLAN / 6.0)
                raise DoesNotFit(one, InfeasibleSlew("the body needs about 28.8 s"))
        return build_timeline(made, chosen)

    monkeypatch.setattr(choice, "build_timeline", costly)
    corridor = CorridorRequest(name="corridor", geometry=line(300.0), priority=9.0)
    plan = plan_imaging(session([STRIP, corridor], 400.0, simulation_runs=0))
    assert [window.request for window in plan.windows] == ["strip"]
    [left_out] = plan.left_out
    assert "needs about 28.8 s" in left_out.reason


def test_what_nearly_full_gyros_turn_to_in_time_is_imaged():
    """All the work was spent on slews that the momentum leaves too slow."""
    settings = SpacecraftSettings(momentum_n_m_s=(0.0, 0.0, -45.0))
    plan = plan_imaging(session([STRIP, STEREO], 460.0, settings=settings, simulation_runs=0))
    assert {window.request for window in plan.windows} == {"strip"}
    assert "the slew between about" in plan.left_out[0].reason


def test_a_spacecrafts_own_limits_are_flown(monkeypatch):
    """1.75 deg/s were, where the definition said 0.5, and the verification passed."""
    slow = with_turns(
        rate_max_deg_s=0.5 / math.sqrt(3.0), momentum_max_n_m_s=20.0, torque_max_n_m=5.0
    )
    monkeypatch.setitem(SPACECRAFT, slow.name, slow)
    plan = plan_imaging(session([STRIP], 300.0, spacecraft="slow", simulation_runs=0))
    rate_deg_s = np.rad2deg(np.linalg.norm(plan.table.rate_rad_s, axis=1))
    assert 0.1 < rate_deg_s.max() <= 0.5 * 1.002
    assert plan.verification.torque_max_n_m <= 5.0 * 1.002
    assert plan.verification.momentum_max_n_m_s <= 20.0 * 1.002


def test_settings_change_what_they_name_only():
    own = with_turns(
        rate_max_deg_s=0.6, torque_max_n_m=9.0, torque_rate_max_n_m_s=8.0, settle_s=7.0
    )
    own = dataclasses.replace(own, swath_m=5e3, across_max_deg=20.0)
    assert SpacecraftSettings().applied_to(own) == own
    changed = SpacecraftSettings(settle_s=1.0, reversible_scan=True).applied_to(own)
    turns = dataclasses.replace(own.gyros.turns, settle_s=1.0)
    assert changed.gyros == dataclasses.replace(own.gyros, turns=turns)
    assert changed.body.camera == dataclasses.replace(own.body.camera, both_ways=True)
    assert dataclasses.replace(changed, body=own.body) == own


def with_turns(**limits):
    """A spacecraft of the name slow, whose turns have other limits."""
    own = AgileSpacecraft()
    turns = dataclasses.replace(own.gyros.turns, **limits)
    gyros = dataclasses.replace(own.gyros, turns=turns)
    return dataclasses.replace(own, body=dataclasses.replace(own.body, name="slow", gyros=gyros))
