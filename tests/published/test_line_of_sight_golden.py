"""The planner's line of sight, its rate included, is that of Orekit and Skyfield."""

import numpy as np
import pytest
from golden_sight import ARCSEC_RAD, GOLDEN, orbit_of
from scipy.spatial.transform import Rotation

from planner.motion.pointing.line_of_sight import line_of_sight
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import Instants, shifted_utc, utc_from_text
from planner.world.targets import GroundTarget

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
