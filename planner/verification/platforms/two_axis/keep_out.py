"""The check that the boresight enters no keep-out cone, on rows or between them."""

import math

import erfa
import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, CommandTable
from planner.verification.directions import apart_rad, eci_from_lvlh
from planner.verification.platforms.judge import FlownInstants, Judge
from planner.verification.report import KeepOutMargin
from planner.verification.sky import sky_sight
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.rules.keep_out import KeepOut
from planner.world.scenario import Scenario
from planner.world.targets import BodyTarget
from planner.world.targets.body import HIDDEN_RAD

FINER = 20  # instants per cell, 10 ms apart, where a cone is near
ROWS_AT_ONCE = 20_000


def keep_out_margins(
    table: CommandTable, scenario: Scenario, judge: Judge
) -> tuple[KeepOutMargin, ...]:
    """How near the boresight comes to each cone, from the first row to the last.

    Raises OutsideCoverage.
    """
    if not scenario.slew.keep_out:
        return ()
    count = len(table.t_s)
    ephemeris = scenario.orbit.ephemeris(
        table.epoch_utc, shifted_utc(table.epoch_utc, (count - 1) / ROWS_PER_S)
    )
    reach_rad = judge.turn_most_rad()
    margins = []
    for number, cone in enumerate(scenario.slew.keep_out):
        half_rad = math.radians(cone.half_angle_deg)
        rows = np.arange(count)
        away_rad = _away_rad(table, judge, ephemeris, cone, rows, np.zeros(count))
        # Closest among the rows, and every 10 ms next to rows from which the cone is in reach.
        near = rows[(away_rad - half_rad < reach_rad) & (rows < count - 1)]
        cell = np.repeat(near, FINER)
        u_s = np.tile(np.arange(FINER) * (COMMAND_STEP_S / FINER), len(near))
        finer_rad = _away_rad(table, judge, ephemeris, cone, cell, u_s)
        every_rad = np.concatenate([away_rad, finer_rad])
        t_s = np.concatenate([rows / ROWS_PER_S, cell / ROWS_PER_S + u_s])
        least = int(np.argmin(every_rad))
        counts = math.isfinite(every_rad[least])
        margins.append(
            KeepOutMargin(
                number=number,
                about=cone.about,
                half_angle_rad=half_rad,
                away_min_rad=float(every_rad[least]) if counts else None,
                t_s=float(t_s[least]) if counts else None,
                at_utc=shifted_utc(table.epoch_utc, float(t_s[least])) if counts else None,
            )
        )
    return tuple(margins)


def _away_rad(
    table: CommandTable,
    judge: Judge,
    ephemeris: Ephemeris,
    cone: KeepOut,
    cell: Indices,
    u_s: Array,
) -> Array:
    """From boresight to the cone's axis, u_s after the rows; infinite where it doesn't count.

    The last row ends a cell and begins none.
    """
    is_last = cell == len(table.t_s) - 1
    begins, into_s = np.where(is_last, cell - 1, cell), np.where(is_last, COMMAND_STEP_S, u_s)
    away_rad = np.empty(len(cell))
    for first in range(0, len(cell), ROWS_AT_ONCE):
        part = slice(first, first + ROWS_AT_ONCE)
        instants = Instants(table.epoch_utc, cell[part] / ROWS_PER_S + u_s[part])
        states = ephemeris.states(instants)
        at = FlownInstants(begins[part], into_s[part], instants)
        boresight_eci = judge.boresight_eci(at, states)
        axis_eci, counts = _axis_eci(cone, judge, at, states)
        away_rad[part] = np.where(counts, apart_rad(axis_eci, boresight_eci), np.inf)
    return away_rad


def _axis_eci(
    cone: KeepOut, judge: Judge, at: FlownInstants, states: OrbitStates
) -> tuple[Array, Mask]:
    """Of the cone: vectors (n, 3), and whether it counts (n,)."""
    always = np.ones(len(at.cell), dtype=bool)
    if cone.direction_platform is not None:
        return judge.direction_eci(np.asarray(cone.direction_platform), at, states), always
    if cone.body is not None:
        sight = sky_sight(BodyTarget(name=cone.body, grazing_altitude_km=0.0), at.instants, states)
        return sight.apparent_eci, sight.clearance_rad > -HIDDEN_RAD
    if cone.direction_lvlh is not None:
        return eci_from_lvlh(np.tile(cone.direction_lvlh, (len(always), 1)), states), always
    if cone.ra_deg is None or cone.dec_deg is None:
        raise TypeError("a cone without a direction has no axis")
    axis = erfa.s2c(math.radians(cone.ra_deg), math.radians(cone.dec_deg))
    return np.tile(axis, (len(always), 1)), always
