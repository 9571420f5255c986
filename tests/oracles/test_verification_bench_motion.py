"""The judge holds a bench session to the motion it prescribes."""

import dataclasses
from datetime import timedelta

import numpy as np
import pytest
from judged_tables import (
    ARCSEC_RAD,
    EPOCH_UTC,
    FIRST_ROW,
    LAST_ROW,
    START_S,
    changed,
    only,
    scenario_of,
)
from scipy.interpolate import BPoly

from planner.base.commands import CommandTable, axis_channels
from planner.verification import verify
from planner.world.targets import BenchMotionTarget
from planner.world.targets.axis_signals import ConstantRate, Sine

AMPLITUDE_RAD, OMEGA_S = np.deg2rad(3.0), 2.0 * np.pi * 0.05
TARGET = BenchMotionTarget(
    axes={
        "alpha": Sine(angle_deg=5.0, amplitude_deg=3.0, frequency_hz=0.05),
        "beta": ConstantRate(angle_deg=-2.0, rate_deg_s=0.1),
    }
)


def motion(t_s, start_s):
    """Angle, rate and acceleration of both axes in closed form, each (n, 2)."""
    phase = OMEGA_S * (t_s - start_s)
    sine, cosine = AMPLITUDE_RAD * np.sin(phase), AMPLITUDE_RAD * np.cos(phase)
    angle = [np.deg2rad(5.0) + sine, np.deg2rad(-2.0 + 0.1 * (t_s - start_s))]
    rate = [OMEGA_S * cosine, np.full_like(t_s, np.deg2rad(0.1))]
    acceleration = [-(OMEGA_S**2) * sine, np.zeros_like(t_s)]
    return tuple(np.stack(pair, axis=-1) for pair in (angle, rate, acceleration))


def table_of(start_s=START_S):
    """A quintic slew from rest at zero, then the motion."""
    join_s = FIRST_ROW / 5.0
    end = np.stack(motion(np.float64(join_s), start_s))
    slew = BPoly.from_derivatives([0.0, join_s], [np.zeros((3, 2)), end])
    slew_s, track_s = np.arange(FIRST_ROW) / 5.0, np.arange(FIRST_ROW, LAST_ROW + 1) / 5.0
    angle_rad, rate_rad_s, _ = motion(track_s, start_s)
    return CommandTable(
        epoch_utc=EPOCH_UTC,
        channels=axis_channels(("alpha", "beta")),
        position=np.concatenate([slew(slew_s), angle_rad]),
        rate_rad_s=np.concatenate([slew.derivative()(slew_s), rate_rad_s]),
    )


@pytest.fixture(scope="module")
def scenario():
    return scenario_of(target=TARGET)


@pytest.fixture(scope="module")
def table():
    return table_of()


def test_the_motion_itself_passes_without_a_view(scenario, table):
    report = verify(table, scenario)
    assert report.passed, report.findings
    assert report.taken_as_given == ("motion",)
    (session,) = report.sessions
    assert session.elevation_min_rad is session.limb_clearance_min_rad is None
    assert session.rows_max_rad < 1e-12
    # the Hermite of a sine: amplitude (omega h)^4 / 384
    hermite_rad = AMPLITUDE_RAD * (OMEGA_S * 0.2) ** 4 / 384.0
    assert session.between_rows_max_rad == pytest.approx(hermite_rad, rel=0.02)


def test_a_start_of_its_own_is_kept():
    start_utc = EPOCH_UTC + timedelta(seconds=50)
    scenario = scenario_of(target=dataclasses.replace(TARGET, start=start_utc))
    assert verify(table_of(start_s=50.0), scenario).passed
    only_alpha, only_beta = (
        [finding for finding in verify(table_of(), scenario).findings if finding.axis == axis]
        for axis in ("alpha", "beta")
    )
    assert only_alpha[0].limit == only_beta[0].limit == "motion"


@pytest.mark.parametrize("column", [0, 1])
@pytest.mark.parametrize("row", [FIRST_ROW, 401, LAST_ROW])
def test_a_row_off_the_motion_is_found_on_its_axis(scenario, table, row, column):
    report = verify(changed(table, column, row, angle_rad=0.2 * ARCSEC_RAD), scenario)
    finding = only(report, "motion")
    assert finding.axis == ("alpha", "beta")[column]
    assert finding.t_s == pytest.approx(row / 5.0)
    assert report.sessions[0].rows_max_rad == pytest.approx(0.2 * ARCSEC_RAD, rel=1e-6)


def test_a_rate_off_the_motion_is_found(scenario, table):
    # between rows it bulges by 4/27 of 0.2 s of it: 0.03 arcsec, which the angle alone allows
    report = verify(changed(table, 1, 401, rate_rad_s=ARCSEC_RAD), scenario)
    finding = only(report, "motion")
    assert finding.t_s == pytest.approx(401 / 5.0)
    assert report.sessions[0].max_rad < 0.1 * ARCSEC_RAD


def test_a_motion_too_quick_for_the_table_is_found():
    quick = dataclasses.replace(
        TARGET, axes={**TARGET.axes, "beta": Sine(amplitude_deg=0.1, frequency_hz=2.0)}
    )
    table = table_of()
    rows_s = np.arange(FIRST_ROW, LAST_ROW + 1) / 5.0 - START_S
    phase = 4.0 * np.pi * rows_s
    angles, rates = table.position.copy(), table.rate_rad_s.copy()
    angles[FIRST_ROW:, 1] = np.deg2rad(0.1) * np.sin(phase)
    rates[FIRST_ROW:, 1] = np.deg2rad(0.1) * 4.0 * np.pi * np.cos(phase)
    report = verify(
        dataclasses.replace(table, position=angles, rate_rad_s=rates), scenario_of(target=quick)
    )
    finding = only(report, "motion")
    assert finding.axis == "beta"
    assert "between rows" in finding.detail


def test_limits_are_judged_as_always(scenario, table):
    report = verify(changed(table, 0, 401, rate_rad_s=np.deg2rad(4.0)), scenario)
    assert only(report, "rate").axis == "alpha"
    only(report, "motion")


def test_axes_that_are_not_the_platforms_are_found(table):
    other = BenchMotionTarget(axes={"gamma": ConstantRate(rate_deg_s=0.0)})
    report = verify(table, scenario_of(target=other))
    assert "alpha, beta" in only(report, "motion").detail
    assert report.sessions == ()


def test_no_orbit_is_asked_for(table):
    class NoOrbit:
        def ephemeris(self, start_utc, stop_utc):
            raise AssertionError("a bench needs no orbit")

    assert verify(table, scenario_of(orbit=NoOrbit(), target=TARGET)).passed
