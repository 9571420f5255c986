"""Clock, lag, biases, noise and wander put into a body's telemetry are found.

Of other_body.py's flights, which know the table's columns alone.
"""

from functools import cache

import numpy as np
import other_body
import pytest
from other_body import ARCSEC, Flown, written
from planner_values import compare, plan_of

SEEDS = range(4)
BIAS_ARCSEC = (20.0, -10.0, 5.0)
GYRO_ARCSEC_S = (3.0, -2.0, 1.0)
ORDERS = [
    f"{letters} of {frames}"
    for letters in ("xyzw", "wxyz")
    for frames in ("eci_from_body", "body_from_eci")
]


@pytest.fixture(scope="module")
def plan():
    return plan_of(other_body.body_request())


@pytest.fixture(scope="module")
def columns(plan):
    table = plan.table
    return {"t_s": table.t_s} | {channel.name: told for channel, told in table.columns}


def flown(**changes):
    return Flown(bias_arcsec=BIAS_ARCSEC, gyro_bias_arcsec_s=GYRO_ARCSEC_S, **changes)


@pytest.fixture(scope="module")
def comparisons(plan, columns):
    """By the wander: of four flights each, which several tests ask."""
    return cache(
        lambda wander_arcsec: [
            compare(plan, written(columns, flown(wander_arcsec=wander_arcsec), seed))
            for seed in SEEDS
        ]
    )


def off(estimate, true, scale=1.0):
    """In sigmas."""
    return (estimate.value / scale - true) / (estimate.sigma / scale)


@pytest.mark.parametrize("order", ORDERS)
def test_the_order_of_the_parts_is_told_by_the_motion(plan, columns, order):
    found = compare(plan, written(columns, flown(), 1, order))
    letters, _, frames = order.split()
    told = {
        column.name: column.axis for column in found.samples.columns if column.kind == "attitude"
    }
    assert told == {f"q_{k + 1}": f"q_{frames}_{letter}" for k, letter in enumerate(letters)}
    assert abs(off(found.alignment.common_offset_s, 0.37)) < 4.0
    for axis in found.axes:
        assert axis.followed.basis == "angles"
        assert axis.oscillations == axis.stick_slip == axis.limits_exceeded == ()
    assert found.notes == ()


def test_names_of_the_table_that_hold_another_order_are_told(plan, columns):
    content = written(columns, flown(), 1, "wxyz of eci_from_body").decode()
    for k, letter in enumerate("xyzw"):
        content = content.replace(f"q_{k + 1},", f"q_eci_from_body_{letter},", 1)
    [note] = compare(plan, content.encode()).notes
    assert "q_eci_from_body_w, q_eci_from_body_x" in note
    assert "not as they are named" in note


@pytest.mark.parametrize("wander_arcsec", [0.0, 10.0])
def test_clock_and_biases_are_found_within_their_sigmas(comparisons, wander_arcsec):
    all_off = []
    for found in comparisons(wander_arcsec):
        alignment = found.alignment
        all_off += [off(alignment.common_offset_s, 0.37), off(alignment.drift, 20e-6)]
        for axis, bias, gyro in zip(found.axes, BIAS_ARCSEC, GYRO_ARCSEC_S, strict=True):
            all_off.append(off(axis.bias, bias, ARCSEC))
            all_off.append(off(axis.rate_bias_rad_s, gyro, ARCSEC))
            all_off.append(off(axis.rate_gain, 1.0))
            assert axis.gain is None
    # Few of a thousand normal errors are beyond 3 sigma; sigmas of few slews are known to a fifth.
    assert np.mean(np.abs(all_off) < 3.0) > 0.97
    assert np.sqrt(np.mean(np.square(all_off))) < 1.35


def test_the_axis_that_is_late_is_told(plan, columns):
    """By 50 ms, as a body with much inertia about one axis and a loop of one bandwidth."""
    lags, offsets = [], []
    for seed in SEEDS:
        found = compare(plan, written(columns, flown(late_s=(0.0, 0.05, 0.0)), seed))
        late = found.axes[1].lag
        lags.append(off(late, 0.05))
        offsets.append(off(found.alignment.offset_s, 0.37))
        assert late.value > 20.0 * late.sigma
        assert found.alignment.common_offset_s is None
    # The earliest of two that are on time is taken, by chance up to a sigma too early.
    assert np.max(np.abs(lags)) < 4.0
    assert np.max(np.abs(offsets)) < 4.0


def test_wander_and_noise_are_told_apart(comparisons):
    found_off = []
    for found in comparisons(10.0):
        for axis in found.axes:
            found_off.append(off(axis.noise_rad, 5.0, ARCSEC))
            found_off.append(off(axis.wander_rad, 10.0, ARCSEC))
            found_off.append(off(axis.wander_half_life_s, 5.0))
            assert axis.oscillations == ()
    assert np.mean(np.abs(found_off) < 3.0) > 0.95
    assert np.sqrt(np.mean(np.square(found_off))) < 1.5


def test_noise_alone_is_no_wander(comparisons):
    for axis in comparisons(0.0)[2].axes:
        assert axis.wander_rad is None
        assert abs(off(axis.noise_rad, 5.0, ARCSEC)) < 4.0


def test_the_next_plan_learns_how_the_attitude_wanders(plan, columns):
    found = compare(plan, written(columns, flown(wander_arcsec=30.0), 3))
    learnt = found.sensors.found(found, ())
    names = [one.name for one in learnt.parameters]
    assert names == ["knowledge.control_sigma_arcsec", "knowledge.correlation_s"]
    for one, true in zip(learnt.parameters, (30.0, 5.0), strict=True):
        assert abs(one.found - true) < 3.0 * one.sigma
        assert one.planned == 10.0
    knowledge = learnt.platform.knowledge
    assert knowledge.control_sigma_arcsec == learnt.parameters[0].found
    assert knowledge.correlation_s == learnt.parameters[1].found


def test_a_swing_is_told_beside_a_wander(plan, columns):
    """Of 6 arcsec at 0.8 Hz for 40 s, while the attitude wanders by 3."""
    content = written(columns, Flown(wander_arcsec=3.0, noise_arcsec=2.0, rate_hz=10.0), 4)
    lines = content.decode().splitlines()
    rows = np.array([line.split(",") for line in lines[1:]], dtype=float)
    swings = (rows[:, 0] > 60.0) & (rows[:, 0] < 100.0)
    turn = np.zeros((len(rows), 3))
    turn[swings, 2] = 6.0 * ARCSEC * np.sin(2.0 * np.pi * 0.8 * rows[swings, 0])
    attitude = other_body.Rotation.from_quat(rows[:, 1:5]) * other_body.Rotation.from_rotvec(turn)
    rows[:, 1:5] = attitude.as_quat()
    told = [lines[0], *(",".join(f"{value:.12f}" for value in row) for row in rows)]
    found = compare(plan, "\n".join(told).encode())
    [swing] = found.axes[2].oscillations
    assert swing.frequency_hz == pytest.approx(0.8, abs=0.01)
    assert swing.amplitude_rad == pytest.approx(6.0 * ARCSEC, rel=0.15)
    assert found.axes[0].oscillations == found.axes[1].oscillations == ()


@pytest.mark.parametrize("sent", ["attitude", "rates"])
def test_either_sensor_alone_tells_the_clock(plan, columns, sent):
    rows = [line.split(",") for line in written(columns, flown(), 5).decode().splitlines()]
    part = slice(1, 5) if sent == "attitude" else slice(5, 8)
    content = "\n".join(",".join([row[0], *row[part]]) for row in rows).encode()
    found = compare(plan, content)
    assert abs(off(found.alignment.common_offset_s, 0.37)) < 4.0
    assert {axis.followed.basis for axis in found.axes} == {
        "angles" if sent == "attitude" else "rates"
    }
    assert all(axis.rate_gain is None for axis in found.axes)


def test_damaged_attitudes_are_left_out(plan, columns):
    """A wire that lost a part, a row twice, spikes, and rows in any order."""
    lines = written(columns, flown(), 6).decode().splitlines()
    rows = [line.split(",") for line in lines[1:]]
    for row in rows[100:104]:
        row[3] = ""
    for row in rows[200:205]:
        row[2] = "0.9"
    rows[300][4] = str(float(rows[300][4]) - 2e-3)
    rows.append(rows[400])
    rows[500], rows[520] = rows[520], rows[500]
    found = compare(plan, "\n".join([lines[0], *map(",".join, rows)]).encode())
    assert abs(off(found.alignment.common_offset_s, 0.37)) < 4.0
    assert found.samples.dropped["repeated"] == 1
    assert found.samples.dropped["outlier"] == 1
    assert "5 rows of the attitude are no unit quaternions" in found.notes[0]
