"""The camera shows what the paper says of it, and chance what statisticians published."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest

from planner.inflight.flights.contributors import contributors
from planner.inflight.flights.nominal import nominal_session
from planner.inflight.flights.outcomes import RunOutcomes
from planner.inflight.flights.proportion import Proportion
from planner.inflight.flights.request import MovingObject
from planner.inflight.flights.scene import session_scenes
from planner.inflight.simulation.platforms.registry import FLYERS
from planner.planning.sessions.pipeline import make_plan
from planner.world.attitude import LvlhAttitude
from planner.world.orbits import StateVectorOrbit
from planner.world.platforms import ISS_HRC
from planner.world.scenario import InitialState, Scenario, Session
from planner.world.targets import GroundTarget

OVERHEAD = datetime(2015, 5, 20, 15, 0, tzinfo=UTC)
CAUSES = FLYERS["two_axis"].causes
EARTH_KM, HEIGHT_KM = 6378.137, 350.0
CAR = MovingObject(speed_m_s=75.0 / 3.6, course_deg=90.0, interval_s=10.0)


@pytest.fixture(scope="module")
def pass_at_350_km():
    """Over a place on the equator, 0.3 deg beside the track: no axis runs away overhead."""
    orbit = StateVectorOrbit(
        frame="ITRF",
        epoch=OVERHEAD,
        position_km=(EARTH_KM + HEIGHT_KM, 0.0, 0.0),
        velocity_km_s=(0.0, 4.4, 5.9),
    )
    target = GroundTarget(latitude_deg=0.2, longitude_deg=-0.2)
    start, stop = OVERHEAD - timedelta(seconds=20), OVERHEAD + timedelta(seconds=25)
    plan = make_plan(
        Scenario(
            platform=ISS_HRC,
            orbit=orbit,
            attitude=LvlhAttitude(),
            initial_state=InitialState(
                epoch=OVERHEAD - timedelta(seconds=200), angles_deg={"alpha": 0.0, "beta": 0.0}
            ),
            sessions=(Session(target=target, start=start, stop=stop),),
        )
    )
    [scene] = session_scenes(plan)
    return nominal_session(scene, CAR)


def test_a_pixel_is_1_15_m_from_350_km(pass_at_350_km):
    """Sumarokov 2016, p. 85; 1.5 %: the place lies up to 40 km beside the nadir."""
    samples_m = pass_at_350_km.ground_sample_across_m
    assert samples_m.min() == pytest.approx(1.15, rel=0.015)
    along_m = pass_at_350_km.ground_sample_along_m
    assert along_m[samples_m.argmin()] == pytest.approx(1.15, rel=0.03)


def test_a_car_at_75_km_h_moves_by_208_m_and_181_pixels_in_10_s(pass_at_350_km):
    """The Boston series of May 2015, four frames 10 s apart."""
    assert pass_at_350_km.moving_object_ground_m == pytest.approx(
        208.0, abs=0.5
    )  # printed to a metre
    overhead = pass_at_350_km.ground_sample_across_m.argmin()
    assert pass_at_350_km.moving_object_px[overhead] == pytest.approx(181.0, rel=0.015)


def test_three_frames_a_second_with_0_3_s_of_exposure(pass_at_350_km):
    """In 45 s: the last begins 0.3 s before the session's end."""
    assert pass_at_350_km.frames == 135
    assert np.diff(pass_at_350_km.t_s) == pytest.approx(1.0 / 3.0, abs=1e-9)


def test_the_frame_is_5_36_by_3_56_km_from_350_km():
    sides_km = 2.0 * HEIGHT_KM * np.tan(ISS_HRC.frame_half_rad)
    assert sides_km == pytest.approx([5.36, 3.56], abs=0.005)


@pytest.mark.parametrize(
    ("count", "runs", "interval"),
    [
        (81, 263, (0.2553, 0.3662)),
        (15, 148, (0.0624, 0.1605)),
        (0, 20, (0.0, 0.1611)),
        (1, 29, (0.0061, 0.1718)),
    ],
)
def test_intervals_are_wilsons(count, runs, interval):
    """Newcombe 1998, Two-sided confidence intervals for the single proportion, table I."""
    found = Proportion(count=count, runs=runs).interval()
    assert found == pytest.approx(interval, abs=5e-5)  # half the last printed digit


def ishigami(x):
    return (
        np.sin(x[..., 0]) + 7.0 * np.sin(x[..., 1]) ** 2 + 0.1 * x[..., 2] ** 4 * np.sin(x[..., 0])
    )


def test_indices_are_those_of_ishigamis_function():
    """Ishigami and Homma 1990; indices as in Saltelli et al. 2008, table 4.10 (a = 7, b = 0.1)."""
    pairs = 40_000
    a, b = np.random.default_rng(5).uniform(-np.pi, np.pi, (2, pairs, len(CAUSES)))
    ya, yb = ishigami(a), ishigami(b)
    total, first = np.zeros((2, pairs, 2, len(CAUSES)))
    for column in range(len(CAUSES)):
        changed = a.copy()
        changed[:, column] = b[:, column]
        total[:, :, column] = (0.5 * (ishigami(changed) - ya) ** 2)[:, None]
        first[:, :, column] = (0.5 * (ishigami(changed) - yb) ** 2)[:, None]
    variance = np.repeat((0.5 * (ya - yb) ** 2)[:, None], 2, axis=1)
    runs = RunOutcomes(
        causes=CAUSES,
        **dict.fromkeys(
            ("holds", "sharp", "holds_share", "sharp_share", "miss_rad", "miss_m", "smear_px"),
            np.zeros(0),
        ),
        gyro_numbers=np.zeros((0, 0)),
        variance_px2=variance,
        total_px2=total,
        first_px2=first,
    )
    by_cause = {one.cause: one for one in contributors([runs])}
    published = [(0.5576, 0.3139), (0.4424, 0.4424), (0.2437, 0.0), (0.0, 0.0), (0.0, 0.0)]
    for cause, (whole, alone) in zip(CAUSES, published, strict=True):
        one = by_cause[cause]
        assert abs(one.share - whole) < 4.0 * one.share_sigma + 5e-5
        assert abs(one.alone_share - alone) < 4.0 * one.alone_sigma + 5e-5
        assert max(one.share_sigma, one.alone_sigma) < 0.02
