"""Lines of sight of planner and judge, and ephemerides, against Orekit 13.1.9 and Skyfield 1.55.

Each of the golden files was checked against a third tool.
"""

import json
import math
from datetime import datetime
from pathlib import Path

import erfa
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from planner.motion.pointing.line_of_sight import line_of_sight
from planner.verification.earth_fixed import earth_fixed_sight
from planner.verification.platforms.two_axis.carrier import eci_from_platform
from planner.verification.sky import sky_sight
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.earth_orientation import C_GCRF_FROM_EME2000
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_from_text
from planner.world.orbits import OemOrbit, OrbitStates, TleOrbit
from planner.world.platforms import ISS_HRC
from planner.world.targets import BodyTarget, GroundTarget, StarTarget

DATA = Path(__file__).parents[1] / "data"
GOLDEN = json.loads((DATA / "golden_los.json").read_text())  # conventions in the file
ARCSEC_RAD = math.pi / 648000.0


def orbit_of(source):
    if source["type"] == "TLE":
        return TleOrbit(line1=source["line1"], line2=source["line2"])
    name = source["file"].removeprefix("oem/ISS.OEM_J2K_EPH_").removesuffix(".xml.gz")
    return OemOrbit(content=(DATA / f"iss_oem_{name}_excerpt.xml").read_text())


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
        latitude_deg=target["lat_deg"], longitude_deg=target["lon_deg"], height_m=target["height_m"]
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


ABERRATION_RATE_SHARE = 3e-5  # v/c: the golden rate is that of the geometric direction


@pytest.mark.parametrize("case", GOLDEN["cases"], ids=lambda case: case["id"])
def test_apparent_direction_and_rate(case):
    orbit, target = orbit_of(case["orbit_source"]), case["target"]
    for epoch in case["epochs"]:
        at = utc_from_text(epoch["utc"])
        # central differences of the golden file: +-0.5 s
        instants = Instants(at, np.linspace(-0.5, 0.5, 11))
        los = line_of_sight(
            instants,
            orbit.ephemeris(shifted_utc(at, -0.5), shifted_utc(at, 0.5)),
            LvlhAttitude(),
            Rotation.identity(),
            GroundTarget(
                latitude_deg=target["lat_deg"],
                longitude_deg=target["lon_deg"],
                height_m=target["height_m"],
            ),
        )
        off = los.los_base[5] - epoch["los_lvlh_apparent"]
        assert np.linalg.norm(off) < 0.1 * ARCSEC_RAD  # the file's own tolerance
        assert abs(los.range_m[5] - epoch["range_km"] * 1e3) < 0.1
        assert np.rad2deg(los.clearance_rad[5]) == pytest.approx(
            epoch["target_elevation_deg"], abs=1e-4
        )
        golden_rate = np.array(epoch["los_rate_lvlh_per_s"])
        # the file's central difference errs by the third derivative over 24
        third = np.ptp(los.los_acceleration_base_per_s2, axis=0).max()
        allowed = ABERRATION_RATE_SHARE * np.linalg.norm(golden_rate) + third / 24.0 + 1e-9
        assert np.linalg.norm(los.los_rate_base_per_s[5] - golden_rate) < 2.0 * allowed


def test_derivatives_are_those_of_the_direction():
    """Against a Chebyshev fit of the same pass, differentiated exactly."""
    case = next(case for case in GOLDEN["cases"] if case["orbit_source"]["type"] == "TLE")
    at = utc_from_text(case["epochs"][3]["utc"])
    target = case["target"]
    ground = GroundTarget(
        latitude_deg=target["lat_deg"], longitude_deg=target["lon_deg"], height_m=0.0
    )

    def sight(t_s):
        ephemeris = orbit_of(case["orbit_source"]).ephemeris(
            shifted_utc(at, t_s[0]), shifted_utc(at, t_s[-1])
        )
        return line_of_sight(
            Instants(at, t_s), ephemeris, LvlhAttitude(), Rotation.identity(), ground
        )

    t_s = np.arange(0, 301) / 5.0
    los = sight(t_s)
    for axis in range(3):
        fit = np.polynomial.Chebyshev.fit(t_s, los.los_base[:, axis], 40)
        # (0.2 s / 54 s)^5 of an acceleration of 3e-4 /s2, and rounding 1e-15 / 0.2^2
        np.testing.assert_allclose(
            los.los_rate_base_per_s[:, axis], fit.deriv(1)(t_s), rtol=0, atol=1e-11
        )
        inner = slice(10, -10)  # a polynomial's own second derivative is poor at its ends
        np.testing.assert_allclose(
            los.los_acceleration_base_per_s2[inner, axis],
            fit.deriv(2)(t_s)[inner],
            rtol=0,
            atol=1e-10,
        )


@pytest.mark.parametrize(
    "case",
    [case for case in GOLDEN["cases"] if case["orbit_source"]["type"] == "OEM"],
    ids=lambda case: case["id"],
)
def test_interpolation_is_orekits(case):
    utc = [utc_from_text(epoch["utc"]) for epoch in case["epochs"]]
    instants = Instants(utc[0], np.array([elapsed_s(at, utc[0]) for at in utc]))
    states = orbit_of(case["orbit_source"]).ephemeris(utc[0], utc[-1]).states(instants)
    r_m = np.array([epoch["iss_pos_eme2000_km"] for epoch in case["epochs"]]) * 1e3
    v_m_s = np.array([epoch["iss_vel_eme2000_km_s"] for epoch in case["epochs"]]) * 1e3
    # half the last printed digits, 1e-8 km and 1e-11 km/s
    np.testing.assert_allclose(states.r_sat_eci_m @ C_GCRF_FROM_EME2000, r_m, rtol=0, atol=1.2e-5)
    np.testing.assert_allclose(
        states.v_sat_eci_m_s @ C_GCRF_FROM_EME2000, v_m_s, rtol=0, atol=1.2e-8
    )
