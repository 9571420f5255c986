"""Plans of a body that gyros turn: torque, momentum and gimbal rates by an integration of our own.

Nothing of the planner's geometry is used: the rows are read as they are told, SciPy's spline of
rotations goes through them, gravity's torque is integrated from the start, and the gimbals of four
gyros at +-60 and +-120 degrees are turned by the least rates that change their momentum so.
"""

import dataclasses
import io
import math
from datetime import timedelta

import numpy as np
import other_body
import pytest
from planner_values import plan_of
from scipy.integrate import cumulative_trapezoid
from scipy.io import netcdf_file
from scipy.spatial.transform import Rotation, RotationSpline

from planner.base.errors import InfeasibleSlew
from planner.output.export.csv import table_csv
from planner.output.export.netcdf import write_netcdf
from planner.planning.sessions.pipeline import make_plan
from planner.planning.sessions.platforms import body
from planner.world.frames.time_scales import Instants
from planner.world.platforms.agile_cmg import AGILE_CMG

INERTIA_KG_M2 = np.array([800.0, 500.0, 800.0])
ROTOR_N_M_S, STEP_S = 60.0, 0.005
MU_M3_S2 = 3.986004418e14
TIMES = (("10:35:40", "10:37:00"), ("10:41:28", "10:42:20"), ("10:44:08", "10:44:50"))


def planned(**changes):
    """The three cities of the example while they stand within 45 deg of nadir."""
    request = other_body.body_request(sessions=3)
    for one, (start, stop) in zip(request["sessions"], TIMES, strict=True):
        one["start"], one["stop"] = f"2015-05-10T{start}Z", f"2015-05-10T{stop}Z"
    request |= {"platform": "agile-cmg", "final_state": "idle"} | changes
    return plan_of(request)


@pytest.fixture(scope="module")
def plan():
    return planned(slew={"objective": "minimum_time"})


def test_three_cities_are_imaged_by_the_platform_s_name(plan):
    assert plan.verification.passed
    assert [one.session for one in plan.segments if one.kind == "track"] == [0, 1, 2]
    assert plan.scenario.platform.name == "agile-cmg"


@pytest.fixture(scope="module")
def gentle():
    return planned()


def test_a_gentle_plan_asks_little_of_the_gyros(gentle):
    assert gentle.verification.passed
    _, torque = gyro_motion(gentle)
    assert np.linalg.norm(torque, axis=1).max() < 3.0


def test_momentum_that_gravity_adds_has_room_or_is_refused(gentle):
    """A start on the edge: the same motion, begun with a little less and a little more than what
    leaves 60 N m s for the gyros at the largest rate about all three axes."""
    q_eci_from_body, total, _, _ = body_motion(gentle)
    total_eci = q_eci_from_body.apply(total)
    added = total_eci[-1] - total_eci[0]
    assert np.linalg.norm(added) > 0.01
    along = added / np.linalg.norm(added)
    most = 60.0 - math.radians(1.58) * np.linalg.norm(INERTIA_KG_M2)

    def begun_with(size):
        start = q_eci_from_body[0].inv().apply(size * along)
        gyros = dataclasses.replace(AGILE_CMG.gyros, start_n_m_s=tuple(start.tolist()))
        platform = dataclasses.replace(AGILE_CMG, gyros=gyros)
        return make_plan(dataclasses.replace(gentle.scenario, platform=platform))

    across = np.linalg.norm(np.cross(total_eci, along), axis=1)
    edge = float((np.sqrt(most**2 - across**2) - total_eci @ along).min())
    assert edge < most
    assert begun_with(edge - 1e-3).verification.passed
    with pytest.raises(InfeasibleSlew, match="unload the gyros first") as refused:
        begun_with(edge + 1e-3)
    assert (refused.value.field, refused.value.limit) == ("platform.gyros.start_n_m_s", "momentum")


def gyro_motion(plan):
    """Every 5 ms: what the gyros hold and the torque they give, in body axes, (n, 3) each."""
    _, total, omega, torque = body_motion(plan)
    return total - INERTIA_KG_M2 * omega, torque


def body_motion(plan):
    """Every 5 ms: the attitude, and in body axes what body and gyros hold together, the rate and
    the gyros' torque, (n, 3) each."""
    told = {channel.name: value for channel, value in plan.table.columns}
    q = np.transpose([told[f"q_eci_from_body_{part}"] for part in "xyzw"])
    spline = RotationSpline(plan.table.t_s, Rotation.from_quat(q))
    t_s = np.arange(round(plan.table.t_s[-1] / STEP_S) + 1) * STEP_S
    q_eci_from_body, omega, alpha = spline(t_s), spline(t_s, 1), spline(t_s, 2)
    stop = plan.table.epoch_utc + timedelta(seconds=float(plan.table.t_s[-1]) + 1.0)
    orbit = plan.scenario.orbit.ephemeris(plan.table.epoch_utc, stop)
    r_eci_m = orbit.states(Instants(plan.table.epoch_utc, plan.table.t_s)).r_sat_eci_m
    r_eci_m = np.stack([np.interp(t_s, plan.table.t_s, part) for part in r_eci_m.T], axis=1)
    r_m = np.linalg.norm(r_eci_m, axis=1, keepdims=True)
    up = q_eci_from_body.inv().apply(r_eci_m / r_m)
    gravity_n_m = 3.0 * MU_M3_S2 / r_m**3 * np.cross(up, INERTIA_KG_M2 * up)
    impulse = cumulative_trapezoid(q_eci_from_body.apply(gravity_n_m), dx=STEP_S, axis=0, initial=0)
    rate_deg_s = [told[f"omega_body_deg_s_{part}"][0] for part in "xyz"]  # a spline's ends are free
    begun = q_eci_from_body[0].apply(INERTIA_KG_M2 * np.radians(rate_deg_s))
    total = q_eci_from_body.inv().apply(begun + impulse)
    torque = INERTIA_KG_M2 * alpha + np.cross(omega, total) - gravity_n_m
    return q_eci_from_body, total, omega, torque


def test_gyros_give_torque_and_hold_momentum_within_their_limits(plan):
    held, torque = gyro_motion(plan)
    size = np.linalg.norm(torque, axis=1)
    assert size.max() <= 15.0
    assert size.max() > 13.0  # the time is least: what is always there, 14, is used
    assert np.linalg.norm(held, axis=1).max() <= 60.0


@pytest.mark.parametrize("name", ["gentle", "plan"])
def test_the_table_tells_gimbals_that_hold_what_the_gyros_must(name, request):
    """By the table's text as it is downloaded; rates are held until the next row."""
    flown = request.getfixturevalue(name)
    text = "".join(table_csv(flown.table))
    told = np.genfromtxt(io.StringIO(text), delimiter=",", names=True, dtype=None, encoding=None)
    angle, rate = (
        np.radians([told[f"gimbal_{kind}_{number}"] for number in (1, 2, 3, 4)])
        for kind in ("deg", "rate_deg_s")
    )
    assert angle[:, 1:] == pytest.approx(angle[:, :-1] + 0.2 * rate[:, :-1], abs=1e-10)
    assert 0.0 < np.degrees(np.abs(rate).max()) < 57.3
    s, c = np.sin(angle), np.cos(angle)
    held = ROTOR_N_M_S * np.stack([s[2] + s[3], s[0] + s[1], c.sum(axis=0)], axis=1)
    wanted, _ = gyro_motion(flown)
    inner = slice(5, -5)  # the spline's ends are free
    assert np.abs(held - wanted[:: round(0.2 / STEP_S)])[inner].max() < 0.03


def test_gimbals_that_fall_behind_the_turn_are_refused(gentle, monkeypatch):
    """By motion without torque that takes all the rate they have."""
    monkeypatch.setattr(body, "OPTIONS", dataclasses.replace(body.OPTIONS, null_gain_rad_s=100.0))
    with pytest.raises(InfeasibleSlew, match=r"none faster than 57.3 deg/s, are .* behind") as told:
        make_plan(gentle.scenario)
    assert (told.value.limit, told.value.field) == ("torque", "platform.gyros.turns.torque_max_n_m")


def test_netcdf_tells_the_gimbals_in_words(gentle):
    with netcdf_file(io.BytesIO(write_netcdf(gentle, gentle.table.epoch_utc)), mmap=False) as file:
        angle, rate = (file.variables[f"gimbal_{kind}_3"] for kind in ("deg", "rate_deg_s"))
        assert (angle.units, angle.long_name) == (b"degree", b"angle of gimbal 3")
        assert rate.long_name == b"rate, held until the next row, of gimbal 3"
        assert angle[:] == pytest.approx(np.degrees(gentle.table.extra_rad[:, 2]), abs=1e-9)
        assert rate[:] == pytest.approx(np.degrees(gentle.table.extra_rad[:, 6]), abs=1e-9)


def test_gimbals_turn_within_their_rate(plan):
    """H = h [s3 + s4, s1 + s2, c1 + c2 + c3 + c4]: Platonov, Sumarokov 2019, eq. 1."""
    held, torque = gyro_motion(plan)
    angle = np.radians([60.0, -60.0, 120.0, -120.0])
    most = 0.0
    for wanted, change in zip(held[1:], -torque[1:], strict=True):
        c, s = np.cos(angle), np.sin(angle)
        d = np.array([[0.0, 0.0, c[2], c[3]], [c[0], c[1], 0.0, 0.0], -s])
        have = ROTOR_N_M_S * np.array([s[2] + s[3], s[0] + s[1], c.sum()])
        # What a step of Euler's leaves is made good over 0.1 s.
        need = change + (wanted - have) / 0.1
        rate = d.T @ np.linalg.solve(d @ d.T, need / ROTOR_N_M_S)
        most = max(most, float(np.abs(rate).max()))
        angle = angle + STEP_S * rate
    assert np.linalg.norm(have - wanted) < 0.1
    assert 1.0 < math.degrees(most) < 57.3
