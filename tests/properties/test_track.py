"""A track stays on target, unwrapped and within limits, and an impossible one is refused."""

import dataclasses
import math
from datetime import UTC, datetime

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy_boresight import scipy_boresight

from planner.base.errors import TrackBreaksLimit, Unreachable
from planner.motion.pointing.angles import axis_angles
from planner.motion.pointing.line_of_sight import LineOfSight
from planner.motion.pointing.track import track_candidates
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms import ISS_HRC

EPOCH = datetime(2015, 2, 27, 17, 36, tzinfo=UTC)
REST = np.zeros(2)


def great_circle(t_s, normal, start, rate_rad_s):
    """A direction that turns uniformly about `normal`, with its exact derivatives."""
    normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
    start = np.asarray(start, dtype=float)
    los = Rotation.from_rotvec(np.outer(rate_rad_s * t_s, normal)).apply(
        start / np.linalg.norm(start)
    )
    rate = rate_rad_s * np.cross(normal, los)
    acceleration = rate_rad_s * np.cross(normal, rate)
    return LineOfSight(
        instants=Instants(EPOCH, t_s),
        states=OrbitStates(np.full_like(los, np.nan), np.full_like(los, np.nan)),
        los_base=los,
        los_rate_base_per_s=rate,
        los_acceleration_base_per_s2=acceleration,
        range_m=np.full(len(t_s), 5e5),
        clearance_rad=np.full(len(t_s), 1.0),
    )


def rows(start_s, stop_s):
    return np.arange(round(start_s * 5), round(stop_s * 5) + 1) / 5.0


def roomy(stop_deg):
    limits = dataclasses.replace(
        ISS_HRC.outer_limits,
        angle_min_rad=-math.radians(stop_deg),
        angle_max_rad=math.radians(stop_deg),
    )
    return dataclasses.replace(ISS_HRC, outer_limits=limits, inner_limits=limits)


def test_track_points_at_and_between_rows():
    los = great_circle(rows(-20, 60), [0.1, -1.0, 0.2], [-0.3, 0.1, 0.9], 0.012)
    for track in track_candidates(ISS_HRC, los, 0.0, 50.0, REST):
        t_s = np.linspace(0.0, 50.0, 997)
        angle, rate, acceleration = track.motion(t_s)
        truth = great_circle(t_s, [0.1, -1.0, 0.2], [-0.3, 0.1, 0.9], 0.012).los_base
        off = np.linalg.norm(scipy_boresight(angle) - truth, axis=1)
        error_arcsec = np.degrees(off) * 3600
        assert error_arcsec.max() < 1e-6  # quintic Hermite at 0.2 s: six orders below 0.1 arcsec
        step = 1e-3
        ahead, behind = track.motion(t_s + step), track.motion(t_s - step)
        inside = slice(1, -1)
        np.testing.assert_allclose(
            rate[inside], (ahead[0] - behind[0])[inside] / (2 * step), rtol=0, atol=1e-8
        )
        np.testing.assert_allclose(
            acceleration[inside], (ahead[1] - behind[1])[inside] / (2 * step), rtol=0, atol=1e-8
        )


def test_nearer_branch_comes_first():
    los = great_circle(rows(0, 40), [0.0, -1.0, 0.0], [-0.2, 0.3, 1.0], 0.01)
    platform = roomy(200.0)
    ways = track_candidates(platform, los, 0.0, 40.0, REST)
    for branch_rad in axis_angles(platform, los.los_base[:1]).angle_rad[:, 0]:
        whole_turns = np.array([way.axis_states[0][0] - branch_rad for way in ways]) / (
            2.0 * math.pi
        )
        assert np.isclose(whole_turns, np.round(whole_turns)).all(axis=1).any()
    distances = [np.abs(way.axis_states[0][0]).max() for way in ways]
    assert distances == sorted(distances)
    for way in ways:
        nearest = track_candidates(platform, los, 0.0, 40.0, way.axis_states[0][0])[0]
        np.testing.assert_array_equal(nearest.axis_states[0], way.axis_states[0])


def test_angles_run_on_beyond_half_a_turn_when_the_stops_allow():
    """1.2 turns about alpha: no wrap, and each whole turn that fits is offered."""
    outer = ISS_HRC.axes_platform[0]
    t_s = rows(0, 180)
    los = great_circle(t_s, outer, [0.2, -0.4, 0.9], math.radians(2.4))
    ways = track_candidates(roomy(400.0), los, 0.0, 180.0, REST)
    for way in ways:
        assert np.abs(np.diff(way.axis_states[0], axis=0)).max() < math.radians(0.5)
        span = np.degrees(way.axis_states[0, -1, 0] - way.axis_states[0, 0, 0])
        assert span == pytest.approx(432.0, abs=1e-6)
    with pytest.raises(Unreachable) as refused:
        track_candidates(ISS_HRC, los, 0.0, 180.0, REST)
    assert refused.value.limit == "angle"
    assert refused.value.axis == "alpha"
    assert refused.value.at_utc is not None


def test_whole_turns_that_fit_are_all_candidates():
    los = great_circle(rows(0, 20), [0.0, -1.0, 0.0], [-0.2, 0.3, 1.0], 0.005)
    ways = track_candidates(roomy(300.0), los, 0.0, 20.0, REST)
    starts = {tuple(np.round(np.degrees(way.axis_states[0][0]), 6)) for way in ways}
    assert len(starts) == len(ways) > 2
    for way in ways:
        pointed = scipy_boresight(way.axis_states[0])
        np.testing.assert_allclose(pointed, los.los_base, rtol=0, atol=1e-12)


def test_keyhole_pass_breaks_the_rate_limit_and_says_when():
    """The direction passes 0.5 deg from the alpha axis at 20 s: alpha would have to spin."""
    outer = ISS_HRC.axes_platform[0]
    across = np.cross(outer, [1.0, 0.0, 0.0])
    nearest = outer + math.tan(math.radians(0.5)) * across
    normal = np.cross([1.0, 0.0, 0.0], nearest)
    start = Rotation.from_rotvec(-0.012 * 20.0 * normal / np.linalg.norm(normal)).apply(
        nearest / np.linalg.norm(nearest)
    )
    los = great_circle(rows(0, 40), normal, start, 0.012)
    with pytest.raises(TrackBreaksLimit) as refused:
        track_candidates(ISS_HRC, los, 0.0, 40.0, REST)
    assert refused.value.axis == "alpha"
    assert refused.value.limit in ("rate", "acceleration")
    assert 0.0 < (refused.value.at_utc - EPOCH).total_seconds() <= 20.0


def test_track_goes_on_around_the_session_only_while_it_can():
    """After 60 s the direction enters the dead cone of the alpha axis of a tilted platform."""
    los = great_circle(rows(-30, 130), [1.0, 0.0, 0.0], [0.3, 0.1, 0.9], 0.012)
    way = track_candidates(ISS_HRC, los, 0.0, 20.0, REST)[0]
    assert way.t_s[0] <= 0.0
    assert way.t_s[-1] >= 20.0
    limits = ISS_HRC.outer_limits
    assert np.abs(way.axis_states[0]).max() <= limits.angle_max_rad
    assert np.abs(way.axis_states[1]).max() <= limits.rate_max_rad_s * (1.0 + 1e-9)


def test_singular_direction_itself_is_refused():
    outer = ISS_HRC.axes_platform[0]
    los = great_circle(rows(0, 4), outer, outer, 0.0)
    with pytest.raises(Unreachable, match=r"singular|no pair"):
        track_candidates(ISS_HRC, los, 0.0, 4.0, REST)


def test_a_jerk_beyond_the_limit_is_refused_with_its_axis_and_time():
    t_s = rows(0.0, 60.0)
    los = great_circle(t_s, [1.0, 0.3, 0.0], [0.0, 0.3, 1.0], 0.01)
    [found, *_] = track_candidates(ISS_HRC, los, 10.0, 50.0, REST)
    jerk = np.abs(np.diff(found.axis_states[2], axis=0)) / 0.2
    worst = jerk.max(axis=0)
    axis = int(np.argmax(worst))
    # of the flown cubic's jerk, a mean over the cell as the difference is
    limits = dataclasses.replace(ISS_HRC.outer_limits, jerk_max_rad_s3=0.5 * worst[axis])
    slow = dataclasses.replace(ISS_HRC, outer_limits=limits, inner_limits=limits)
    with pytest.raises(TrackBreaksLimit) as refused:
        track_candidates(slow, los, 10.0, 50.0, REST)
    assert refused.value.limit == "jerk"
    assert refused.value.axis in ISS_HRC.axis_names
    late_s = (refused.value.at_utc - EPOCH).total_seconds()
    assert 10.0 <= late_s < 50.0
    assert "deg/s3" in refused.value.detail


def test_a_stop_passed_by_little_is_told_with_enough_digits():
    los = great_circle(rows(0.0, 30.0), [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.01)
    [found, *_] = track_candidates(roomy(350.0), los, 0.0, 30.0, REST)
    passed = dataclasses.replace(
        ISS_HRC.inner_limits, angle_max_rad=found.axis_states[0][:, 1].max() - math.radians(1e-5)
    )
    stopped = dataclasses.replace(ISS_HRC, inner_limits=passed)
    with pytest.raises(Unreachable) as refused:
        track_candidates(stopped, los, 0.0, 30.0, REST)
    words = refused.value.detail.split(" deg")
    turned, stop = words[0].split()[-1], words[1].split()[-1]
    assert turned != stop
