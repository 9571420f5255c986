"""A flight is what SciPy makes of the equations in docs/simulation.md."""

from dataclasses import replace

import numpy as np
import pytest
from flight_cases import ARCSEC, ROCKING, rough, steady, swinging
from flight_reference import Reference

from planner.inflight.simulation.flight import fly
from planner.world.platforms import ISS_HRC

SECONDS = 5.0
CASES = {
    "quick": (ISS_HRC, swinging(SECONDS), rough(), rough(lag_s=0.0)),
    "sticking": (ISS_HRC, steady(30.0, -12.0, duration_s=SECONDS), rough(), rough(damping=0.5)),
    "late, with play": (
        ISS_HRC,
        swinging(SECONDS),
        rough(command_latency_s=0.13, backlash_arcsec=8.0),
        rough(lag_s=0.1, integral=0.0, backlash_arcsec=3.0),
    ),
    "saturated": (
        replace(
            ISS_HRC, outer_limits=replace(ISS_HRC.outer_limits, acceleration_max_rad_s2=0.004)
        ),
        swinging(SECONDS),
        rough(torque_reserve=1.0),
        rough(),
    ),
    "on a light structure": (
        ROCKING, swinging(SECONDS), rough(inertia_kg_m2=90.0), rough(cable_stiffness_per_s2=0.1),
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_a_flight_is_scipys(case):
    """To 0.05 arcsec, a sixth of an encoder's count: what sticking makes of the steps' errors."""
    platform, table, *drives = CASES[case]
    ours = fly(table, platform, drives=tuple(drives))
    angle_rad, turn_rad = Reference(platform, drives).fly(table, len(ours.t_s))
    np.testing.assert_allclose(ours.angle_rad, angle_rad, rtol=0, atol=0.05 * ARCSEC)
    np.testing.assert_allclose(ours.structure_rad, turn_rad, rtol=0, atol=0.05 * ARCSEC)
    # What is compared is no mere following of the table.
    told = np.abs(ours.angle_rad - table.position[0]).max()
    assert told > 100.0 * ARCSEC
