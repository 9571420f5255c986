"""Residual vibration of a flexible structure after a slew."""

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S
from planner.world.platforms import StructuralMode


def residual_vibration_rad(
    angle_rad: Array,
    rate_rad_s: Array,
    mode: StructuralMode,
    *,
    acceleration_before_rad_s2: float = 0.0,
    acceleration_after_rad_s2: float = 0.0,
) -> float:
    """Amplitude of x'' + 2 z w x' + w^2 x = -a after the last row, rad.

    angle_rad, rate_rad_s: (n,), rows of one axis in a command table; a is the acceleration of the
    cubic Hermite through them, straight lines with steps at rows, and the response to them
    is exact.  Before the first row the mode hangs still under acceleration_before; after the
    last one it swings by the amplitude returned about its deflection under acceleration_after.
    The mode's share in the axis's motion is one; deflections scale with it.
    """
    start, stop = _accelerations(angle_rad, rate_rad_s)
    eigenvalue = mode.eigenvalue_rad_s
    phase = eigenvalue * COMMAND_STEP_S
    # With y' = lambda y + a the deflection is -Im y / w_d; over one row a = start + (stop-start) s.
    whole = np.expm1(phase) / eigenvalue
    ramp = (whole / COMMAND_STEP_S - 1.0) / eigenvalue
    gain = start * whole + (stop - start) * ramp
    rows_left = np.arange(len(gain) - 1, -1, -1)
    still = -1.0 / eigenvalue  # y under a unit of steady acceleration
    swing = (
        acceleration_before_rad_s2 * still * np.exp(phase * len(gain))
        + np.sum(gain * np.exp(phase * rows_left))
        - acceleration_after_rad_s2 * still
    )
    return float(abs(swing) / eigenvalue.imag)


def _accelerations(angle_rad: Array, rate_rad_s: Array) -> tuple[Array, Array]:
    """Where each cell of the Hermite begins and ends, (n - 1,) each."""
    mean = np.diff(angle_rad) / COMMAND_STEP_S
    before, after = rate_rad_s[:-1], rate_rad_s[1:]
    return (
        (6.0 * mean - 4.0 * before - 2.0 * after) / COMMAND_STEP_S,
        (2.0 * before + 4.0 * after - 6.0 * mean) / COMMAND_STEP_S,
    )
