"""Orekit finds in our AEM and OEM the attitude and orbit of the plan.

Orekit needs Java, so its reading is kept: see exports_by_orekit.py, run by `make oracles`.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from export_cases import (
    ARCSEC_RAD,
    EPOCH_UTC,
    READ_BACK_RAD,
    SKEW,
    c_body_from_eci,
    c_payload_from_body,
    case,
    orbit_states,
)
from scipy.interpolate import CubicHermiteSpline

from planner.world.frames.time_scales import Instants

READ = json.loads((Path(__file__).parents[1] / "data" / "exports_by_orekit.json").read_text())
SAMPLES = READ["samples"]
PLAN = case()


def flown_at(t_s):
    """Payload axes in GCRF as rows, states; angles by the cubic Hermite the platform flies."""
    table = PLAN.table
    angle_rad = CubicHermiteSpline(table.t_s, table.position, table.rate_rad_s)(t_s)
    states = orbit_states(PLAN.scenario.orbit, Instants(EPOCH_UTC, np.append(t_s, 60.0)))
    c_body = c_body_from_eci(states)[:-1]
    return c_payload_from_body(SKEW, angle_rad) @ c_body, states


def test_orekit_knows_what_the_messages_are_about():
    assert (READ["attitude_from"], READ["attitude_to"]) == ("GCRF", "INSTRUMENT_1")
    assert READ["attitude_type"] == "QUATERNION/ANGVEL"
    assert READ["object_id"] == "1998-067A"
    assert READ["start"] == "2015-02-27T17:36:00.000Z"
    assert READ["orbit_stop"] == "2015-02-27T17:37:00.000Z"


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: f"{sample['t_s']} s")
def test_orekit_finds_the_attitude(sample):
    c_payload, _ = flown_at(np.array([sample["t_s"]]))
    on_row = abs(5.0 * sample["t_s"] - round(5.0 * sample["t_s"])) < 1e-9
    # on rows 0.01 arcsec; between them what the table promises, 0.1 arcsec
    tolerance_rad = READ_BACK_RAD if on_row else 0.1 * ARCSEC_RAD
    for axis, name in ((0, "x_payload_gcrf"), (2, "z_payload_gcrf")):
        assert np.linalg.norm(c_payload[0, axis] - sample[name]) < tolerance_rad


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: f"{sample['t_s']} s")
def test_orekit_finds_the_angular_velocity(sample):
    step_s = 1e-3
    inside_s = np.clip(sample["t_s"], step_s, 60.0 - step_s)
    (before, here, after), _ = flown_at(inside_s + step_s * np.arange(-1.0, 2.0))
    cross = here @ (after - before).T / (2.0 * step_s)  # of omega, in payload axes
    omega_rad_s = np.array([cross[2, 1], cross[0, 2], cross[1, 0]])
    # at the table's ends the difference is taken 1 ms inside, at up to 0.06 rad/s2; elsewhere
    # Hermite's rate error h^3/96 of the fourth derivative, 2e-8 rad/s
    atol = 1e-4 if inside_s != sample["t_s"] else 1e-6
    np.testing.assert_allclose(sample["spin_payload_rad_s"], omega_rad_s, rtol=0, atol=atol)


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: f"{sample['t_s']} s")
def test_orekit_finds_the_orbit(sample):
    _, states = flown_at(np.array([sample["t_s"]]))
    # SGP4's velocity strays from its position's derivative by 16 mm/s (central differences of
    # either), of which Hermite interpolation of 1 s nodes makes 2 mm and 40 mm/s between them
    on_node = sample["t_s"] == round(sample["t_s"])
    for found, planned, atol in (
        (sample["r_sat_gcrf_m"], states.r_sat_eci_m[0], 1e-6 if on_node else 2e-3),
        (sample["v_sat_gcrf_m_s"], states.v_sat_eci_m_s[0], 1e-8 if on_node else 0.05),
    ):
        np.testing.assert_allclose(found, planned, rtol=0, atol=atol)
