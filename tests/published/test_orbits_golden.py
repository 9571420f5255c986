"""The orbit sources give Orekit's and Skyfield's lines of sight."""

import numpy as np
import pytest
from golden_sight import ARCSEC_RAD, GOLDEN, orbit_of

from planner.world.frames.earth_orientation import C_GCRF_FROM_EME2000, c_itrf_from_eci
from planner.world.frames.geodesy import itrf_from_geodetic
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.time_scales import Instants, elapsed_s, utc_from_text


@pytest.mark.parametrize("case", GOLDEN["cases"], ids=lambda case: case["id"])
def test_line_of_sight_and_range(case):
    utc = [utc_from_text(epoch["utc"]) for epoch in case["epochs"]]
    instants = Instants(utc[0], np.array([elapsed_s(at, utc[0]) for at in utc]))
    ephemeris = orbit_of(case["orbit_source"]).ephemeris(utc[0], utc[-1])
    assert all("a burn it plans" in warning for warning in ephemeris.warnings)
    states = ephemeris.states(instants)
    c = c_itrf_from_eci(instants)
    target = case["target"]
    r_target_itrf_m = itrf_from_geodetic(
        np.deg2rad(target["lat_deg"]), np.deg2rad(target["lon_deg"]), target["height_m"]
    )
    line_eci_m = np.einsum("nji,j->ni", c, r_target_itrf_m) - states.r_sat_eci_m
    range_m = np.linalg.norm(line_eci_m, axis=1)
    los_eci = line_eci_m / range_m[:, None]
    q = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
    ours = {
        "los_itrf": np.einsum("nij,nj->ni", c, los_eci),
        "los_gcrf": los_eci,
        "los_eme2000": los_eci @ C_GCRF_FROM_EME2000,
        "los_lvlh": q.apply(los_eci),
    }
    for name, direction in ours.items():
        golden = np.array([epoch[name] for epoch in case["epochs"]])
        error_rad = np.linalg.norm(direction - golden, axis=1)
        # the file's own tolerance: what its tools differ by in Earth orientation and TEME
        assert error_rad.max() < 0.1 * ARCSEC_RAD, name
    golden_range_m = [epoch["range_km"] * 1e3 for epoch in case["epochs"]]
    np.testing.assert_allclose(range_m, golden_range_m, rtol=0, atol=0.1)


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
