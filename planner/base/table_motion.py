"""The motion that a command table has a platform fly between its rows.

The judge (planner/verification) derives it for itself.
"""

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable, Motion
from planner.base.interpolation import cubic_coefficients
from planner.base.mrp import BodyMotion, MrpState, body_motion, mrp_state, quintic
from planner.base.rotation import Rotation


def motion_at(table: CommandTable, t_s: Array) -> Motion:
    """At instants t_s (n,) of the table's clock; outside its rows as on the nearest of them."""
    if table.acceleration_rad_s2 is None:
        return Motion(*axes_motion_at(table.position, table.rate_rad_s, t_s))
    q_eci_from_body, moved = body_motion_at(
        table.position, table.rate_rad_s, table.acceleration_rad_s2, t_s
    )
    return Motion(q_eci_from_body.as_quat(), moved.omega_body_rad_s, moved.alpha_body_rad_s2)


def axes_motion_at(angle_rad: Array, rate_rad_s: Array, t_s: Array) -> tuple[Array, Array, Array]:
    """Angle, rate and acceleration of the cubic Hermite through rows (k, m), each (n, m)."""
    cell, share = _place(len(angle_rad), t_s)
    s, h = share[:, None], COMMAND_STEP_S
    c0, c1, c2, c3 = cubic_coefficients(
        h, angle_rad[cell], angle_rad[cell + 1], rate_rad_s[cell], rate_rad_s[cell + 1]
    )
    angle = c0 + s * (c1 + s * (c2 + s * c3))
    return angle, (c1 + s * (2.0 * c2 + s * 3.0 * c3)) / h, (2.0 * c2 + s * 6.0 * c3) / h**2


def smooth_motion_at(
    angle_rad: Array, rate_rad_s: Array, acceleration_rad_s2: Array, t_s: Array
) -> tuple[Array, Array, Array]:
    """Angle, rate and acceleration of the quintic Hermite through rows (k, m), each (n, m)."""
    cell, share = _place(len(angle_rad), t_s)
    rows = MrpState(angle_rad, rate_rad_s, acceleration_rad_s2)
    start, end = (MrpState(*(column[k] for column in rows)) for k in (cell, cell + 1))
    return quintic(start, end, COMMAND_STEP_S, share)[:3]


def accelerations_rad_s2(table: CommandTable, cell: Indices) -> Array:
    """At the start and the end of each cell between two rows, (k, 2, m).

    Of axes those of the cubic that is flown there, of a body those of the two rows.
    """
    if table.acceleration_rad_s2 is not None:
        return np.stack([table.acceleration_rad_s2[cell + i] for i in (0, 1)], axis=1)
    h = COMMAND_STEP_S
    angle, rate = table.position, table.rate_rad_s
    *_, c2, c3 = cubic_coefficients(h, angle[cell], angle[cell + 1], rate[cell], rate[cell + 1])
    return np.stack([2.0 * c2, 2.0 * c2 + 6.0 * c3], axis=1) / h**2


def body_motion_at(
    q_eci_from_body_xyzw: Array, omega_body_rad_s: Array, alpha_body_rad_s2: Array, t_s: Array
) -> tuple[Rotation, BodyMotion]:
    """Attitude from body to ECI, and body rates, (n, 3) each.

    Of the quintic Hermite in modified Rodrigues parameters against a cell's first row, which meets
    the attitude, rate and acceleration of both, (k, 4), (k, 3) and (k, 3).
    """
    cell, share = _place(len(omega_body_rad_s), t_s)
    q_eci_from_start = Rotation.from_quat(q_eci_from_body_xyzw[cell])
    q_eci_from_end = Rotation.from_quat(q_eci_from_body_xyzw[cell + 1])
    sigma = np.asarray((q_eci_from_start.inv() * q_eci_from_end).as_mrp())
    curve = quintic(
        MrpState(np.zeros_like(sigma), omega_body_rad_s[cell] / 4.0, alpha_body_rad_s2[cell] / 4.0),
        mrp_state(sigma, omega_body_rad_s[cell + 1], alpha_body_rad_s2[cell + 1]),
        COMMAND_STEP_S,
        share,
    )
    return q_eci_from_start * Rotation.from_mrp(curve.mrp), body_motion(curve)


def _place(rows: int, t_s: Array) -> tuple[Indices, Array]:
    """In which cell each instant lies, (n,), and what share of it has passed."""
    at = np.clip(np.asarray(t_s) * ROWS_PER_S, 0.0, rows - 1.0)
    cell = np.minimum(at.astype(np.intp), rows - 2)
    return cell, at - cell
