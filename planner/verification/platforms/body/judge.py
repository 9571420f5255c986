"""The judge of a body: quaternions, rates and accelerations, and the quintic between their rows."""

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np

from planner.base.arrays import Array, Indices, Mask, cross
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, Channel, CommandTable
from planner.verification.directions import apart_rad, rotation_matrix
from planner.verification.earth_fixed import earth_fixed_sight
from planner.verification.platforms.body.exclusions import exclusion_margins
from planner.verification.platforms.body.gyros import gimbal_row_findings, gyro_margins
from planner.verification.platforms.body.idle import idle_axes_eci, idle_motion
from planner.verification.platforms.body.limits import body_margins, sizes_limited
from planner.verification.platforms.body.options import OPTIONS
from planner.verification.platforms.body.quintic import FlownMotion, motion_between, turned
from planner.verification.platforms.body.roll import roll_off_rad
from planner.verification.platforms.judge import FlownInstants, JudgedSession
from planner.verification.report import (
    ExclusionMargin,
    Finding,
    GyroMargin,
    KeepOutMargin,
    Limit,
    LimitMargin,
    MaskMargin,
    SlowStretch,
    table_fault,
)
from planner.verification.sky import LIMB_MODEL_SHARE, sky_sight
from planner.verification.structure import covers, session_rows
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.platforms.body import BodyPlatform
from planner.world.scenario import Scenario, Session
from planner.world.targets import BenchMotionTarget, EarthFixedTarget, SkyTarget, StationTarget


class BodyJudge:
    """Of a spacecraft that turns as a whole."""

    def __init__(self, table: CommandTable, scenario: Scenario) -> None:
        assert isinstance(scenario.platform, BodyPlatform)  # by the registry
        self._table, self._platform, self._scenario = table, scenario.platform, scenario
        self._last: tuple[FlownInstants, FlownMotion] | None = None

    def fault(self) -> Finding | None:
        """Of the columns their names, shapes and numbers; of the quaternions length and sign."""
        table, expected = self._table, self._platform.channels
        if table.channels != expected:
            return table_fault(
                f"the columns are {_names(table.channels)}, the platform's {_names(expected)}"
            )
        columns = (table.position, table.rate_rad_s, table.acceleration_rad_s2)
        shapes = tuple(None if column is None else column.shape for column in columns)
        count = len(table.position)
        if table.acceleration_rad_s2 is None or shapes != ((count, 4), (count, 3), (count, 3)):
            return table_fault(
                f"arrays of shapes {', '.join(map(str, shapes))} are no table of quaternions, "
                "rates and accelerations"
            )
        if count < OPTIONS.rows_min:
            return table_fault(f"a table needs at least {OPTIONS.rows_min} rows, not {count}")
        extra_rad = np.zeros((count, 0)) if table.extra_rad is None else table.extra_rad
        told = sum(channel.of == "extra" for channel in expected)
        if extra_rad.shape != (count, told):
            return table_fault(f"an array of shape {extra_rad.shape} doesn't tell {told} columns")
        numbers = np.hstack(
            [table.position, table.rate_rad_s, table.acceleration_rad_s2, extra_rad]
        )
        finite = np.isfinite(numbers)
        if not finite.all():
            row, column = (int(index) for index in np.argwhere(~finite)[0])
            name = expected[column].name
            return self._of_row("table", row, f"row {row} of {name} holds no finite number")
        lengths = np.linalg.norm(table.position, axis=1)
        off = np.abs(lengths - 1.0)
        worst = int(np.argmax(off))
        if off[worst] > OPTIONS.unit:
            length = f"{lengths[worst]:.12g}"
            return self._of_row("table", worst, f"the quaternion of row {worst} is {length} long")
        same = np.sum(table.position[1:] * table.position[:-1], axis=1)
        if not (same > 0.0).all():
            row = int(np.argmax(~(same > 0.0))) + 1
            return self._of_row(
                "table",
                row,
                f"the quaternion of row {row} stands across or against the one before: the "
                "attitude jumps, or its sign does",
            )
        return None

    def row_findings(self) -> Iterator[Finding]:
        """Whether attitude, rates and accelerations tell one motion, between the ends asked for,
        and the gimbals of gyros, where there are some, theirs."""
        yield from self._incoherent()
        if self._platform.gyros is not None:
            yield from gimbal_row_findings(self._table)
        ends: list[tuple[Limit, str, int]] = [("initial_state", "row 0", 0)]
        if self._scenario.final_state is not None:
            ends.append(("final_state", "the last row", len(self._table.position) - 1))
        begin = self._scenario.initial_state
        for limit, name, row in ends:
            where = "the idle attitude"
            if limit == "initial_state" and begin.q_body_from_eci_xyzw is not None:
                where = "what is asked for"
                axes_eci = rotation_matrix(begin.q_body_from_eci_xyzw)
                omega_body_rad_s = np.radians(begin.omega_body_deg_s or np.zeros(3))
            else:
                axes_eci, omega_body_rad_s = idle_motion(
                    self._platform.idle, self._table.epoch_utc, row / ROWS_PER_S, self._ephemeris
                )
            q_xyzw = np.repeat(self._table.position[[row]], 3, axis=0)
            off_rad = float(apart_rad(turned(q_xyzw, np.eye(3)), axes_eci).max())
            rate_off_rad_s = float(np.linalg.norm(self._table.rate_rad_s[row] - omega_body_rad_s))
            if off_rad > OPTIONS.end_rad or rate_off_rad_s > OPTIONS.end_rad_s:
                yield self._of_row(
                    limit,
                    row,
                    f"{name} is {math.degrees(off_rad):.3g} deg and "
                    f"{math.degrees(rate_off_rad_s):.3g} deg/s from {where}",
                )
        if begin.q_body_from_eci_xyzw is None:
            return
        asked_rad_s2 = np.radians(begin.alpha_body_deg_s2 or np.zeros(3))
        off_rad_s2 = float(np.linalg.norm(self._row_alpha_rad_s2[0] - asked_rad_s2))
        if off_rad_s2 > OPTIONS.end_rad_s2:
            yield self._of_row(
                "initial_state",
                0,
                f"row 0 is {math.degrees(off_rad_s2):.3g} deg/s2 from the acceleration asked for",
            )

    def margins(self) -> tuple[LimitMargin, ...]:
        """Of rate, acceleration and jerk, by magnitude or by body axis."""
        t_s, flown = self._fine
        return tuple(
            body_margins(
                self._platform.envelope, flown, t_s, self._row_alpha_rad_s2, self._table.epoch_utc
            )
        )

    def keep_out(self) -> tuple[KeepOutMargin, ...]:
        """None: a body has exclusions."""
        return ()

    def masks(self) -> tuple[MaskMargin, ...]:
        """None: the structure turns with the camera."""
        return ()

    def gyros(self) -> tuple[GyroMargin, ...]:
        """None without gyros."""
        gyros, inertia_kg_m2 = self._platform.gyros, np.array(self._platform.inertia_kg_m2)
        if gyros is None:
            return ()
        return gyro_margins(self._table, self._between, gyros, inertia_kg_m2, self._ephemeris)

    def exclusions(self) -> tuple[ExclusionMargin, ...]:
        """Of each exclusion of the platform, and of the star trackers it needs."""
        table, count = self._table, len(self._table.position)
        imaging = np.zeros(count - 1, dtype=bool)
        for session in self._scenario.sessions:
            rows = session_rows(session, table.epoch_utc)
            if covers(table, rows) and not isinstance(session.target, StationTarget):
                imaging[rows[0] : rows[-1]] = True
        return exclusion_margins(self, self._platform, self._ephemeris, imaging, table.epoch_utc)

    def slow_stretches(self, cells: Mask, *, standing: bool) -> Iterator[SlowStretch]:
        """None: no drive of it has a least rate."""
        return iter(())

    def boresight_eci(self, at: FlownInstants, states: OrbitStates) -> Array:
        """Of the camera."""
        boresight_body = np.asarray(self._platform.camera.boresight_body)
        return self.direction_eci(boresight_body, at, states)

    def direction_eci(self, direction: Array, at: FlownInstants, states: OrbitStates) -> Array:
        """Of a direction in body axes, as a unit vector."""
        unit = direction / math.hypot(*direction)
        return turned(self._motion(at).q_eci_from_body_xyzw, unit)

    def is_idle_at(self, rows: Indices) -> Mask:
        """Where each body axis lies as in the idle attitude."""
        instants = Instants(self._table.epoch_utc, rows / ROWS_PER_S)
        idle_eci = idle_axes_eci(self._platform.idle, instants, self._ephemeris)
        axes = np.tile(np.eye(3), (len(rows), 1))
        flown_eci = turned(np.repeat(self._table.position[rows], 3, axis=0), axes)
        off_rad = apart_rad(flown_eci, idle_eci.reshape(-1, 3))
        return np.asarray(off_rad.reshape(-1, 3).max(axis=1) <= OPTIONS.end_rad)

    def turn_most_rad(self) -> Array:
        """By the greatest rate and acceleration of the cell that begins with each row."""
        rate_rad_s = np.linalg.norm(self._table.rate_rad_s, axis=1)
        most_rad_s2 = float(np.linalg.norm(self._fine[1].alpha_body_rad_s2, axis=1).max())
        return np.asarray(COMMAND_STEP_S * (rate_rad_s + COMMAND_STEP_S * most_rad_s2))

    def session_findings(
        self, number: int, at: FlownInstants, states: OrbitStates
    ) -> Iterator[Finding]:
        """Whether the camera lies off its roll rule, looks at the Earth too far off nadir, or
        hasn't settled."""
        session, flown = self._scenario.sessions[number], self._motion(at)
        yield from self._unsettled(number, session)
        roll_rad = roll_off_rad(self._platform, session, at.instants, states, flown)
        if roll_rad.max() > OPTIONS.roll_rad:
            told = "lies {:.3g} deg off its roll rule"
            yield self._finding_at_most("roll", roll_rad, at, number, told)
        target = session.target
        if isinstance(target, StationTarget) or not isinstance(target, EarthFixedTarget):
            return  # nothing on the Earth is imaged
        most_rad = math.radians(self._platform.off_nadir_max_deg)
        off_rad = apart_rad(-states.r_sat_eci_m, self.boresight_eci(at, states))
        if off_rad.max() > most_rad + OPTIONS.off_nadir_rad:
            most = f"more than {self._platform.off_nadir_max_deg:g} deg"
            told = f"looks {{:.3f}} deg off nadir, {most}"
            yield self._finding_at_most("off_nadir", off_rad, at, number, told)

    def _unsettled(self, number: int, session: Session) -> Iterator[Finding]:
        """Where, before a session, the camera doesn't stand yet on the target in sight."""
        first = 2 * session_rows(session, self._table.epoch_utc)[0]
        points = np.arange(first - 2 * int(self._platform.envelope.settle_s * ROWS_PER_S), first)
        points = points[points >= 0]
        if not points.size:
            return
        instants = Instants(self._table.epoch_utc, points / (2 * ROWS_PER_S))
        u_s = np.where(points % 2, COMMAND_STEP_S / 2.0, 0.0)
        at = FlownInstants(points // 2, u_s, instants)
        states, target = self._ephemeris.states(instants), session.target
        boresight_eci = self.boresight_eci(at, states)
        if isinstance(target, EarthFixedTarget):
            off_rad = apart_rad(
                earth_fixed_sight(target, instants, states).apparent_eci, boresight_eci
            )
        else:
            assert isinstance(target, SkyTarget)  # `prescribed` judges the others
            sky = sky_sight(target, instants, states)
            off_rad = apart_rad(sky.apparent_eci, boresight_eci)
            off_rad -= LIMB_MODEL_SHARE * sky.bending_rad
            off_rad[sky.clearance_rad < 0.0] = 0.0
        if off_rad.max() > OPTIONS.off_nadir_rad:
            told = (
                f"stands {{:.3g}} deg off the target in the {self._platform.envelope.settle_s:g} s"
            )
            yield self._finding_at_most(
                "pointing", off_rad, at, number, f"{told} in which it settles"
            )

    def _finding_at_most(
        self, limit: Limit, off_rad: Array, at: FlownInstants, number: int, told: str
    ) -> Finding:
        """Of a session, where an angle is greatest; told: of the camera, with its degrees."""
        worst = int(np.argmax(off_rad))
        t_s = float(at.instants.t_s[worst])
        return Finding(
            limit=limit,
            t_s=t_s,
            at_utc=shifted_utc(self._table.epoch_utc, t_s),
            detail=f"session {number + 1}: the camera " + told.format(math.degrees(off_rad[worst])),
        )

    def prescribed(self, number: int, rows: range, target: BenchMotionTarget) -> JudgedSession:
        """A body has no axes to prescribe a motion of."""
        detail = f"session {number + 1}: {self._platform.name} has no axes that a test could move"
        return None, (Finding(limit="motion", detail=detail),)

    @property
    def derives_attitude(self) -> bool:
        """It is in the table itself."""
        return True

    @cached_property
    def _row_alpha_rad_s2(self) -> Array:
        alpha_rad_s2 = self._table.acceleration_rad_s2
        if alpha_rad_s2 is None:
            raise TypeError("a table without accelerations is at fault already")
        return alpha_rad_s2

    @cached_property
    def _ephemeris(self) -> Ephemeris:
        """Over the table, and the step around it that idle rates are found by."""
        last_s = (len(self._table.position) - 1) / ROWS_PER_S
        return self._scenario.orbit.ephemeris(
            shifted_utc(self._table.epoch_utc, -OPTIONS.idle_difference_s),
            shifted_utc(self._table.epoch_utc, last_s + OPTIONS.idle_difference_s),
        )

    @cached_property
    def _fine(self) -> tuple[Array, FlownMotion]:
        """Every row, and a few instants of each cell in which the rate or the acceleration of an
        axis can be greater than on all rows; with their times, (n,)."""
        table, alpha_rad_s2, h = self._table, self._row_alpha_rad_s2, COMMAND_STEP_S
        turn_off_rad, rate_off_rad_s = self._disagreements
        rate, acceleration = (
            _greater_ends(_length(rows)[:, None]) for rows in (table.rate_rad_s, alpha_rad_s2)
        )
        strays_rad_s2 = h * rate * acceleration + h**2 * rate**3
        strays_rad_s2 += OPTIONS.turn_within / h**2 * turn_off_rad[:, None]
        strays_rad_s2 += OPTIONS.rate_within / h * rate_off_rad_s[:, None]
        strays_rad_s = h * (acceleration + strays_rad_s2)
        looked = np.zeros(len(rate), dtype=bool)
        for rows, strays in ((table.rate_rad_s, strays_rad_s), (alpha_rad_s2, strays_rad_s2)):
            sizes = np.abs(sizes_limited(self._platform.envelope, rows))
            looked |= np.any(_greater_ends(sizes) + strays >= sizes.max(axis=0), axis=1)
        cell = np.repeat(np.flatnonzero(looked), OPTIONS.points_per_cell - 1)
        shares = np.arange(1, OPTIONS.points_per_cell) / OPTIONS.points_per_cell
        u_s = np.tile(shares * h, np.count_nonzero(looked))
        between = self._between(cell, u_s)
        on_rows = FlownMotion(table.position, table.rate_rad_s, alpha_rad_s2)
        flown = FlownMotion(*(np.concatenate(two) for two in zip(on_rows, between, strict=True)))
        return np.concatenate([table.t_s, cell / ROWS_PER_S + u_s]), flown

    def _motion(self, at: FlownInstants) -> FlownMotion:
        """The last one is kept: many directions are asked for at the same instants."""
        if self._last is None or self._last[0] is not at:
            self._last = at, self._between(at.cell, at.u_s)
        return self._last[1]

    def _between(self, cell: Indices, u_s: Array) -> FlownMotion:
        return motion_between(
            self._table.position, self._table.rate_rad_s, self._row_alpha_rad_s2, cell, u_s
        )

    def _incoherent(self) -> Iterator[Finding]:
        """Where rows of a cell tell more than one motion within the jerk limit can differ by."""
        h = COMMAND_STEP_S
        jerk_rad_s3 = float(np.linalg.norm(self._platform.envelope.by_order_rad[2]))
        turn_off_rad, rate_off_rad_s = self._disagreements
        for what, unit, missed, allowed in (
            (
                "attitude and rates",
                "deg",
                turn_off_rad,
                OPTIONS.turn_miss * jerk_rad_s3 * h**3 + OPTIONS.rounding_rad,
            ),
            (
                "rates and accelerations",
                "deg/s",
                rate_off_rad_s,
                OPTIONS.rate_miss * jerk_rad_s3 * h**2 + OPTIONS.rounding_rad,
            ),
        ):
            worst = int(np.argmax(missed))
            if missed[worst] > allowed:
                yield self._of_row(
                    "motion",
                    worst,
                    f"{what} disagree by {math.degrees(missed[worst]):.3g} {unit} over the cell "
                    f"after row {worst}, more than {math.degrees(allowed):.3g} {unit}",
                )

    @cached_property
    def _disagreements(self) -> tuple[Array, Array]:
        """By how much the turn over each cell differs from what rates and accelerations at its ends
        tell, rad, and its change of rate from what accelerations tell, rad/s, (n - 1,) each.

        The rotation vector of a short step is the mean rate, from rates and accelerations at its
        ends, plus the coning of the rates.  Source: Bortz 1971, to third order in the step.
        """
        omega, alpha, h = self._table.rate_rad_s, self._row_alpha_rad_s2, COMMAND_STEP_S
        part, scalar = _turn_over_cells(self._table.position)
        turn_rad = (
            part
            * (2.0 * np.arctan2(_length(part), scalar) / np.maximum(_length(part), 1e-300))[:, None]
        )
        mean_rad_s = 0.5 * (omega[1:] + omega[:-1]) + h / 12.0 * (alpha[:-1] - alpha[1:])
        expected_rad = h * mean_rad_s + h**2 / 12.0 * cross(omega[:-1], omega[1:])
        change_rad_s = np.diff(omega, axis=0) - 0.5 * h * (alpha[1:] + alpha[:-1])
        return _length(turn_rad - expected_rad), _length(change_rad_s)

    def _of_row(self, limit: Limit, row: int, detail: str) -> Finding:
        t_s = row / ROWS_PER_S
        at_utc = shifted_utc(self._table.epoch_utc, t_s)
        return Finding(limit=limit, t_s=t_s, at_utc=at_utc, detail=detail)


def _names(channels: tuple[Channel, ...]) -> str:
    return ", ".join(channel.name for channel in channels)


def _greater_ends(size: Array) -> Array:
    """Of each cell the greater of its two rows, of (n, k) rows, (n - 1, k)."""
    return np.maximum(size[:-1], size[1:])


def _length(value: Array) -> Array:
    return np.asarray(np.linalg.norm(value, axis=1))


def _turn_over_cells(q_eci_from_body_xyzw: Array) -> tuple[Array, Array]:
    """Vector part (n - 1, 3) and scalar (n - 1,) of turns from row to row, the short way."""
    a, b = q_eci_from_body_xyzw[:-1], q_eci_from_body_xyzw[1:]
    part = a[:, 3:] * b[:, :3] - b[:, 3:] * a[:, :3] - cross(a[:, :3], b[:, :3])
    return part, np.sum(a * b, axis=1)
