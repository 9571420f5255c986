"""A target straight below the carrier is seen, whichever way its sines are rounded."""

from datetime import UTC, datetime

import numpy as np
import pytest

from planner.verification.earth_fixed import earth_fixed_sight
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import itrf_from_geodetic, up_itrf
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.targets import GroundTarget

HEIGHT_M = 4e5


def test_planner_and_judge_see_it_at_90_deg():
    """At 2,000 turns of the Earth, at a quarter of which the sine rounds to more than 1."""
    target = GroundTarget(latitude_deg=36.1147, longitude_deg=-115.1728, height_m=610.0)
    place_rad = np.deg2rad([target.latitude_deg, target.longitude_deg])
    r_sat_itrf_m = itrf_from_geodetic(*place_rad, target.ground_height_m) + HEIGHT_M * up_itrf(
        *place_rad
    )
    instants = Instants(datetime(2015, 2, 27, tzinfo=UTC), np.arange(0.0, 40_000.0, 20.0))
    r_sat_eci_m = np.einsum("nji,j->ni", c_itrf_from_eci(instants), r_sat_itrf_m)
    states = OrbitStates(r_sat_eci_m, np.ones_like(r_sat_eci_m))
    # The target moves by 0.6 m while its light travels: 1.5 microradians off the vertical.
    judged_rad = earth_fixed_sight(target, instants, states).elevation_rad
    assert judged_rad == pytest.approx(np.full(2000, np.pi / 2.0), abs=3e-6)
    planned_rad = target.apparent(instants, states).clearance_rad
    assert planned_rad == pytest.approx(np.full(2000, np.pi / 2.0), abs=3e-6)
