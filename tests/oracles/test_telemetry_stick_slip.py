"""Sticking of 10 arcsec is found at the rates that telemetry comes at, and nothing else for it.

The platform is that of other_platform.py: friction of 0.3 deg/s2 that lets go at 0.42 against a
loop of 1 Hz, so that it slips by 9 arcsec and more, while both axes creep for 100 s.
"""

import copy
from functools import cache

import numpy as np
import other_platform
import pytest
from planner_values import compare, plan_of

from app.requests.examples import LAS_VEGAS
from planner.output.export.csv import table_csv

ARCSEC = np.radians(1.0 / 3600.0)
CREEP_ARCSEC_S = {"alpha": 8.0, "beta": -4.0}
START_S, STOP_S = 60.0, 160.0
ROUGH = other_platform.Drive(bandwidth_hz=1.0, friction_deg_s2=0.3, break_away=1.4)


@cache
def creeping():
    request = copy.deepcopy(LAS_VEGAS)
    axes = {
        name: {"kind": "constant_rate", "angle_deg": 10.0, "rate_deg_s": rate / 3600.0}
        for name, rate in CREEP_ARCSEC_S.items()
    }
    request["sessions"] = [
        {
            "target": {"mode": "test_motion", "axes": axes},
            "start": "2015-02-27T17:35:00Z",
            "stop": "2015-02-27T17:36:40Z",
        }
    ]
    return plan_of(request)


@cache
def flown(folder, friction):
    """Times, and the angles of both axes, arcsec; every 2 ms."""
    path = folder / "table.csv"
    path.write_text(table_csv(creeping().table))
    times, motion = other_platform.read_table(path)
    drive = ROUGH if friction else other_platform.Drive(bandwidth_hz=1.0)
    flights = [np.array(other_platform.fly(times, *columns, drive)) for columns in motion.values()]
    return flights[0][0], [3600.0 * one[1] for one in flights]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("creeping")


def compared(t_s, angles_arcsec):
    rows = zip(t_s, *(one / 3600.0 for one in angles_arcsec), strict=True)
    text = "\n".join(f"{t:.6f},{alpha:.9f},{beta:.9f}" for t, alpha, beta in rows)
    return compare(creeping(), f"t_s,alpha_deg,beta_deg\n{text}".encode())


def measured(flight, rate_hz, noise_arcsec, seed=1):
    fine_s, angles_arcsec = flight
    t_s = np.arange(0.0, fine_s[-1], 1.0 / rate_hz)
    chance = np.random.default_rng(seed)
    return t_s, [
        np.interp(t_s, fine_s, one) + noise_arcsec * chance.standard_normal(len(t_s))
        for one in angles_arcsec
    ]


@pytest.mark.parametrize(
    ("rate_hz", "noise_arcsec", "names"),
    [(5.0, 0.3, ("alpha", "beta")), (5.0, 2.0, ("beta",)), (15.0, 0.3, ("alpha", "beta"))],
)
def test_sticking_is_told_from_angles_of_common_rates(folder, rate_hz, noise_arcsec, names):
    """With 2 arcsec alpha's slips, 1.8 s apart and a third of that long, look like a swing."""
    found = compared(*measured(flown(folder, friction=True), rate_hz, noise_arcsec))
    for axis in [axis for axis in found.axes if axis.name in names]:
        creeps = [one for one in axis.stick_slip if one.stop_s > START_S and one.start_s < STOP_S]
        told_s = sum(min(one.stop_s, STOP_S) - max(one.start_s, START_S) for one in creeps)
        assert told_s > 0.5 * (STOP_S - START_S)
        longest = max(creeps, key=lambda one: one.stop_s - one.start_s)
        creep_rad_s = abs(CREEP_ARCSEC_S[axis.name]) * ARCSEC
        assert 0.9 * creep_rad_s < longest.rate_rad_s < 30.0 * ARCSEC  # as it slows down to creep
        assert 5.0 * ARCSEC < longest.slip_rad < 25.0 * ARCSEC
        apart_rad = (longest.stop_s - longest.start_s) * creep_rad_s / longest.slips
        assert 5.0 * ARCSEC < apart_rad < 25.0 * ARCSEC


def quantised(angle_arcsec, step_arcsec):
    return step_arcsec * np.round(angle_arcsec / step_arcsec)


def wandering(count, seed):
    """Noise that goes together for a second at 15 Hz, 3 arcsec."""
    chance, past = np.random.default_rng(seed), np.exp(-1.0 / 15.0)
    steps = chance.standard_normal(count) * 3.0 * np.sqrt(1.0 - past**2)
    errors = np.zeros(count)
    for k in range(1, count):
        errors[k] = past * errors[k - 1] + steps[k]
    return errors


SMOOTH = {
    "clean": lambda t_s, one: one,
    "steps of 10 arcsec": lambda t_s, one: quantised(one, 10.0),
    "steps and noise": lambda t_s, one: quantised(
        one + np.random.default_rng(4).normal(0.0, 2.0, len(one)), 5.0
    ),
    "a swing": lambda t_s, one: one + 6.0 * np.sin(2.0 * np.pi * 0.35 * t_s),
    "wandering": lambda t_s, one: one + wandering(len(one), 5),
    "late": lambda t_s, one: np.interp(t_s - 0.2, t_s, one),
}


@pytest.mark.parametrize(("name", "noise_arcsec"), [*zip(SMOOTH, (2.0, 0.0) * 3, strict=True)])
def test_what_does_not_stick_is_not_told_to(folder, name, noise_arcsec):
    t_s, angles = measured(flown(folder, friction=False), 15.0, noise_arcsec)
    found = compared(t_s, [SMOOTH[name](t_s, one) for one in angles])
    assert [axis.stick_slip for axis in found.axes] == [(), ()]
