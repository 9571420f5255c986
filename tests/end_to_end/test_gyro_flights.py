"""A plan of a body with gyros flown closed loop: sensors, on-board laws, structure, gimbals."""

import dataclasses
import math

import numpy as np
import other_body
import pytest
from planner_values import plan_of
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from app.answers.members import to_members
from app.work.flights import flights_found, packed_outcomes, unpacked_outcomes
from planner.inflight.flights.nominal import flights_as_planned, nominal_session
from planner.inflight.flights.request import FlightsRequest
from planner.inflight.flights.runs import fly_runs
from planner.inflight.flights.scene import session_scenes
from planner.output.view import view_plan
from planner.world.platforms.gyros import GyroSet, GyroTurns, ScissoredPairs

STEADY_DEG_S = 0.001  # Platonov, Sumarokov 2019
RUNS = 6


def planned(platform="agile-cmg"):
    """One city, 20 s, while it stands within 45 deg of nadir; the body turns onto it as fast as it
    may."""
    request = other_body.body_request(sessions=1)
    [session] = request["sessions"]
    session["start"], session["stop"] = "2015-05-10T10:35:50Z", "2015-05-10T10:36:10Z"
    request |= {"platform": platform, "slew": {"objective": "minimum_time"}}
    return plan_of(request)


@pytest.fixture(scope="module")
def plan():
    return planned()


@pytest.fixture(scope="module")
def scene(plan):
    [found] = session_scenes(plan)
    return found


@pytest.fixture(scope="module")
def runs(scene):
    return fly_runs([scene], seed=1, first=0, count=RUNS)


def test_the_camera_is_steady_as_planned(scene):
    nominal = nominal_session(scene, None)
    assert nominal.held == nominal.sharp == nominal.frames
    assert nominal.gyros.steady == 1.0
    assert 0.0 < np.degrees(nominal.gyros.rate_error_rad_s.max()) < STEADY_DEG_S
    shown = np.degrees(np.abs(nominal.rate_error_rad_s))
    assert shown.shape == (len(nominal.t_s), 3)
    assert (shown <= np.degrees(nominal.gyros.rate_error_rad_s) + 1e-12).all()
    assert nominal.gyros.gimbal_rate_max_rad_s < math.radians(57.3)
    assert nominal.gyros.momentum_max_n_m_s < 60.0


def test_every_spacecraft_that_may_be_is_steady(plan, scene, runs):
    [outcomes] = runs
    assert outcomes.gyro_numbers.shape == (RUNS, 11)
    assert outcomes.holds.all()
    told = told_of(plan, scene, runs)["sessions"][0]
    assert told["gyros"]["steady"] == 1.0
    assert max(told["gyros"]["rate_error_deg_s"]) < STEADY_DEG_S
    worst = np.degrees(outcomes.gyro_numbers[:, 1:4].max(axis=0))
    assert told["gyros"]["rate_error_deg_s"] == pytest.approx(worst, abs=1e-9)
    assert told["nominal"]["gyros"]["pointing_error_deg"] < told["gyros"]["pointing_error_deg"]


def told_of(plan, scene, runs):
    """As an answer tells it, the runs packed and read again."""
    head = to_members(flights_as_planned(plan, [scene], "1", FlightsRequest(runs=6, seed=1)))
    return flights_found(head, [unpacked_outcomes(packed_outcomes(runs, 0))])


def test_attitude_is_what_the_flown_rate_turns_it_to(scene):
    """By SciPy: the table's rate and the error of the rate, integrated over the session."""
    seeds = dict.fromkeys(scene.flyer.flown_causes, 5)
    scene.flyer.platform = dataclasses.replace(
        scene.flyer.platform,
        knowledge=dataclasses.replace(
            scene.flyer.platform.knowledge, sigma_arcsec=0.0, jitter_arcsec=0.0
        ),
    )
    flown = scene.flyer.fly(scene.table, scene.from_s, 0, seeds)
    start_s = scene.instants.t_s[0] - scene.from_s
    t_s = start_s + np.arange(4001) * 0.005
    wanted = RotationSpline(scene.table.t_s, Rotation.from_quat(scene.table.position))
    position, turn_rad = flown.at(t_s)
    true = Rotation.from_rotvec(turn_rad) * Rotation.from_quat(position)
    error = CubicSpline(t_s, flown.rate_errors_rad_s(t_s))
    middle_s = t_s[:-1] + 0.0025
    turned = true[0]
    for turn in Rotation.from_rotvec(0.005 * (wanted(middle_s, 1) + error(middle_s))):
        turned *= turn
    off_arcsec = 3600.0 * np.degrees((true[-1].inv() * turned).magnitude())
    moved_arcsec = 3600.0 * np.degrees(np.linalg.norm(turn_rad[-1] - turn_rad[0]))
    assert off_arcsec < 0.02  # of rates 0.005 s apart
    assert moved_arcsec > 10.0 * off_arcsec


def test_a_small_body_with_products_of_inertia_is_steady():
    """Its structure, sensors and gains are the paper's by share of its own inertia."""
    gyros = GyroSet(
        array=ScissoredPairs(rotor_n_m_s=3.0, gimbal_rate_max_deg_s=57.3),
        turns=GyroTurns(
            rate_max_deg_s=1.5,
            torque_max_n_m=0.8,
            torque_rate_max_n_m_s=2.0,
            momentum_max_n_m_s=3.0,
            settle_s=3.0,
        ),
    )
    inertia = [[40.0, 1.5, -1.0], [1.5, 30.0, 0.8], [-1.0, 0.8, 42.0]]
    platform = other_body.PLATFORM | {"gyros": dataclasses.asdict(gyros), "inertia_kg_m2": inertia}
    platform.pop("agility", None)
    [scene] = session_scenes(planned(platform))
    nominal = nominal_session(scene, None)
    assert nominal.gyros.steady == 1.0
    [outcomes] = fly_runs([scene], seed=0, first=0, count=4)
    assert np.degrees(outcomes.gyro_numbers[:, 1:4].max()) < STEADY_DEG_S


def test_the_view_shows_the_table_s_gimbals_and_their_momentum(plan):
    shown = view_plan(plan, 0.2, 1.0).gyros
    assert np.hstack([shown.gimbal_rad, shown.gimbal_rate_rad_s]) == pytest.approx(
        plan.table.extra_rad
    )
    s, c = np.sin(shown.gimbal_rad).T, np.cos(shown.gimbal_rad).T
    held = 60.0 * np.stack([s[2] + s[3], s[0] + s[1], c.sum(axis=0)], axis=1)
    assert shown.momentum_n_m_s == pytest.approx(held, abs=1e-9)
    assert (shown.momentum_max_n_m_s, math.degrees(shown.gimbal_rate_max_rad_s)) == (
        60.0,
        pytest.approx(57.3),
    )
