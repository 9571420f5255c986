"""Measured rotations correct an attitude law as probability theory says."""

from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import gamma, kv

from planner.base.errors import InvalidInput
from planner.world.attitude import (
    AemAttitude,
    AttitudeCorrection,
    AttitudeUncertainty,
    HarmonicAttitude,
    InertialAttitude,
    LvlhAttitude,
)
from planner.world.attitude.errors import REST_MEMORY_S, REST_RAD
from planner.world.frames.time_scales import Instants, utc_from_text
from planner.world.orbits import OrbitStates

MESSAGE = (Path(__file__).parents[1] / "data/iss_attitude_1s_2018-285.aem").read_text()
MESSAGE_FIRST = utc_from_text("2018-10-12T06:00:27.799Z")
MESSAGE_LAST = utc_from_text("2018-10-12T06:08:14.799Z")
START = utc_from_text("2015-02-27T17:36:20Z")
SESSION = Instants(START, np.linspace(0.0, 90.0, 11))
REST_DEG = np.rad2deg(REST_RAD)
STILL = (0.0, 0.0, 0.0)
ALONG_X = OrbitStates(np.tile([0.0, 0.0, 6.8e6], (11, 1)), np.tile([7.6e3, 0.0, 0.0], (11, 1)))


def correction(before_s, turn_deg, sigma_deg=0.02, heading_deg=None):
    """Measured so long before the session, alike about all axes or, from a horizon, not about Z."""
    variances = np.full(3, sigma_deg**2)
    if heading_deg is not None:
        variances[2] = heading_deg**2
    return AttitudeCorrection(
        epoch=START - timedelta(seconds=before_s),
        turn_body_deg=tuple(float(turn) for turn in turn_deg),
        covariance_deg2=tuple(tuple(row) for row in np.diag(variances).tolist()),
    )


def matern(apart_s):
    """Of order 5/2 by its Bessel function: Rasmussen and Williams 2006, eq. 4.14."""
    x = np.sqrt(5.0) * np.maximum(np.abs(apart_s), 1e-6) / REST_MEMORY_S
    return 2.0**-1.5 / gamma(2.5) * x**2.5 * kv(2.5, x)


def law(*corrections, sigma_deg=(0.1, 0.1, 0.1), swing_deg=STILL):
    uncertainty = AttitudeUncertainty(sigma_body_deg=sigma_deg, swing_rms_body_deg=swing_deg)
    return LvlhAttitude(uncertainty=uncertainty, corrections=corrections)


def told_deg(one, instants=SESSION):
    """1-sigma about each body axis, (n, 3)."""
    return np.rad2deg(np.sqrt(np.sum(one.errors(instants).modes_body_rad ** 2, axis=0)))


def turned_deg(one, at=SESSION, states=ALONG_X):
    """By how much the attitude is corrected, rotation vectors in body axes."""
    plain = replace(one, corrections=())
    turn = one.q_body_from_eci(at, states) * plain.q_body_from_eci(at, states).inv()
    return turn.as_rotvec(degrees=True)


def test_one_measurement_of_a_constant_turn_has_the_closed_form():
    """The weighted mean of nothing known and the measurement: sources with known variances."""
    one = law(correction(600.0, (0.15, -0.05, 0.0)))
    known, seen = 0.1**2, 0.02**2
    lasting = known**2 / (known + REST_DEG**2)
    alike = lasting + (known - lasting) * matern(645.0)
    share = alike / (known + seen)
    np.testing.assert_allclose(turned_deg(one)[5], share * np.array([0.15, -0.05, 0.0]), atol=1e-9)
    # a session's errors are told by their six largest modes
    np.testing.assert_allclose(told_deg(one)[5], np.sqrt(known - share * alike), rtol=1e-3)


def test_the_sign_is_that_of_the_measured_attitude():
    """The law's body turned by the correction is the true one."""
    one = law(correction(10.0, (0.2, 0.0, 0.0), sigma_deg=1e-4), sigma_deg=(1.0, 1.0, 1.0))
    plain = law().q_body_from_eci(SESSION, ALONG_X)
    true = Rotation.from_rotvec([0.2, 0.0, 0.0], degrees=True) * plain
    off_deg = np.rad2deg((true * one.q_body_from_eci(SESSION, ALONG_X).inv()).magnitude())
    assert off_deg.max() < 1e-4  # 0.02 deg of unmodelled motion, squared, of 1 deg assumed


def test_what_was_not_measured_stays_as_uncertain():
    one = law(correction(60.0, (0.1, 0.05, 3.0), heading_deg=180.0))
    np.testing.assert_allclose(told_deg(one)[:, 2], 0.1, rtol=1e-4)
    assert abs(turned_deg(one)[0, 2]) < 1e-5


def test_two_looks_a_quarter_orbit_apart_fix_a_swing():
    """Amplitude and phase follow from values a quarter turn apart: then it is predicted."""
    phase = 2.0 * np.pi / 5560.0
    swing = lambda t_s: 0.3 * np.cos(phase * np.asarray(t_s) + 0.7)  # noqa: E731
    looks = (1800.0, 410.0)
    one = law(
        *(correction(t_s, (swing(-t_s), 0.0, 0.0), 0.005) for t_s in looks),
        sigma_deg=(0.01, 0.01, 0.01),
        swing_deg=(0.236, 0.0, 0.0),
    )
    miss_deg = turned_deg(one)[:, 0] - swing(SESSION.t_s)
    assert np.abs(miss_deg).max() < 0.03
    assert (np.abs(miss_deg) < 3.0 * told_deg(one)[:, 0]).all()
    assert told_deg(one)[:, 0].max() < 0.05  # of 0.24 before


def test_the_covariance_is_that_of_a_joint_gaussian_drawn_at_random():
    """100,000 draws of turn, swing and measurements, regressed: what SciPy's and NumPy's random
    numbers give without the formula.
    """
    rng = np.random.default_rng(5)
    draws, sigma, swing, noise = 100_000, 0.05, 0.2, 0.03
    lasting = sigma**2 / np.hypot(sigma, REST_DEG[0])
    bias = rng.normal(0.0, lasting, draws)
    cos, sin = rng.normal(0.0, swing, (2, draws))
    rate = 2.0 * np.pi / 5560.0
    # so near that nothing of the swing is forgotten
    looks_s, session_s = np.array([-900.0, -300.0]), np.array([0.0, 90.0])

    all_s = np.concatenate([looks_s, session_s])
    alike = matern(np.subtract.outer(all_s, all_s))
    rest = rng.multivariate_normal(np.zeros(4), (sigma**2 - lasting**2) * alike, draws).T
    swings = np.outer(np.cos(rate * all_s), cos) + np.outer(np.sin(rate * all_s), sin)
    error = bias + rest + swings
    seen, then = error[:2] + rng.normal(0.0, noise, (2, draws)), error[2:]
    gain = np.linalg.lstsq(seen.T, then.T, rcond=None)[0].T
    left = np.std(then - gain @ seen, axis=1)
    values = (0.1, 0.06)
    one = law(
        *(correction(-t, (v, 0.0, 0.0), noise) for t, v in zip(looks_s, values, strict=True)),
        sigma_deg=(sigma,) * 3,
        swing_deg=(swing, 0.0, 0.0),
    )
    at = Instants(START, session_s)
    # 1e5 draws give a standard deviation to 0.3 %, a regression to about 1 %
    np.testing.assert_allclose(told_deg(one, at)[:, 0], left, rtol=0.02)
    states = OrbitStates(ALONG_X.r_sat_eci_m[:2], ALONG_X.v_sat_eci_m_s[:2])
    np.testing.assert_allclose(turned_deg(one, at, states)[:, 0], gain @ values, atol=2e-3)


def test_a_contradiction_is_refused_at_5_sigma():
    sigma_deg = np.hypot(0.1, 0.02)
    believed = law(correction(60.0, (4.9 * sigma_deg, 0.0, 0.0)))
    assert turned_deg(believed)[0, 0] > 0.4
    refused = law(correction(60.0, (5.1 * sigma_deg, 0.0, 0.0)))
    with pytest.raises(InvalidInput, match=r"5\.1 sigma from the law;") as refusal:
        refused.q_body_from_eci(SESSION, ALONG_X)
    assert refusal.value.field == "attitude.corrections"
    assert refusal.value.at_utc == START - timedelta(seconds=60)


def test_corrections_that_contradict_each_other_are_refused():
    """Each by itself is what the law may be off by."""
    first, second = correction(120.0, (0.2, 0.0, 0.0)), correction(60.0, (-0.1, 0.0, 0.0))
    for one in (law(first), law(second)):
        one.q_body_from_eci(SESSION, ALONG_X)
    with pytest.raises(InvalidInput, match="sigma from the law as corrected before"):
        law(first, second).q_body_from_eci(SESSION, ALONG_X)


def test_the_told_errors_are_kept():
    """Over random truths, with looks and swings as the law assumes them: NEES is 1."""
    rng = np.random.default_rng(11)
    sigma, swing, noise = 0.05, (0.236, 0.021, 0.0), 0.02
    rate = 2.0 * np.pi / 5560.0
    squares = []
    for _ in range(300):
        bias, phase = rng.normal(0.0, sigma, 3), rng.uniform(0.0, 2.0 * np.pi, 3)

        def error(t_s, bias=bias, phase=phase):
            # a random phase, not a Gaussian amplitude: as the carrier swings
            return bias + np.sqrt(2.0) * np.array(swing) * np.cos(rate * t_s + phase)

        looks = [
            correction(before_s, error(-before_s) + rng.normal(0.0, noise, 3), noise)
            for before_s in (2400.0, 900.0, 200.0)
        ]
        one = law(*looks, sigma_deg=(sigma,) * 3, swing_deg=swing)
        miss_deg = error(SESSION.t_s[5]) - turned_deg(one)[5]
        squares.append((miss_deg / told_deg(one)[5]) ** 2)
    # 900 values of one degree of freedom: 1 +- 0.05; unmodelled motion isn't drawn but is told
    assert 0.6 < np.mean(squares) < 1.15


def test_a_covariance_that_makes_no_sense_is_refused():
    epoch = START
    for rows, said in (
        (((1.0, 0.5, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), "symmetric"),
        (((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0)), "positive definite"),
        (((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 0.0)), "positive definite"),
    ):
        with pytest.raises(ValueError, match=said):
            AttitudeCorrection(epoch=epoch, turn_body_deg=STILL, covariance_deg2=rows)


def test_a_measurement_sent_twice_is_refused():
    """Counted as two it would be surer than it is."""
    with pytest.raises(InvalidInput, match="given twice") as refused:
        told_deg(law(correction(600.0, (0.1, 0.0, 0.0)), correction(600.0, (0.1, 0.0, 0.0))))
    assert refused.value.field == "attitude.corrections"
    two_cameras = correction(600.0, (0.1, 0.0, 0.0)), correction(600.0, (0.1, 0.0, 1e-6))
    assert (told_deg(law(*two_cameras)) < told_deg(law(two_cameras[0]))).all()


@pytest.mark.parametrize("sigma_deg", [1e-160, 1e-15, 1e-6])
@pytest.mark.parametrize("unknown_deg", [0.1, 20.0])
def test_measurements_without_noise_at_the_same_instant_leave_a_finite_error(
    sigma_deg, unknown_deg
):
    """All that can be known: what the rest does until the session."""
    looks = [correction(60.0, (0.1, 0.0, 1e-14 * k), sigma_deg=sigma_deg) for k in range(100)]
    exact = law(*looks, sigma_deg=(unknown_deg,) * 3)
    noisy = law(correction(60.0, (0.1, 0.0, 0.0)), sigma_deg=(unknown_deg,) * 3)
    assert (told_deg(exact) > 0.0).all()
    assert (told_deg(exact) <= told_deg(noisy)).all()
    assert turned_deg(exact)[0, 0] == pytest.approx(0.1, rel=0.05)


def test_instants_each_by_itself_are_as_if_asked_alone():
    """A campaign's many views; before, between and hours after the measurements."""
    one = law(
        correction(3000.0, (0.1, 0.0, 0.0)),
        correction(600.0, (0.05, 0.02, 0.0), heading_deg=180.0),
        swing_deg=(0.2, 0.05, 0.0),
    )
    many = Instants(START, np.linspace(-4000.0, 250_000.0, 20_000))
    covariance = [
        np.einsum("mna,mnb->nab", told.modes_body_rad, told.modes_body_rad)
        for told in (
            one.errors_each(many),
            *(one.errors(Instants(START, many.t_s[row : row + 1])) for row in (0, 250, 19_999)),
        )
    ]
    alone = np.concatenate(covariance[1:])
    np.testing.assert_allclose(covariance[0][[0, 250, 19_999]], alone, rtol=1e-9, atol=1e-15)


def test_no_correction_of_a_constant_rate_where_it_says_nothing():
    """Of a week before it was believed to the last degree."""
    inertial = InertialAttitude(epoch=START, q_body_from_eci_xyzw=(0.0, 0.0, 0.0, 1.0))
    replace(inertial, corrections=(correction(7199.0, (0.1, 0.0, 0.0)),))
    with pytest.raises(ValueError, match=r"corrections\.1\.epoch is 2\.0 h"):
        replace(inertial, corrections=(correction(60.0, STILL), correction(7200.0, STILL)))


def swinging_carrier(phase):
    """Body from ECI, seconds from START: swings about X by 0.33 deg while LVLH turns about -Y."""
    rate = 2.0 * np.pi / 5560.0

    def q_body_from_eci(t_s):
        t_s = np.atleast_1d(t_s)
        swing_deg = np.outer(0.334 * np.cos(rate * t_s + phase), [1.0, 0.0, 0.0])
        q_lvlh = Rotation.from_rotvec(np.outer(rate * t_s, [0.0, 1.0, 0.0]))
        return Rotation.from_rotvec(swing_deg, degrees=True) * q_lvlh

    return q_body_from_eci


def test_looks_at_a_constant_rates_error_foretell_it_as_well_as_told():
    """Its error turns with the orbit: half of it a quarter orbit on has another size and sign."""
    rng = np.random.default_rng(7)
    before_deg, left_deg, told = [], [], []
    for phase in rng.uniform(0.0, 2.0 * np.pi, 40):
        true = swinging_carrier(phase)
        omega_deg_s = (true(-0.5) * true(0.5).inv()).as_rotvec(degrees=True)[0]
        q_body = true(0.0)[0]

        def error_deg(t_s, true=true, omega_deg_s=omega_deg_s, q_body=q_body):
            turned = Rotation.from_rotvec(-np.outer(t_s, omega_deg_s), degrees=True)
            return (true(t_s) * (turned * q_body).inv()).as_rotvec(degrees=True)

        looks_s = np.array([-600.0, 600.0, 1200.0])
        one = InertialAttitude(
            epoch=START,
            q_body_from_eci_xyzw=tuple(q_body.as_quat().tolist()),
            omega_body_deg_s=tuple(omega_deg_s.tolist()),
            corrections=tuple(
                correction(-t_s, turn_deg + rng.normal(0.0, 0.02, 3))
                for t_s, turn_deg in zip(looks_s, error_deg(looks_s), strict=True)
            ),
        )
        then = Instants(START, np.array([3600.0]))
        before_deg.append(error_deg(then.t_s)[0])
        left_deg.append(before_deg[-1] - np.rad2deg(one.turn_rad(then)[0]))
        told.append(told_deg(one, then)[0])
    nees = np.mean((np.array(left_deg) / told) ** 2, axis=0)
    rms_deg, left_rms_deg = (np.sqrt(np.mean(np.square(d))) for d in (before_deg, left_deg))
    assert left_rms_deg < 0.4 * rms_deg
    assert (nees < 1.5).all()  # this carrier's rate is exact and its orbit doesn't drift


def still_at(epoch):
    return replace(correction(0.0, STILL), epoch=epoch)


@pytest.mark.parametrize(
    "epoch", [MESSAGE_FIRST - timedelta(seconds=1), MESSAGE_LAST + timedelta(hours=1)]
)
def test_a_correction_outside_a_message_is_refused(epoch):
    """What the law is corrected from isn't known there."""
    corrections = (still_at(MESSAGE_LAST), still_at(epoch))
    with pytest.raises(ValueError, match=r"corrections\.1\.epoch .* lies outside the message"):
        AemAttitude(content=MESSAGE, corrections=corrections)


@pytest.mark.parametrize(("after_h", "why"), [(-0.05, "in the history"), (7.0, "more than 6 h")])
def test_a_correction_of_what_is_not_carried_on_is_refused(after_h, why):
    corrections = (still_at(MESSAGE_LAST + timedelta(hours=after_h)),)
    with pytest.raises(ValueError, match=rf"corrections\.0\.epoch .*{why}"):
        HarmonicAttitude(content=MESSAGE, corrections=corrections)
