"""A drive's parameters are found from a flight, which test_flight.py holds against SciPy's."""

from dataclasses import replace

import numpy as np
import pytest
from flight_cases import ARCSEC, rough, swinging

from planner.inflight.simulation.flight import fly
from planner.inflight.simulation.identification import covariance, identify
from planner.world.platforms import ISS_HRC, AxisDrive

NAMES = tuple(
    f"{axis}.{field}"
    for axis in ISS_HRC.axis_names
    for field in ("coulomb_deg_s2", "command_latency_s", "bandwidth_hz")
)


def truth(drives):
    named = dict(zip(ISS_HRC.axis_names, drives, strict=True))
    return np.array([getattr(named[axis], field) for axis, field in (n.split(".") for n in NAMES)])


@pytest.fixture(scope="module")
def flown():
    """Both axes with other friction, latency and bandwidth than the platform is taken to have."""
    drives = (
        rough(
            coulomb_deg_s2=0.16, breakaway_deg_s2=0.32, command_latency_s=0.05, bandwidth_hz=0.35
        ),
        rough(
            coulomb_deg_s2=0.06, breakaway_deg_s2=0.12, command_latency_s=0.08, bandwidth_hz=0.27
        ),
    )
    table = swinging(20.0)
    flight = fly(table, ISS_HRC, drives=drives)
    return table, drives, flight.t_s, flight.angle_rad


def test_angles_tell_the_drive(flown):
    table, drives, t_s, angle_rad = flown
    noise = 0.15 * ARCSEC * np.random.default_rng(1).standard_normal(angle_rad.shape)
    found = identify(table, ISS_HRC, t_s, angle_rad + noise, None, NAMES)
    np.testing.assert_allclose(found.parameters, truth(drives), rtol=0.03)
    # The noise, and what parameters within 3 % move an axis by.
    assert np.all(found.residual_rad < 3.0 * 0.15 * ARCSEC)
    assert np.all(np.isnan(found.residual_rad_s))
    assert found.drives[0].coulomb_deg_s2 == found.parameters[0]
    assert found.drives[0].breakaway_deg_s2 == pytest.approx(2.0 * found.parameters[0])


def test_gyro_rates_with_a_bias_tell_it_too(flown):
    table, drives, t_s, angle_rad = flown
    noise = 0.5 * ARCSEC * np.random.default_rng(2).standard_normal(angle_rad.shape)
    bias = np.array([3.0, -2.0]) * ARCSEC
    rate_rad_s = np.gradient(angle_rad, t_s, axis=0) + noise + bias
    found = identify(table, ISS_HRC, t_s[::5], None, rate_rad_s[::5], NAMES)
    coulomb = [0, 3]
    np.testing.assert_allclose(found.parameters[coulomb], truth(drives)[coulomb], rtol=0.1)
    np.testing.assert_allclose(found.bias_rad_s, bias, rtol=0, atol=0.5 * ARCSEC)


def test_sigmas_are_what_seeds_scatter():
    """Within a factor of three: an encoder's noise also moves the axis, which sigmas leave out."""
    table, drives = swinging(20.0), (AxisDrive(), AxisDrive())
    scaled = []
    for seed in range(2):
        one = fly(table, ISS_HRC, drives=drives, seed=seed)
        found = identify(table, ISS_HRC, one.t_s[::10], one.measured_angle_rad[::10], None, NAMES)
        sigma = np.sqrt(np.diag(found.covariance_parameters))
        scaled.append((found.parameters - truth(drives)) / sigma)
    assert 1.0 / 9.0 < np.mean(np.square(scaled)) < 9.0


def test_what_a_flight_does_not_show_keeps_a_wide_sigma():
    """A constant pull is what the loop's integral settles to."""
    table = swinging(20.0)
    flown = fly(table, ISS_HRC)
    found = identify(
        table, ISS_HRC, flown.t_s, flown.measured_angle_rad, None, ["beta.cable_tension_deg_s2"]
    )
    assert np.sqrt(found.covariance_parameters[0, 0]) > 0.1


@pytest.mark.parametrize(
    ("names", "what", "says"),
    [
        (["gamma.coulomb_deg_s2"], "angles", "name an axis (alpha, beta), a dot and one of"),
        (["alpha.inertia_kg_m2"], "angles", "'alpha.inertia_kg_m2' can't be identified"),
        (["alpha.coulomb_deg_s2"], "nothing", "measured_angle_rad, measured_rate_rad_s or both"),
        (["alpha.coulomb_deg_s2"], "too late", "0 samples within the table's 20 s are too few"),
    ],
)
def test_what_cannot_be_identified_is_refused(names, what, says):
    table, t_s = swinging(20.0), np.arange(10.0) + (30.0 if what == "too late" else 0.0)
    angle_rad = None if what == "nothing" else np.zeros((10, 2))
    with pytest.raises(ValueError, match=r".+") as refused:
        identify(table, replace(ISS_HRC), t_s, angle_rad, None, names)
    assert says in str(refused.value)


def test_an_axis_that_was_not_measured_stays_as_it_was():
    table, name = swinging(20.0), "beta.coulomb_deg_s2"
    flown = fly(table, ISS_HRC)
    angle_rad = flown.measured_angle_rad.copy()
    angle_rad[:, 1] = np.nan
    found = identify(table, ISS_HRC, flown.t_s[::10], angle_rad[::10], None, [name])
    share = found.parameters[0] / ISS_HRC.drives[1].coulomb_deg_s2
    assert abs(np.log(share)) < np.sqrt(found.covariance_parameters[0, 0]) / found.parameters[0]
    assert np.isnan(found.residual_rad[1])


SAMPLES, FLIGHTS = 1500, 100
OPEN = np.array([1e6, 1e6])  # no prior to speak of


def errors(chance, memory):
    """Of one sigma, each `memory` of the last and the rest new."""
    found = chance.standard_normal(SAMPLES)
    for k in range(1, SAMPLES):
        found[k] = memory * found[k - 1] + np.sqrt(1.0 - memory**2) * found[k]
    return found


def one_step(k):
    """All is told within 300 samples, as of an axis that lets go once."""
    return np.stack([k > 600.0, (k > 600.0) & (k < 900.0)], axis=1).astype(float)


def throughout(k):
    return np.stack([np.sin(k / 40.0), np.cos(k / 70.0)], axis=1)


@pytest.mark.parametrize("slope_of", [one_step, throughout])
@pytest.mark.parametrize(("memory", "size"), [(0.0, 1.0), (0.0, 3.0), (0.7, 1.0)])
def test_told_and_kept_errors_agree(slope_of, memory, size):
    """Squares of errors over their sigmas: 1 on average, to 10 % at one sigma of 100 flights,
    and a window of 30 samples sees most of errors that are forgotten in 3."""
    slope, chance = slope_of(np.arange(float(SAMPLES))), np.random.default_rng(3)
    squares = []
    for _ in range(FLIGHTS):
        data = size * errors(chance, memory)
        fitted, *_ = np.linalg.lstsq(slope, data, rcond=None)
        missed = data - slope @ fitted
        told = covariance(slope[None], missed[None], np.ones((1, SAMPLES)), OPEN)
        squares.append(fitted @ np.linalg.solve(told, fitted) / 2.0)
    assert 0.7 < np.mean(squares) < 1.5


def test_a_prior_holds_what_nothing_shows():
    told = covariance(np.zeros((1, 50, 1)), np.ones((1, 50)), np.ones((1, 50)), np.array([2.3]))
    assert told[0, 0] == pytest.approx(2.3**2)
