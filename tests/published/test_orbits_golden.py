"""An ephemeris is interpolated as Orekit does it."""

import numpy as np
import pytest
from golden_sight import GOLDEN, orbit_of

from planner.world.frames.earth_orientation import C_GCRF_FROM_EME2000
from planner.world.frames.time_scales import Instants, elapsed_s, utc_from_text


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
