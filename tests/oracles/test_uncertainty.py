"""The pointing budget is what geometry and probability theory say."""

import math
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation, Slerp
from scipy.stats import multivariate_normal, norm

from planner.motion.pointing.angles import axis_angles
from planner.motion.pointing.line_of_sight import line_of_sight
from planner.planning.sessions.platforms.two_axis.budget import pointing_budget
from planner.planning.sessions.probability import (
    lattice_points,
    probability_inside,
    probability_wandering,
)
from planner.planning.sessions.uncertainty import OPTIONS as BUDGET_OPTIONS
from planner.world.attitude import AttitudeUncertainty, InertialAttitude, LvlhAttitude
from planner.world.frames.time_scales import Instants, utc_from_text
from planner.world.messages.aem import read_aem
from planner.world.orbits import StateVectorOrbit, TleOrbit
from planner.world.orbits.accuracy import NormalMixture, tle_sigma
from planner.world.platforms.iss_hrc import ISS_HRC
from planner.world.targets.ground import GroundTarget

DATA = Path(__file__).parents[1] / "data"
START = utc_from_text("2015-02-27T17:36:20Z")
TLE = TleOrbit(
    line1="1 25544U 98067A   15058.48161588  .00023857  00000-0  35618-3 0  9991",
    line2="2 25544  51.6478 271.9610 0008043  54.4849  18.6646 15.54887163930964",
)
LAS_VEGAS = GroundTarget(latitude_deg=36.1147, longitude_deg=-115.1728, height_m=610.0)
INERTIAL = InertialAttitude(epoch=START, q_body_from_eci_xyzw=(0.0, 0.0, 0.0, 1.0))
INSTANTS = Instants(START, np.arange(0.0, 90.05, 0.2))
HALF_RAD = np.array([0.008, 0.005])
QUASI_RANDOM = 0.003  # the error stated for 16384 points
MIDDLE = np.zeros((1, 2))


def budget(orbit=TLE, attitude=INERTIAL, clock_s=BUDGET_OPTIONS.clock_s, platform=ISS_HRC):
    ephemeris = orbit.ephemeris(START, START + timedelta(seconds=95))
    los = line_of_sight(INSTANTS, ephemeris, attitude, ISS_HRC.q_platform_from_body, LAS_VEGAS)
    found = budget_of(los, ephemeris, attitude, platform, clock_s)
    return found, {c.cause: c for c in found.contributions}, los


def budget_of(los, ephemeris, attitude, platform=ISS_HRC, clock_s=BUDGET_OPTIONS.clock_s):
    """With the axes exactly on the target."""
    angle_rad = axis_angles(platform, los.los_base).angle_rad[0]
    return pointing_budget(
        los, ephemeris, attitude, LAS_VEGAS, platform, angle_rad, session=0, clock_s=clock_s
    )


def fresh_state():
    """What a GNSS receiver gives at the session's start."""
    states = TLE.ephemeris(START, START + timedelta(seconds=95)).states(
        Instants(START, np.zeros(1))
    )
    return StateVectorOrbit(
        frame="GCRF",
        epoch=START,
        position_km=tuple(states.r_sat_eci_m[0] / 1e3),
        velocity_km_s=tuple(states.v_sat_eci_m_s[0] / 1e3),
    )


@pytest.mark.parametrize("correlation", [-0.9, 0.0, 0.6])
@pytest.mark.parametrize("size", [0.3, 1.0, 3.0])
def test_a_constant_error_falls_in_the_rectangle_as_the_bivariate_normal_says(correlation, size):
    """Against SciPy's bivariate normal distribution function."""
    sigma = size * HALF_RAD
    covariance = np.outer(sigma, sigma) * [[1.0, correlation], [correlation, 1.0]]
    root = np.linalg.cholesky(covariance)  # columns are independent causes
    offsets = np.repeat(root.T[:, None, :], 5, axis=1)
    expected = multivariate_normal([0.0, 0.0], covariance).cdf(HALF_RAD, lower_limit=-HALF_RAD)
    found = probability_inside(offsets, HALF_RAD, MIDDLE)
    assert found == pytest.approx(expected, abs=QUASI_RANDOM)
    # Held off the middle for an instant of the five, the target has that much less room there.
    off = np.array([0.7, -0.4]) * HALF_RAD
    low, high = np.maximum(-HALF_RAD, -HALF_RAD - off), np.minimum(HALF_RAD, HALF_RAD - off)
    expected = multivariate_normal([0.0, 0.0], covariance).cdf(high, lower_limit=low)
    known = np.zeros((5, 2))
    known[3] = off
    assert probability_inside(offsets, HALF_RAD, known) == pytest.approx(expected, abs=QUASI_RANDOM)


def test_an_error_that_swings_across_the_frame_counts_on_both_axes():
    """An offset of fixed length turning through all directions: a disc inside the rectangle.

    With two equal causes the radius is Rayleigh distributed: 1 - exp(-r^2 / 2 sigma^2).
    """
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    sigma, half = 0.004, np.array([0.006, 0.006])
    first = sigma * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    second = sigma * np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    expected = 1.0 - math.exp(-0.5 * (0.006 / sigma) ** 2)
    found = probability_inside(np.stack([first, second]), half, MIDDLE)
    assert found == pytest.approx(expected, abs=QUASI_RANDOM)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e4])
def test_a_draw_at_the_edge_of_the_frame_is_judged_in_full_precision(size):
    """Frames whose edge lies 1e-12 beyond, or before, a draw: it counts, or not."""
    draws = np.abs(lattice_points(1, 0)[0])
    offsets = size * np.array([[[0.0, 1.0]]])
    for draw in draws[::997]:
        for side in (-1e-12, 1e-12):
            half = np.array([1.0, size * draw * (1.0 + side)])
            found = probability_inside(offsets, half, MIDDLE)
            assert found == np.mean(draws <= draw * (1.0 + side))


@pytest.mark.parametrize("rough", [0.0, 1e-3, 0.3, 10.0])
@pytest.mark.parametrize("count", [1, 2, 5, 23])
def test_the_instants_looked_at_later_count_as_the_few_looked_at_first(rough, count):
    """The probability is that of every draw at every instant, however its way bends between."""
    rng = np.random.default_rng(count)
    along = np.linspace(-1.0, 1.0, count)[:, None]
    parts = rng.normal(size=(6, 1, 2)) + along * rng.normal(size=(6, 1, 2))
    parts = 0.3 * HALF_RAD * (parts + rough * rng.normal(size=(6, count, 2)))
    *constant, sine, cosine, known = parts
    reboosts = NormalMixture((0.7, 0.2, 0.1), (0.7, 1.6, 200.0))
    draws = lattice_points(3, 1).copy()
    draws[2] = reboosts.scores(draws[2])
    places = known[..., None] + np.stack([*constant, sine, cosine], axis=-1) @ draws
    farthest = np.abs(places / HALF_RAD[:, None]).max(axis=(0, 1))
    swing = np.stack([sine, cosine])
    found = probability_inside(np.stack(constant), HALF_RAD, known, [swing], reboosts)
    assert found == np.mean(farthest <= 1.0)


@pytest.mark.parametrize("rare", [0.0, 0.12, 0.3])
def test_an_error_of_several_normals_falls_in_the_frame_as_their_shares_say(rare):
    """The shares times what each of the distributions has there, by SciPy's normal distribution."""
    sigma = 0.5 * HALF_RAD[0]
    parts = ((0.75 * (1.0 - rare), 0.7), (0.25 * (1.0 - rare), 1.6), (rare, 300.0))
    expected = sum(
        share * (1.0 - 2.0 * norm.cdf(-HALF_RAD[0] / (ratio * sigma))) for share, ratio in parts
    )
    offsets = np.array([[[0.0, 0.0]], [[sigma, 0.0]]])
    found = probability_inside(
        offsets, HALF_RAD, MIDDLE, (), NormalMixture(*zip(*parts, strict=True))
    )
    assert found == pytest.approx(expected, abs=QUASI_RANDOM)


@pytest.mark.parametrize("turned", [0.0, 2.0])
def test_a_swing_of_unknown_phase_is_distributed_as_a_sinusoid(turned):
    """A short session sees one value of it: P(|A sin| < h) = 2/pi arcsin(h/A), not a Gaussian's."""
    half, amplitude = HALF_RAD[1], 1.3 * HALF_RAD[1]
    swing = np.zeros((2, 1, 2))
    swing[:, 0, 1] = amplitude / math.sqrt(2.0) * np.array([math.cos(turned), math.sin(turned)])
    expected = 2.0 / math.pi * math.asin(half / amplitude)
    found = probability_inside(np.zeros((0, 1, 2)), HALF_RAD, MIDDLE, [swing])
    assert found == pytest.approx(expected, abs=QUASI_RANDOM)


def test_a_swing_seen_for_half_a_turn_shows_its_amplitude():
    phase = np.linspace(0.0, math.pi, 181)
    waves = np.stack([np.cos(phase), np.sin(phase)])[:, :, None] * np.array([0.0, HALF_RAD[1]])
    for size, expected in ((0.99, 1.0), (1.01, 0.0)):
        swing = size / math.sqrt(2.0) * waves
        found = probability_inside(np.zeros((0, 181, 2)), HALF_RAD, MIDDLE, [swing])
        assert found == pytest.approx(expected, abs=0.1)  # near the turning point for 0.1 of them


def test_the_stations_swing_in_roll_is_seen_along_one_side_of_the_frame():
    """0.236 deg about body x, which the inner axis lies along: across it, or with the frame turned.

    A quarter turn brings the long side, 0.44 deg from the middle, across the amplitude of 0.33.
    """
    upright = budget(attitude=LvlhAttitude())[0]
    turned = budget(
        attitude=LvlhAttitude(), platform=replace(ISS_HRC, frame_turn_rad=math.pi / 2.0)
    )[0]
    assert upright.probability_in_frame < turned.probability_in_frame - 0.1
    assert upright.sigma_arcsec == pytest.approx(turned.sigma_arcsec, rel=1e-9)


def test_what_the_request_states_of_the_attitude_replaces_the_swing():
    exact = AttitudeUncertainty(sigma_body_deg=(0.0, 0.0, 0.0), swing_rms_body_deg=(0.0, 0.0, 0.0))
    _, causes, _ = budget(attitude=LvlhAttitude(uncertainty=exact))
    assert causes["attitude"].sigma_arcsec == 0.0
    stated = AttitudeUncertainty(sigma_body_deg=(0.1, 0.1, 0.1), swing_rms_body_deg=(0.0, 0.0, 0.0))
    for law in (LvlhAttitude(uncertainty=stated), replace(INERTIAL, uncertainty=stated)):
        _, causes, _ = budget(attitude=law)
        # 0.1 deg about each of two axes across the line of sight, and none about it.
        assert causes["attitude"].sigma_arcsec == pytest.approx(360.0, rel=1e-6)
        assert "states" in causes["attitude"].basis


def test_what_the_request_leaves_out_of_the_attitude_stays_the_laws_own():
    later = InertialAttitude(
        epoch=START - timedelta(minutes=30), q_body_from_eci_xyzw=(0.0, 0.0, 0.0, 1.0)
    )
    alone = budget(attitude=later)[1]["attitude"].sigma_arcsec
    for uncertainty in (
        AttitudeUncertainty(),
        AttitudeUncertainty(swing_rms_body_deg=(0.0, 0.0, 0.0)),
    ):
        _, causes, _ = budget(attitude=replace(later, uncertainty=uncertainty))
        assert causes["attitude"].sigma_arcsec == pytest.approx(alone, rel=1e-12)
    upright = AttitudeUncertainty(sigma_body_deg=(0.0, 0.0, 0.0))
    _, causes, _ = budget(attitude=LvlhAttitude(uncertainty=upright))
    assert causes["attitude"].sigma_arcsec > 500.0  # the swing alone
    assert "measured" in causes["attitude"].basis


def test_a_frame_smaller_than_the_random_error_holds_nothing():
    assert probability_inside(np.zeros((1, 1, 2)), np.array([0.0, 0.005]), MIDDLE) == 0.0


def test_an_orbit_error_is_seen_across_the_line_of_sight():
    """A fresh GNSS state is 10 m off on each axis: 10 m per image axis at the target.

    With an inertial attitude nothing else turns; the drift within 90 s changes it by 0.5 m at most.
    """
    _, causes, _ = budget(fresh_state())
    assert 9.5 <= causes["orbit"].ground_m <= 10.5
    assert "assumed" in causes["orbit"].basis


def test_a_late_clock_costs_the_lines_own_motion():
    """clock_s times the rate at which the line of sight turns, spread over two axes."""
    _, causes, los = budget(clock_s=0.1)
    rate_rad_s = np.linalg.norm(los.los_rate_base_per_s, axis=1)
    most_arcsec = np.rad2deg(rate_rad_s.max()) * 3600.0 * 0.1 / math.sqrt(2.0)
    assert 0.7 * most_arcsec <= causes["clock"].sigma_arcsec <= 1.001 * most_arcsec


def test_the_local_vertical_turns_with_an_orbit_that_is_off():
    """Along-track d turns LVLH by d/r and the target by d/range; against LVLH they partly cancel.

    Near nadir at 410 km: 1/range - 1/r = 0.94 of 1/range.
    """
    inertial = budget(TLE, INERTIAL)[1]["orbit"].sigma_arcsec
    lvlh = budget(TLE, LvlhAttitude())[1]["orbit"].sigma_arcsec
    assert lvlh / inertial == pytest.approx(0.94, abs=0.02)


def test_contributions_add_up_and_say_what_they_rest_on():
    found, causes, los = budget()
    total = math.sqrt(sum(c.sigma_arcsec**2 for c in found.contributions))
    assert found.sigma_arcsec == pytest.approx(total, rel=1e-9)
    assert set(causes) == {"orbit", "attitude", "Earth orientation", "clock", "drive resolution"}
    assert all("measured" in c.basis or "assumed" in c.basis for c in found.contributions)
    near_m, far_m = los.range_m.min(), los.range_m.max()
    metres_per_arcsec = found.ground_m / found.sigma_arcsec
    assert near_m < metres_per_arcsec * 180.0 * 3600.0 / math.pi < far_m


class Older:
    """The same orbit, from elements two days older."""

    warnings = ()

    def __init__(self, ephemeris):
        self.states = ephemeris.states
        self._ephemeris = ephemeris

    def sigma(self, instants):
        fresh = self._ephemeris
        age_s = fresh.age_s(instants) + 2.0 * 86400.0
        return tle_sigma(age_s, fresh.drag_in_a_day_m, fresh.air_in_a_day_m)


def test_a_better_orbit_keeps_the_target_in_the_frame():
    fresh, _, los = budget()
    ephemeris = Older(TLE.ephemeris(START, START + timedelta(seconds=95)))
    stale = budget_of(los, ephemeris, INERTIAL)
    assert stale.probability_in_frame < 0.5 < fresh.probability_in_frame < 1.0
    wide = replace(ISS_HRC, frame_half_rad=(0.5, 0.5))
    assert budget(platform=wide)[0].probability_in_frame == 1.0


def turns_of_the_station():
    """Attitudes from LVLH in torque equilibrium, three orbits of telemetry: (t_s, rotations)."""
    text = (DATA / "iss_attitude_tea_2018-285.aem").read_text()
    segment = read_aem(text)[0]
    return segment.t_s, Rotation.from_quat(segment.q_body_from_frame_xyzw)


@pytest.mark.parametrize("size", [0.6, 0.8, 1.0, 1.4, 2.0])
def test_the_target_stays_in_the_frame_as_often_as_told(size):
    """The station as it really swung, from any moment on, about a mean stated to 0.05 deg.

    Frames of several sizes, so that told probabilities lie all over the scale.
    """
    t_s, q_body_from_lvlh = turns_of_the_station()
    mean = q_body_from_lvlh.mean()
    yaw_deg, pitch_deg, roll_deg = mean.inv().as_euler("ZYX", degrees=True)
    law = LvlhAttitude(yaw_deg=yaw_deg, pitch_deg=pitch_deg, roll_deg=roll_deg)
    frame = replace(ISS_HRC, frame_half_rad=tuple(size * np.array(ISS_HRC.frame_half_rad)))
    # A state with no age and a clock without error: only the attitude is on trial.
    found, _, los = budget(fresh_state(), law, 0.0, frame)

    rng = np.random.default_rng(1)
    session_s = INSTANTS.t_s[::25]
    sight = los.los_base[::25]
    outer = np.array(ISS_HRC.axes_platform[0])
    along = np.cross(outer, sight)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    sides = np.stack([along, np.cross(sight, along)], axis=1)
    starts_s = rng.uniform(t_s[0], t_s[-1] - session_s[-1], 1500)
    true = Slerp(t_s, q_body_from_lvlh)((starts_s[:, None] + session_s).ravel())
    wrong = Rotation.from_rotvec(np.deg2rad(rng.normal(0.0, 0.05, (len(starts_s), 3))))
    stated = wrong[np.repeat(np.arange(len(starts_s)), len(session_s))] * mean
    seen = (true * stated.inv()).apply(np.tile(sight, (len(starts_s), 1)))
    off_rad = np.einsum("nij,knj->kni", sides, seen.reshape(len(starts_s), -1, 3))
    inside = np.all(np.abs(off_rad) <= frame.frame_half_rad, axis=(1, 2))
    assert found.probability_in_frame == pytest.approx(inside.mean(), abs=0.05)


def test_a_frame_that_turns_in_seconds_is_looked_at_while_it_turns():
    """The target passes the outer axis by 1.5 deg, where the frame turns round in seconds.

    Drawn attitudes, each row by itself; 3 sigma of 4,000 draws.
    """
    middle = len(INSTANTS) // 2
    _, _, level = budget(fresh_state(), LvlhAttitude(), 0.0)
    outer, inner = np.array(ISS_HRC.axes_platform)
    beside = Rotation.from_rotvec(math.radians(1.5) * inner).apply(outer)
    turn, _ = Rotation.align_vectors(
        [beside, inner],
        [level.los_base[middle], level.los_rate_base_per_s[middle]],
        weights=[np.inf, 1.0],
    )
    yaw_deg, pitch_deg, roll_deg = turn.inv().as_euler("ZYX", degrees=True)
    sigma_deg = 0.2
    known = AttitudeUncertainty(sigma_body_deg=(sigma_deg,) * 3, swing_rms_body_deg=(0.0,) * 3)
    law = LvlhAttitude(yaw_deg=yaw_deg, pitch_deg=pitch_deg, roll_deg=roll_deg, uncertainty=known)
    found, _, los = budget(fresh_state(), law, 0.0)

    sight = los.los_base
    along = np.cross(outer, sight)
    assert np.linalg.norm(along, axis=1).min() == pytest.approx(math.radians(1.5), rel=0.1)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    sides = np.stack([along, np.cross(sight, along)], axis=1)
    turns_rad = np.deg2rad(np.random.default_rng(2).normal(0.0, sigma_deg, (4000, 3)))
    seen = np.cross(turns_rad[:, None], sight)
    off_rad = np.einsum("nij,knj->kni", sides, seen)
    inside = np.all(np.abs(off_rad) <= ISS_HRC.frame_half_rad, axis=(1, 2)).mean()
    drawn = math.sqrt(inside * (1.0 - inside) / len(turns_rad))
    assert found.probability_in_frame == pytest.approx(inside, abs=3.0 * drawn + QUASI_RANDOM)


def test_a_likely_miss_is_said_with_what_would_help_most():
    found, _, los = budget(attitude=LvlhAttitude())
    assert found.probability_in_frame < 0.9
    warning = replace(found, session=3).warning()
    assert "session 4" in warning
    assert f"{found.probability_in_frame:.3f}" in warning
    assert "attitude telemetry" in warning
    old = Older(TLE.ephemeris(START, START + timedelta(seconds=95)))
    stale = budget_of(los, old, LvlhAttitude())
    assert "younger elements" in stale.warning()
    assert budget(platform=replace(ISS_HRC, frame_half_rad=(0.5, 0.5)))[0].warning() is None


@pytest.mark.parametrize(
    ("sigma_deg", "swing_deg", "clock_s"),
    [
        ((0.05, 0.05, 0.05), (0.2, 0.02, 0.02), BUDGET_OPTIONS.clock_s),
        ((0.02, 0.06, 0.2), (0.02, 0.4, 0.04), 0.3),
        ((0.1, 0.1, 0.1), (0.0, 0.0, 0.2), 0.1),
        ((0.01, 0.01, 0.01), (0.02, 0.02, 0.02), BUDGET_OPTIONS.clock_s),
    ],
)
@pytest.mark.parametrize("older", [False, True])
def test_what_is_said_to_help_most_does(sigma_deg, swing_deg, clock_s, older):
    """Each remedy applied in full: a state of today, a law without errors, a clock in step."""
    known = AttitudeUncertainty(sigma_body_deg=sigma_deg, swing_rms_body_deg=swing_deg)
    exact = AttitudeUncertainty(sigma_body_deg=(0.0,) * 3, swing_rms_body_deg=(0.0,) * 3)
    law = LvlhAttitude(yaw_deg=-4.0, pitch_deg=-2.0, roll_deg=0.8, uncertainty=known)
    elements = TLE.ephemeris(START, START + timedelta(seconds=95))
    orbit = Older(elements) if older else elements
    state = fresh_state().ephemeris(START, START + timedelta(seconds=95))
    los = line_of_sight(INSTANTS, elements, law, ISS_HRC.q_platform_from_body, LAS_VEGAS)
    found = budget_of(los, orbit, law, clock_s=clock_s)
    remedied = {
        "orbit": budget_of(los, state, law, clock_s=clock_s),
        "attitude": budget_of(los, orbit, replace(law, uncertainty=exact), clock_s=clock_s),
        "clock": budget_of(los, orbit, law, clock_s=0.0),
    }
    kept = {cause: one.probability_in_frame for cause, one in remedied.items()}
    if found.probability_in_frame >= 0.9:
        assert found.helps_most is None
    else:
        assert kept[found.helps_most] >= max(kept.values()) - 0.01 - 2.0 * QUASI_RANDOM


def kept_inside(half_sigmas, half_lives, off_sigmas=0.0, runs=20_000):
    """That a process of the second order stays between walls, by its covariance alone.

    Drawn as a whole, by the Cholesky factor of (1 + z) exp(-z), which halves in a half-life.
    """
    per_half_life = brentq(lambda z: (1.0 + z) * math.exp(-z) - 0.5, 0.0, 5.0)
    t = np.linspace(0.0, half_lives, max(2, math.ceil(30.0 * half_lives)))
    z = per_half_life * np.abs(np.subtract.outer(t, t))
    factor = np.linalg.cholesky((1.0 + z) * np.exp(-z) + 1e-9 * np.eye(len(t)))
    paths = off_sigmas + factor @ np.random.default_rng(3).standard_normal((len(t), runs))
    return float(np.mean(np.abs(paths).max(axis=0) <= half_sigmas))


@pytest.mark.parametrize(
    ("half_sigmas", "half_lives"), [(2.0, 1.0), (2.5, 10.0), (1.5, 3.0), (3.5, 40.0), (3.0, 1e-4)]
)
def test_what_wanders_leaves_as_its_covariance_says(half_sigmas, half_lives):
    """In one axis; across the frame's other side nothing is lost."""
    t_s = np.linspace(0.0, half_lives, 11)
    found = probability_wandering(
        np.zeros((1, 11, 2)), np.array([half_sigmas, np.inf]), np.zeros((11, 2)), t_s, 1.0, 1.0
    )
    # 4096 paths: 2.5 sigma of their share
    assert found == pytest.approx(kept_inside(half_sigmas, half_lives), abs=0.02)


def test_beside_what_wanders_a_constant_error_counts_as_itself():
    """Sigma 1 of each, forgotten never: their sum's variances add up, in both axes."""
    offsets = np.broadcast_to(np.array([[[1.0, 0.0]], [[0.0, 1.0]]]), (2, 11, 2))
    found = probability_wandering(
        offsets, np.array([2.0, 3.0]), np.zeros((11, 2)), np.linspace(0.0, 60.0, 11), 1.0, 1e9
    )
    both = [1.0 - 2.0 * norm.sf(half / math.sqrt(2.0)) for half in (2.0, 3.0)]
    assert found == pytest.approx(both[0] * both[1], abs=0.02)


def test_one_place_alone_is_the_frame_of_a_process_that_starts_off():
    """Known to be off by a sigma: the walls are as far apart as they are."""
    known = np.tile([1.0, 0.0], (11, 1))
    found = probability_wandering(
        np.zeros((1, 11, 2)), np.array([2.5, np.inf]), known, np.linspace(0.0, 5.0, 11), 1.0, 1.0
    )
    assert found == pytest.approx(kept_inside(2.5, 5.0, off_sigmas=1.0), abs=0.02)
