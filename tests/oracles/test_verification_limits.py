"""The judge finds each limit that a table breaks, on its axis and at its time."""

import dataclasses
from datetime import timedelta

import numpy as np
import pytest
from judged_tables import EPOCH_UTC, changed, only, scenario_of
from scipy.interpolate import CubicHermiteSpline

from planner.base.commands import CommandTable, axis_channels
from planner.verification import verify
from planner.world.platforms import ISS_HRC
from planner.world.scenario import SlewOptions


@pytest.mark.parametrize(("column", "axis"), [(0, "alpha"), (1, "beta")])
def test_a_rate_spike_is_found_on_its_axis_at_its_row(scenario, table, column, axis):
    spike_rad_s = np.deg2rad(3.2) - table.rate_rad_s[100, column]
    report = verify(changed(table, column, 100, rate_rad_s=spike_rad_s), scenario)
    finding = only(report, "rate")
    assert (finding.axis, finding.t_s) == (axis, pytest.approx(20.0, abs=0.02))
    # and so are the acceleration, jerk and step of acceleration that the spike needs
    assert {found.limit for found in report.findings if found.axis == axis} == {
        "rate", "acceleration", "jerk", "acceleration_jump",
    }  # fmt: skip


def with_limits(axis, **limits):
    return dataclasses.replace(
        ISS_HRC, **{f"{axis}_limits": dataclasses.replace(ISS_HRC.inner_limits, **limits)}
    )


def test_a_stop_passed_only_between_rows_is_found(table):
    rows = table.position[:, 1]
    flown = CubicHermiteSpline(table.t_s, rows, table.rate_rad_s[:, 1])
    turning_s = flown.derivative().roots(extrapolate=False)
    bottom_rad = flown(turning_s).min()
    stop_rad = float(0.5 * (bottom_rad + rows.min()))
    assert bottom_rad < stop_rad < rows.min()
    platform = with_limits("inner", angle_min_rad=stop_rad, angle_max_rad=stop_rad + 0.4)
    report = verify(table, scenario_of(platform=platform))
    margin = next(m for m in report.limits if (m.axis, m.kind) == ("beta", "angle_min"))
    assert margin.extreme == pytest.approx(bottom_rad, abs=1e-14)
    assert margin.margin == pytest.approx(bottom_rad - stop_rad, abs=1e-14)
    assert margin.t_s == pytest.approx(turning_s[np.argmin(flown(turning_s))], abs=1e-6)


def test_a_stop_well_passed_between_rows_fails_the_table():
    # 0.8 deg/s2 between two rows at equal angle: 0.004 deg above them, over a stop in between
    scenario = scenario_of(
        platform=with_limits("outer", angle_max_rad=np.deg2rad(10.002), angle_min_rad=-1.0)
    )
    rate = np.deg2rad(0.08)
    table = CommandTable(
        epoch_utc=EPOCH_UTC,
        channels=axis_channels(("alpha", "beta")),
        position=np.deg2rad([[10.0, 0.0], [10.0, 0.0]]),
        rate_rad_s=np.array([[rate, 0.0], [-rate, 0.0]]),
    )
    report = verify(table, scenario)
    finding = only(report, "angle_max")
    assert finding.axis == "alpha"
    assert finding.t_s == pytest.approx(0.1)
    assert finding.at_utc == EPOCH_UTC + timedelta(seconds=0.1)
    margin = next(m for m in report.limits if (m.axis, m.kind) == ("alpha", "angle_max"))
    assert np.rad2deg(margin.extreme) == pytest.approx(10.004, abs=1e-9)
    assert np.rad2deg(margin.margin) == pytest.approx(-0.002, abs=1e-9)


@pytest.mark.parametrize(("past_rad", "passes"), [(4.9e-7, True), (5.1e-7, False)])
def test_a_stop_may_be_passed_by_rounding_only(past_rad, passes):
    # a millionth of half the travel, 0.5 rad, even though the stop itself is at zero
    scenario = scenario_of(platform=with_limits("inner", angle_min_rad=0.0, angle_max_rad=1.0))
    table = CommandTable(
        epoch_utc=EPOCH_UTC,
        channels=axis_channels(("alpha", "beta")),
        position=np.full((3, 2), -past_rad),
        rate_rad_s=np.zeros((3, 2)),
    )
    report = verify(table, scenario)
    assert passes == (not [f for f in report.findings if f.limit == "angle_min"])


def test_a_start_with_another_acceleration_than_the_platforms_is_found(scenario, table):
    # 0.2 deg/s2 would have to vanish in no time; jerk within 1 deg/s3 explains 0.12 deg/s2
    moving = dataclasses.replace(
        scenario.initial_state, accelerations_deg_s2={"alpha": 0.0, "beta": 0.2}
    )
    report = verify(table, dataclasses.replace(scenario, initial_state=moving))
    finding = only(report, "acceleration_jump")
    assert (finding.axis, finding.t_s) == ("beta", 0.0)


def test_the_scenarios_own_jerk_limit_counts(scenario, table):
    reports = {
        jerk: verify(table, dataclasses.replace(scenario, slew=SlewOptions(jerk_max_deg_s3=jerk)))
        for jerk in (0.5, 0.01)
    }
    assert reports[0.5].passed
    assert only(reports[0.01], "jerk").axis == "alpha"
    for jerk, report in reports.items():
        values = [m.limit for m in report.limits if m.kind == "jerk"]
        assert values == pytest.approx([np.deg2rad(jerk)] * 2)


def test_slow_stretches_are_told_apart_by_axis(scenario, table):
    stretches = verify(table, scenario).sessions[0].slow_stretches
    rate_min = ISS_HRC.inner_limits.rate_min_rad_s
    assert stretches
    for stretch in stretches:
        rates = np.abs(table.rate_rad_s[:, table.dof_names.index(stretch.axis)])
        inside = (np.arange(len(rates)) / 5.0 > stretch.start_s) & (
            np.arange(len(rates)) / 5.0 < stretch.stop_s
        )
        assert np.all(rates[inside] < rate_min)
        assert (stretch.start_utc - EPOCH_UTC).total_seconds() == pytest.approx(
            stretch.start_s, abs=1e-6
        )
