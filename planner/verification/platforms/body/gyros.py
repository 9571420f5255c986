"""Torque and momentum that a body's table asks of its gyros, anywhere between its rows."""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices, cross
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable
from planner.verification.limits import RELATIVE_TOLERANCE
from planner.verification.platforms.body.options import OPTIONS
from planner.verification.platforms.body.quintic import FlownMotion, turned
from planner.verification.report import Finding, Limit
from planner.world.frames.geodesy import MU_EARTH_M3_S2
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import Ephemeris
from planner.world.platforms.gyros import GyroSet

LIMITS: tuple[Limit, Limit] = ("torque", "momentum")


class _Extreme(NamedTuple):
    """The greatest length so far, and when."""

    size: float = -1.0
    t_s: float = 0.0


def _greater(extreme: _Extreme, size: Array, t_s: Array) -> _Extreme:
    """The extreme, or that of n sizes where one is greater."""
    worst = int(np.argmax(size))
    return max(extreme, _Extreme(float(size[worst]), float(t_s[worst])))


def gyro_findings(
    table: CommandTable,
    between: Callable[[Indices, Array], FlownMotion],
    gyros: GyroSet,
    inertia_kg_m2: Array,
    ephemeris: Ephemeris,
) -> Iterator[Finding]:
    """Where torque or momentum exceed what turns may ask of the gyros.

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
        """Torque and momentum, (n, 3) each."""
        flown = between(cell, share * COMMAND_STEP_S)
        back = flown.q_eci_from_body_xyzw * [-1.0, -1.0, -1.0, 1.0]
        total, gravity = (
            turned(back, rows[cell] + share[:, None] * (rows[cell + 1] - rows[cell]))
            for rows in (total_eci_n_m_s, gravity_eci_n_m)
        )
        omega = flown.omega_body_rad_s
        given = flown.alpha_body_rad_s2 @ inertia_kg_m2 + cross(omega, total) - gravity
        return given, total - omega @ inertia_kg_m2

    yield from _gimbal_findings(table, gyros, asked)
    cells, turns = np.arange(len(table.position) - 1), gyros.turns
    most = turns.torque_max_n_m, turns.momentum_max_n_m_s
    # Within a cell neither changes by more, unless the jerk or the torque is too large itself.
    changes = (
        COMMAND_STEP_S * OPTIONS.changes_most * np.array([turns.torque_rate_max_n_m_s, most[0]])
    )
    first, last = (asked(cells, np.full(len(cells), share)) for share in (0.0, 1.0))
    ends = np.maximum(*(np.linalg.norm(side, axis=2) for side in (first, last)))
    looked = np.flatnonzero(np.any(ends + changes[:, None] >= np.array(most)[:, None], axis=0))
    shares = np.arange(OPTIONS.finest + 1) / OPTIONS.finest
    extremes = [_Extreme(), _Extreme()]
    at_once = OPTIONS.rows_at_once // len(shares)
    for some in (looked[k : k + at_once] for k in range(0, len(looked), at_once)):
        cell, share = np.repeat(some, len(shares)), np.tile(shares, len(some))
        t_s = (cell + share) / ROWS_PER_S
        extremes = [
            _greater(extreme, np.linalg.norm(vector, axis=1), t_s)
            for extreme, vector in zip(extremes, asked(cell, share), strict=True)
        ]
    for limit, extreme, size, unit in zip(LIMITS, extremes, most, ("N m", "N m s"), strict=True):
        if extreme.size > size * (1.0 + RELATIVE_TOLERANCE):
            yield Finding(
                limit=limit,
                t_s=extreme.t_s,
                at_utc=shifted_utc(table.epoch_utc, extreme.t_s),
                detail=f"the gyros' {limit} reaches {extreme.size:.6g} {unit}, more than {size:g}",
            )


def _gimbal_findings(
    table: CommandTable, gyros: GyroSet, asked: Callable[[Indices, Array], tuple[Array, Array]]
) -> Iterator[Finding]:
    """Where the gimbals' rates aren't those of their angles, the angles don't hold the momentum
    asked, or a gimbal is faster than its drive, as told or by the least rates that give the torque
    from where the gimbals stand: near a singularity none do."""
    assert table.extra_rad is not None  # else its columns are none of the platform's
    angle_rad, rate_rad_s = np.hsplit(table.extra_rad, 2)
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
    jumps_rad = np.abs(angle_rad[1:] - angle_rad[:-1] - COMMAND_STEP_S * rate_rad_s[:-1])
    off_n_m_s = np.linalg.norm(rotor_n_m_s * held - momentum_n_m_s, axis=1)
    checks: tuple[tuple[Limit, Array, float, str], ...] = (
        (
            "table",
            jumps_rad.max(axis=1),
            OPTIONS.gimbal_rad,
            "a gimbal's rate misses by {:.3g} rad",
        ),
        (
            "momentum",
            off_n_m_s,
            OPTIONS.gimbals_miss * rotor_n_m_s,
            "the gimbals hold {:.3g} N m s other than the body's motion asks",
        ),
        (
            "rate",
            np.degrees(np.abs(rate_rad_s).max(axis=1)),
            most_deg_s,
            "a gimbal turns at {:.6g} deg/s",
        ),
        (
            "rate",
            np.degrees(np.abs(needed_rad_s).max(axis=1)),
            most_deg_s,
            "the torque takes a gimbal to {:.6g} deg/s",
        ),
    )
    for limit, size, most, told in checks:
        row = int(np.argmax(size))
        if size[row] > most * (1.0 + RELATIVE_TOLERANCE):
            t_s = row / ROWS_PER_S
            yield Finding(
                limit=limit,
                t_s=t_s,
                at_utc=shifted_utc(table.epoch_utc, t_s),
                detail=f"{told.format(size[row])}, more than {most:.6g}",
            )


def _gravity_eci_n_m(table: CommandTable, inertia_kg_m2: Array, ephemeris: Ephemeris) -> Array:
    """The gradient's torque at each row, (n, 3)."""
    q_xyzw = table.position
    r_eci_m = ephemeris.states(Instants(table.epoch_utc, table.t_s)).r_sat_eci_m
    radius_m = np.linalg.norm(r_eci_m, axis=1, keepdims=True)
    up_body = turned(q_xyzw * [-1.0, -1.0, -1.0, 1.0], r_eci_m / radius_m)
    torque_n_m = 3.0 * MU_EARTH_M3_S2 / radius_m**3 * cross(up_body, up_body @ inertia_kg_m2)
    return turned(q_xyzw, torque_n_m)
