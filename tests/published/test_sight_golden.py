"""Lines of sight of planner and judge, each by its own code, agree with Orekit's and Skyfield's."""

import json
from datetime import datetime

import erfa
import numpy as np
import pytest
from golden_sight import ARCSEC_RAD, DATA, GOLDEN

from planner.verification.earth_fixed import earth_fixed_sight
from planner.verification.platforms.two_axis.carrier import eci_from_platform
from planner.verification.sky import sky_sight
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms import ISS_HRC
from planner.world.targets import BodyTarget, GroundTarget, StarTarget

# Skyfield 1.55 with DE440 and Hipparcos-2 from NASA's ISS ephemerides; conventions in the file
CELESTIAL = json.loads((DATA / "golden_celestial.json").read_text())
HIP = {star["name"]: star["hip"] for star in CELESTIAL["conventions"]["stars"]}

C_EME2000_FROM_GCRF = erfa.bp00(2451545.0, 0.0)[0]


def states_of(epochs):
    return OrbitStates(
        np.array([epoch["iss_pos_eme2000_km"] for epoch in epochs]) @ C_EME2000_FROM_GCRF * 1e3,
        np.array([epoch["iss_vel_eme2000_km_s"] for epoch in epochs]) @ C_EME2000_FROM_GCRF * 1e3,
    )


def by_planner(target, instants, states):
    """Apparent directions, ranges and clearances (of ground targets elevations)."""
    seen = target.apparent(instants, states)
    return seen.direction_eci, seen.range_m, seen.clearance_rad


def by_judge(target, instants, states):
    if isinstance(target, GroundTarget):
        sight = earth_fixed_sight(target, instants, states)
        assert not sight.hidden.any()
        return sight.apparent_eci, sight.range_m, sight.elevation_rad
    sight = sky_sight(target, instants, states)
    return sight.apparent_eci, sight.range_m, sight.clearance_rad


BOTH = pytest.mark.parametrize("looked", [by_planner, by_judge])


@BOTH
@pytest.mark.parametrize("case", GOLDEN["cases"], ids=lambda case: case["id"])
def test_apparent_direction_range_and_elevation(case, looked):
    epochs, target = case["epochs"], case["target"]
    utc = [datetime.fromisoformat(epoch["utc"]) for epoch in epochs]
    instants = Instants(utc[0], np.array([(at - utc[0]).total_seconds() for at in utc]))
    states = states_of(epochs)
    ground = GroundTarget(
        latitude_deg=target["lat_deg"],
        longitude_deg=target["lon_deg"],
        height_m=target["height_m"],
    )
    apparent_eci, range_m, elevation_rad = looked(ground, instants, states)
    lvlh_axes_eci = [
        eci_from_platform(np.tile(axis, (len(utc), 1)), ISS_HRC, LvlhAttitude(), instants, states)
        for axis in np.eye(3)
    ]
    los_lvlh = np.stack([np.sum(apparent_eci * axis, axis=1) for axis in lvlh_axes_eci], axis=1)
    golden = np.array([epoch["los_lvlh_apparent"] for epoch in epochs])
    error_rad = np.linalg.norm(los_lvlh - golden, axis=1)
    # what the file's own tools differ by in Earth orientation: 0.014 arcsec and 0.024 m
    assert error_rad.max() < 0.02 * ARCSEC_RAD
    golden_range_m = np.array([epoch["range_km"] for epoch in epochs]) * 1e3
    np.testing.assert_allclose(range_m, golden_range_m, rtol=0, atol=0.03)
    golden_elevation_deg = [epoch["target_elevation_deg"] for epoch in epochs]
    # 0.1 m across the shortest range, 400 km
    np.testing.assert_allclose(np.rad2deg(elevation_rad), golden_elevation_deg, rtol=0, atol=1.5e-5)


@BOTH
@pytest.mark.parametrize(
    "case", CELESTIAL["cases"], ids=lambda case: f"{case['body']} {case['utc']}"
)
def test_apparent_direction_and_limb_of_celestial_targets(case, looked):
    # the case's instant, and a second one that is not looked at
    states, instants = (
        states_of([case, case]),
        Instants(datetime.fromisoformat(case["utc"]), np.array([0.0, 1.0])),
    )
    name = case["body"]
    where = {"hip": HIP[name]} if name in HIP else {"name": name}
    target = (StarTarget if name in HIP else BodyTarget)(grazing_altitude_km=0.0, **where)
    apparent_eci, _, clearance_rad = looked(target, instants, states)
    expected = np.array(case["apparent_gcrf"]) / np.linalg.norm(case["apparent_gcrf"])
    error_rad = np.linalg.norm(np.cross(apparent_eci[0], expected))
    # DE421 and DE440 differ by 0.003 arcsec for Sun and Moon; Jupiter by 0.02
    assert error_rad < (0.02 if name == "Jupiter" else 0.003) * ARCSEC_RAD
    # their limb is a sphere of the equator's radius, up to 21 km too large, 2,300 km away; the
    # carrier's aberration of 5 arcsec is in their angle and not in ours
    excess_deg = np.rad2deg(clearance_rad[0]) - case["geocentric_earth_limb_angle_deg"]
    assert -0.002 < excess_deg < 0.54
