"""The most that a body's table asks of its gyros, anywhere between its rows."""

from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices, cross
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable
from planner.verification.limits import RELATIVE_TOLERANCE
from planner.verification.platforms.body.options import OPTIONS
from planner.verification.platforms.body.quintic import FlownMotion, turned
from planner.verification.report import Finding, GyroLimit, GyroMargin
from planner.world.frames.geodesy import MU_EARTH_M3_S2
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import Ephemeris
from planner.world.platforms.gyros import GyroSet

Asked = Callable[[Indices, Array], tuple[Array, Array]]  # torque and momentum, (n, 3) each


class _Extreme(NamedTuple):
    """The greatest of some sizes, and when."""

    size: float = -1.0
    t_s: float = 0.0


# Name, unit and limit of a margin, and what came nearest to it.
_Found = tuple[GyroLimit, Literal["N m", "N m s", "deg/s", "1"], float, _Extreme]


def _greatest(size: Array, t_s: Array) -> _Extreme:
    worst = int(np.argmax(size))
    return _Extreme(float(size[worst]), float(t_s[worst]))


def gyro_margins(
    table: CommandTable,
    between: Callable[[Indices, Array], FlownMotion],
    gyros: GyroSet,
    inertia_kg_m2: Array,
    ephemeris: Ephemeris,
) -> tuple[GyroMargin, ...]:
    """To what turns may ask of the gyros, and to what their gimbals can do.

    Body and gyros together hold a momentum H that only gravity changes: what they begin with, and
    the impulse since.  The gyros hold H - J omega and give J alpha + omega x H less gravity's
    torque.  between: the motion so many seconds after the rows that cells begin with.
    inertia_kg_m2: (3, 3).  Left out: torques of air, light and magnetic field, 1e-4 N m.
    """
    gravity_eci_n_m = _gravity_eci_n_m(table, inertia_kg_m2, ephemeris)
    begun = np.array(gyros.start_n_m_s) + inertia_kg_m2 @ table.rate_rad_s[0]
    steps_n_m_s = 0.5 * COMMAND_STEP_S * (gravity_eci_n_m[1:] + gravity_eci_n_m[:-1])
    impulse_n_m_s = np.vstack([np.zeros(3), np.cumsum(steps_n_m_s, axis=0)])
    total_eci_n_m_s = turned(table.position[:1], begun) + impulse_n_m_s

    def asked(cell: Indices, share: Array) -> tuple[Array, Array]:
        flown = between(cell, share * COMMAND_STEP_S)
        back = flown.q_eci_from_body_xyzw * [-1.0, -1.0, -1.0, 1.0]
        total, gravity = (
            turned(back, rows[cell] + share[:, None] * (rows[cell + 1] - rows[cell]))
            for rows in (total_eci_n_m_s, gravity_eci_n_m)
        )
        omega = flown.omega_body_rad_s
        given = flown.alpha_body_rad_s2 @ inertia_kg_m2 + cross(omega, total) - gravity
        return given, total - omega @ inertia_kg_m2

    return tuple(
        GyroMargin(
            name=name,
            unit=unit,
            limit=limit,
            extreme=extreme.size,
            t_s=extreme.t_s,
            at_utc=shifted_utc(table.epoch_utc, extreme.t_s),
        )
        for name, unit, limit, extreme in (
            *_of_turns(len(table.position) - 1, gyros, asked),
            *_of_gimbals(table, gyros, asked),
        )
    )


def _of_turns(cells: int, gyros: GyroSet, asked: Asked) -> Iterator[_Found]:
    """The greatest torque and momentum."""
    turns, every = gyros.turns, np.arange(cells)
    most = np.array([turns.torque_max_n_m, turns.momentum_max_n_m_s])
    # Within a cell neither changes by more, unless the jerk or the torque is too large itself.
    changes = (
        COMMAND_STEP_S * OPTIONS.changes_most * np.array([turns.torque_rate_max_n_m_s, most[0]])
    )
    first, last = (asked(every, np.full(cells, share)) for share in (0.0, 1.0))
    ends = np.maximum(*(np.linalg.norm(side, axis=2) for side in (first, last)))
    reached = np.minimum(most, ends.max(axis=1))
    looked = np.flatnonzero(np.any(ends + changes[:, None] >= reached[:, None], axis=0))
    shares = np.arange(OPTIONS.finest + 1) / OPTIONS.finest
    extremes = [_Extreme(), _Extreme()]
    at_once = OPTIONS.rows_at_once // len(shares)
    for some in (looked[k : k + at_once] for k in range(0, len(looked), at_once)):
        cell, share = np.repeat(some, len(shares)), np.tile(shares, len(some))
        t_s = (cell + share) / ROWS_PER_S
        extremes = [
            max(extreme, _greatest(np.linalg.norm(vector, axis=1), t_s))
            for extreme, vector in zip(extremes, asked(cell, share), strict=True)
        ]
    torque, momentum = extremes
    yield "torque", "N m", float(most[0]), torque
    yield "momentum", "N m s", float(most[1]), momentum


def _of_gimbals(table: CommandTable, gyros: GyroSet, asked: Asked) -> Iterator[_Found]:
    """Of the gimbals on the rows: their rates as told, and the least that give the torque from
    where they stand, of which near a singularity there are none; how far from one they are; and
    by how much the momentum that their angles hold is another than asked."""
    angle_rad, rate_rad_s = _gimbal_columns(table)
    last = len(angle_rad) - 1
    cell = np.minimum(np.arange(last + 1), last - 1)
    torque_n_m, momentum_n_m_s = asked(cell, np.arange(last + 1.0) - cell)
    rotor_n_m_s, most_deg_s = gyros.array.rotor_n_m_s, gyros.array.gimbal_rate_max_deg_s
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    zero = np.zeros_like(s[:, :2])
    # Platonov, Sumarokov 2019, eq. 1: of h [s3 + s4, s1 + s2, c1 + c2 + c3 + c4].
    held = np.stack([s[:, 2:].sum(axis=1), s[:, :2].sum(axis=1), c.sum(axis=1)], axis=1)
    slopes = np.stack([np.hstack([zero, c[:, 2:]]), np.hstack([c[:, :2], zero]), -s], axis=1)
    needed_rad_s = (np.linalg.pinv(slopes) @ (-torque_n_m / rotor_n_m_s)[:, :, None])[:, :, 0]
    told_deg_s, needed_deg_s = (
        np.degrees(np.abs(rates).max(axis=1)) for rates in (rate_rad_s, needed_rad_s)
    )
    off_n_m_s = np.linalg.norm(rotor_n_m_s * held - momentum_n_m_s, axis=1)
    from_singular = np.linalg.svd(slopes, compute_uv=False)[:, -1]
    t_s = table.t_s
    nearest = _greatest(-from_singular, t_s)
    yield "gimbal_rate", "deg/s", most_deg_s, _greatest(told_deg_s, t_s)
    yield "gimbal_rate_needed", "deg/s", most_deg_s, _greatest(needed_deg_s, t_s)
    yield "singularity", "1", 0.0, nearest._replace(size=-nearest.size)
    miss_n_m_s = OPTIONS.gimbals_miss * rotor_n_m_s
    yield "momentum_mismatch", "N m s", miss_n_m_s, _greatest(off_n_m_s, t_s)


def gimbal_row_findings(table: CommandTable) -> Iterator[Finding]:
    """Where the gimbals' rates aren't those of their angles."""
    angle_rad, rate_rad_s = _gimbal_columns(table)
    jumps_rad = np.abs(angle_rad[1:] - angle_rad[:-1] - COMMAND_STEP_S * rate_rad_s[:-1])
    worst = _greatest(jumps_rad.max(axis=1), table.t_s)
    if worst.size > OPTIONS.gimbal_rad * (1.0 + RELATIVE_TOLERANCE):
        yield Finding(
            limit="table",
            t_s=worst.t_s,
            at_utc=shifted_utc(table.epoch_utc, worst.t_s),
            detail=f"a gimbal's rate misses by {worst.size:.3g} rad, more than "
            f"{OPTIONS.gimbal_rad:.6g}",
        )


def _gimbal_columns(table: CommandTable) -> tuple[Array, Array]:
    """Angles and rates, (n, 4) each."""
    assert table.extra_rad is not None  # else its columns are none of the platform's
    angle_rad, rate_rad_s = np.hsplit(table.extra_rad, 2)
    return angle_rad, rate_rad_s


def _gravity_eci_n_m(table: CommandTable, inertia_kg_m2: Array, ephemeris: Ephemeris) -> Array:
    """The gradient's torque at each row, (n, 3)."""
    q_xyzw = table.position
    r_eci_m = ephemeris.states(Instants(table.epoch_utc, table.t_s)).r_sat_eci_m
    radius_m = np.linalg.norm(r_eci_m, axis=1, keepdims=True)
    up_body = turned(q_xyzw * [-1.0, -1.0, -1.0, 1.0], r_eci_m / radius_m)
    torque_n_m = 3.0 * MU_EARTH_M3_S2 / radius_m**3 * cross(up_body, up_body @ inertia_kg_m2)
    return turned(q_xyzw, torque_n_m)
