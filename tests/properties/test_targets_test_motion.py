"""Bench motions: closed forms, derivatives, limits at every instant, refusals."""

import math
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from scipy.signal import chirp, sawtooth

from planner.base.errors import InvalidInput, TrackBreaksLimit
from planner.world.platforms import PLATFORMS
from planner.world.targets import BenchMotionTarget
from planner.world.targets.axis_signals import Chirp, ConstantRate, Multisine, Sine, Step, Triangle
from planner.world.targets.smooth_step import ramp, step

HRC = PLATFORMS["iss-hrc"]
SLOPE_MAX = 35.0 / 16.0  # of 35 x^4 - 84 x^5 + 70 x^6 - 20 x^7, at x = 1/2
CURVATURE_MAX = 84.0 * 5.0**0.5 / 25.0  # of the same, at x = (5 -+ sqrt 5)/10
START = datetime(2015, 2, 27, 17, 36, 20, tzinfo=UTC)
STILL = ConstantRate(rate_deg_s=0.0)

MOTIONS = {
    "constant_rate": ConstantRate(angle_deg=-30.0, rate_deg_s=0.7),
    "sine": Sine(angle_deg=5.0, amplitude_deg=3.0, frequency_hz=0.05, phase_deg=20.0),
    "linear chirp": Chirp(
        amplitude_deg=0.05, start_frequency_hz=0.01, stop_frequency_hz=0.4, sweep_s=60.0
    ),
    "logarithmic chirp": Chirp(
        amplitude_deg=0.05,
        start_frequency_hz=0.4,
        stop_frequency_hz=0.01,
        sweep_s=60.0,
        sweep="logarithmic",
    ),
    "step": Step(angle_deg=1.0, step_deg=-4.0, at_s=7.3, rise_s=8.0),
    "triangle": Triangle(angle_deg=2.0, amplitude_deg=10.0, period_s=40.0, turn_s=6.0),
    "multisine": Multisine(
        amplitudes_deg=(0.5, 0.2, 0.05), frequencies_hz=(0.03, 0.07, 0.19), angle_deg=-1.0
    ),
}


def fly(motion, duration_s=100.0, **changes):
    target = BenchMotionTarget(axes={"alpha": motion, "beta": STILL} | changes)
    target.require_flyable(HRC.dof_names, HRC.motion_bounds(), START, duration_s)


@pytest.mark.parametrize("name", MOTIONS)
def test_rate_and_acceleration_are_the_angles_derivatives(name):
    motion = MOTIONS[name]
    t_s = np.linspace(0.5, 59.5, 4001)
    h = 1e-3
    angle, rate, acceleration = motion.motion_deg(t_s)
    before, after = motion.motion_deg(t_s - h), motion.motion_deg(t_s + h)
    # Central differences: h^2/6 of the third derivative, 1 deg/s3 at most, and rounding 1e-14/h.
    np.testing.assert_allclose((after[0] - before[0]) / (2 * h), rate, rtol=0, atol=1e-6)
    np.testing.assert_allclose((after[1] - before[1]) / (2 * h), acceleration, rtol=0, atol=1e-6)
    assert np.all(np.abs(angle) < 200.0)


@pytest.mark.parametrize("name", MOTIONS)
def test_examples_can_be_flown_by_the_hrc(name):
    fly(MOTIONS[name])


def test_every_axis_gets_its_motion_in_the_platforms_order():
    target = BenchMotionTarget(axes={"beta": MOTIONS["sine"], "alpha": MOTIONS["step"]})
    t_s = np.array([0.0, 5.0, 20.0])
    moved = target.axis_motion(("alpha", "beta"), t_s)
    assert (
        moved.angle_rad.shape == moved.rate_rad_s.shape == moved.acceleration_rad_s2.shape == (3, 2)
    )
    np.testing.assert_allclose(np.degrees(moved.angle_rad[:, 0]), [1.0, 1.0, -3.0], atol=1e-12)
    expected = 5.0 + 3.0 * np.sin(2 * np.pi * 0.05 * t_s + np.radians(20.0))
    np.testing.assert_allclose(np.degrees(moved.angle_rad[:, 1]), expected, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "method"), [("linear chirp", "linear"), ("logarithmic chirp", "log")]
)
def test_chirp_is_scipys(name, method):
    motion = MOTIONS[name]
    t_s = np.linspace(0.0, motion.sweep_s, 2001)
    expected = motion.amplitude_deg * chirp(
        t_s, motion.start_frequency_hz, motion.sweep_s, motion.stop_frequency_hz, method, phi=-90
    )
    np.testing.assert_allclose(motion.motion_deg(t_s)[0], expected, rtol=0, atol=1e-10)


def test_chirp_stays_at_its_last_frequency():
    motion = MOTIONS["linear chirp"]
    t_s = np.linspace(60.0, 80.0, 501)
    _, rate, acceleration = motion.motion_deg(t_s)
    angle = motion.motion_deg(t_s)[0]
    np.testing.assert_allclose(acceleration[1:], -((2 * np.pi * 0.4) ** 2) * angle[1:], atol=1e-12)
    assert np.max(np.abs(rate)) == pytest.approx(2 * np.pi * 0.4 * 0.05, rel=1e-3)


def test_triangle_is_scipys_away_from_its_turns():
    motion = MOTIONS["triangle"]
    t_s = np.linspace(0.0, 200.0, 20001)
    sharp = 2.0 + 10.0 * sawtooth(2 * np.pi * (t_s / 40.0 + 0.25), width=0.5)
    angle, rate, acceleration = motion.motion_deg(t_s)
    straight = np.abs((t_s - 10.0) % 20.0 - 0.0) > 3.01
    straight &= np.abs((t_s - 10.0) % 20.0 - 20.0) > 3.01
    np.testing.assert_allclose(angle[straight], sharp[straight], rtol=0, atol=1e-10)
    np.testing.assert_allclose(np.abs(rate[straight]), 1.0, rtol=1e-12)
    # What the docstring promises of a turn.
    assert np.max(angle) == pytest.approx(12.0 - 0.13672 * 1.0 * 6.0, rel=1e-4)
    assert np.max(np.abs(acceleration)) == pytest.approx(4.375 / 6.0, rel=1e-4)


def test_step_has_the_peaks_it_promises():
    t_s = np.linspace(0.0, 20.0, 200001)
    _, rate, acceleration = Step(step_deg=-4.0, at_s=7.3, rise_s=8.0).motion_deg(t_s)
    assert np.max(np.abs(rate)) == pytest.approx(SLOPE_MAX * 4.0 / 8.0, rel=1e-6)
    assert np.max(np.abs(acceleration)) == pytest.approx(CURVATURE_MAX * 4.0 / 64.0, rel=1e-6)
    jerk = np.max(np.abs(np.diff(acceleration))) / 1e-4
    assert jerk == pytest.approx(52.5 * 4.0 / 512.0, rel=1e-4)


def test_ramp_is_the_steps_integral():
    t_s = np.linspace(-5.0, 5.0, 20001)
    area = np.concatenate(
        [
            [0.0],
            np.cumsum(
                np.diff(t_s) * (step(t_s / 4 + 0.5)[0][1:] + step(t_s / 4 + 0.5)[0][:-1]) / 2
            ),
        ]
    )
    np.testing.assert_allclose(ramp(t_s, 4.0), area, rtol=0, atol=1e-7)  # trapezoids of 0.5 ms


def test_schroeders_phases_keep_the_peak_low():
    """Schroeder 1970: a flat comb peaks at 1.7 of its rms; in phase, n harmonics at sqrt(2 n)."""
    harmonics = tuple(0.01 * k for k in range(1, 21))
    t_s = np.linspace(0.0, 100.0, 20001)
    flat = Multisine(amplitudes_deg=(1.0,) * 20, frequencies_hz=harmonics).motion_deg(t_s)[0]
    crest = np.max(np.abs(flat)) / np.sqrt(np.mean(flat**2))
    assert crest < 2.0  # in phase: 6.3
    given = Multisine(
        amplitudes_deg=(1.0, 2.0), frequencies_hz=(0.1, 0.2), phases_deg=(90.0, 0.0)
    ).motion_deg(np.zeros(1))
    assert given[0, 0] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("motion", "limit"),
    [
        (ConstantRate(angle_deg=100.0, rate_deg_s=1.0), "angle"),
        (ConstantRate(angle_deg=170.0, rate_deg_s=-3.1), "rate"),
        (Sine(amplitude_deg=20.0, frequency_hz=0.05), "rate"),
        (Sine(amplitude_deg=3.0, frequency_hz=0.1), "acceleration"),
        (Step(step_deg=5.0, rise_s=6.0), "acceleration"),
        (Step(step_deg=1.0, rise_s=3.7), "jerk"),
        (Triangle(amplitude_deg=10.0, period_s=20.0, turn_s=5.0), "acceleration"),
        (Multisine(amplitudes_deg=(0.1, 0.5), frequencies_hz=(0.1, 0.3)), "acceleration"),
        (Sine(amplitude_deg=3e-4, frequency_hz=2.0), "table step"),
    ],
)
def test_what_the_axis_or_the_table_cannot_follow_is_refused(motion, limit):
    with pytest.raises(TrackBreaksLimit) as refusal:
        fly(motion)
    assert refusal.value.axis == "alpha"
    assert refusal.value.limit == limit
    assert refusal.value.field == "axes.alpha"
    assert refusal.value.at_utc >= START


def test_a_session_amid_a_motion_is_judged_by_its_own_stretch():
    """A chirp's rate is 2 pi f times its amplitude: it is within 3 deg/s early, beyond it late."""
    chirp_deg = Chirp(
        amplitude_deg=5.0, start_frequency_hz=0.001, stop_frequency_hz=0.2, sweep_s=200.0
    )
    target = BenchMotionTarget(axes={"alpha": chirp_deg, "beta": STILL}, start=START)
    target.require_flyable(HRC.dof_names, HRC.motion_bounds(), START, 10.0)
    late = START + timedelta(seconds=180.0)
    with pytest.raises(TrackBreaksLimit) as refused:
        target.require_flyable(HRC.dof_names, HRC.motion_bounds(), late, 10.0)
    assert late <= refused.value.at_utc <= late + timedelta(seconds=10.0)


def test_the_table_step_criterion_is_the_hermites_error():
    """A cubic through two rows misses a sine by A (2 pi f h)^4 / 384 halfway between them.

    At 2 Hz the next order, (2 pi f h)^2 / 60, is a tenth.
    """
    amplitude_deg = 384.0 * 0.1 / 3600.0 / (2 * math.pi * 2.0 * 0.2) ** 4
    fly(Sine(amplitude_deg=0.9 * amplitude_deg, frequency_hz=2.0))
    with pytest.raises(TrackBreaksLimit, match="table"):
        fly(Sine(amplitude_deg=1.3 * amplitude_deg, frequency_hz=2.0))


def test_axes_must_be_the_platforms():
    with pytest.raises(InvalidInput, match="alpha, beta"):
        BenchMotionTarget(axes={"alpha": STILL}).axis_motion(HRC.axis_names, np.zeros(1))


def test_too_long_a_check_is_refused():
    with pytest.raises(InvalidInput, match="shorten the session"):
        fly(Step(step_deg=1e-6, rise_s=1e-3), duration_s=86400.0)


@pytest.mark.parametrize(
    ("make", "fields", "says"),
    [
        (Triangle, {"amplitude_deg": 1.0, "period_s": 4.0, "turn_s": 2.1}, "half of period_s"),
        (Multisine, {"amplitudes_deg": (1.0,), "frequencies_hz": (0.1, 0.2)}, "one for each"),
        (Multisine, {"amplitudes_deg": (), "frequencies_hz": ()}, "must hold 1 to"),
        (BenchMotionTarget, {"axes": {}}, "axes must name"),
    ],
)
def test_impossible_motions_are_refused(make, fields, says):
    with pytest.raises(ValueError, match=says):
        make(**fields)


def test_a_chirp_of_one_frequency_is_refused():
    with pytest.raises(ValueError, match="two different"):
        Chirp(amplitude_deg=1.0, start_frequency_hz=0.1, stop_frequency_hz=0.1, sweep_s=9.0)
