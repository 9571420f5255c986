"""Ground points seen from the ISS against Orekit and Skyfield (`golden_los.json`)."""

import json
from pathlib import Path

import numpy as np
import pytest

from planner.world.frames.earth_orientation import C_GCRF_FROM_EME2000
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants, utc_from_text
from planner.world.orbits.ephemeris import OrbitStates
from planner.world.targets import GroundTarget

GOLDEN = json.loads((Path(__file__).parents[1] / "data" / "golden_los.json").read_text())


@pytest.mark.parametrize("case", GOLDEN["cases"], ids=lambda case: case["id"])
def test_apparent_direction_range_and_elevation_match(case):
    place = case["target"]
    target = GroundTarget(
        latitude_deg=place["lat_deg"], longitude_deg=place["lon_deg"], height_m=place["height_m"]
    )
    for epoch in case["epochs"]:
        r_m = 1e3 * np.array([epoch["iss_pos_eme2000_km"]]) @ C_GCRF_FROM_EME2000.T
        v_m_s = 1e3 * np.array([epoch["iss_vel_eme2000_km_s"]]) @ C_GCRF_FROM_EME2000.T
        instants = Instants(utc_from_text(epoch["utc"]), np.zeros(1))
        seen = target.apparent(instants, OrbitStates(r_m, v_m_s))
        lvlh = q_lvlh_from_eci(r_m, v_m_s).apply(seen.direction_eci)[0]
        apart_rad = np.linalg.norm(np.cross(lvlh, epoch["los_lvlh_apparent"]))
        # The file's tolerances: 0.1 arcsec and 0.1 m.
        assert np.degrees(apart_rad) * 3600.0 < 0.1
        assert seen.range_m[0] == pytest.approx(1e3 * epoch["range_km"], abs=0.1)
        # 0.1 m at 400 km, and the file's last digit
        assert np.degrees(seen.clearance_rad[0]) == pytest.approx(
            epoch["target_elevation_deg"], abs=2e-5
        )
