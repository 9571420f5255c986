"""Sensors of a body: its attitude as a quaternion, and its gyros' rates.

What is compared are the angles by which the body has turned about its own axes since the first
row, the integrals of its rates: near the plan they differ from the planned ones by the small
turn between both attitudes.  A quaternion is read in any of four ways, scalar first or last and
from the body or onto it, whichever moves as the plan does.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import COMMAND_STEP_S, CommandTable, axis_channels
from planner.base.errors import InvalidInput
from planner.base.rotation import Rotation
from planner.base.table_motion import body_motion_at
from planner.inflight.telemetry.clock import OPTIONS as CLOCK
from planner.inflight.telemetry.clock import offsets_s
from planner.inflight.telemetry.estimates import Estimate
from planner.inflight.telemetry.following import MotionBounds, PlannedMotion
from planner.inflight.telemetry.platforms.sensors import (
    ClockAssumptions,
    Parameter,
    PlatformFound,
    PointingParts,
    ReadColumns,
    ToldColumn,
    ToldKind,
)
from planner.inflight.telemetry.samples import (
    ColumnContract,
    ColumnMeaning,
    ImageOffset,
    TelemetryColumn,
    angle_meanings,
    other_units,
)
from planner.world.attitude.corrections import AttitudeCorrection
from planner.world.plan import FlightPlan
from planner.world.platforms import BodyPlatform

if TYPE_CHECKING:
    from planner.inflight.telemetry.compare import Comparison


@dataclass(frozen=True, kw_only=True)
class AttitudeOptions:
    """How a quaternion is read, and its clock set before the angles are compared."""

    norm_off_max: float = 0.01  # of one: digits lose less, a broken part more
    rows: int = 4000  # with which the clock is set, evenly
    rounds: int = 5  # of it: each squares what the one before was off by
    offset_sigma_s: float = 0.4  # the step between the offsets tried
    drift_sigma: float = 1e-3  # worse ones are no clocks
    robust: float = 2.0  # sigmas; beyond them an error counts by its size


OPTIONS = AttitudeOptions()
_ARCSEC_PER_RAD = math.degrees(1.0) * 3600.0
_PARTS = "xyzw"


class QuaternionOrder(NamedTuple):
    """scalar_first: else last.  from_eci: turns ECI's vectors into the body's, else the body's."""

    scalar_first: bool
    from_eci: bool

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the four columns in their order."""
        frames = "body_from_eci" if self.from_eci else "eci_from_body"
        letters = "wxyz" if self.scalar_first else _PARTS
        return tuple(f"q_{frames}_{letter}" for letter in letters)

    def q_eci_from_body_xyzw(self, sent_xyzw: Array) -> Array:
        """Of parts as they were sent, (n, 4)."""
        q_xyzw = np.roll(sent_xyzw, -1, axis=1) if self.scalar_first else sent_xyzw
        return q_xyzw * np.array([-1.0, -1.0, -1.0, 1.0]) if self.from_eci else q_xyzw


ORDERS = tuple(QuaternionOrder(first, eci) for first in (False, True) for eci in (False, True))


def _contract() -> ColumnContract:
    meanings: dict[str, ColumnMeaning] = {}
    for part, letter in enumerate(_PARTS):
        meaning = ColumnMeaning(axis=part, kind="angle", unit="1")
        meanings |= {f"q_{part + 1}": meaning, f"q_eci_from_body_{letter}": meaning}
    for axis, letter in enumerate("xyz"):
        meanings |= angle_meanings(f"omega_body_{{}}_s_{letter}", axis, "rate")
    return ColumnContract(
        meanings=meanings,
        wanted="q_1, q_2, q_3, q_4, omega_body_deg_s_x, omega_body_deg_s_y, omega_body_deg_s_z, "
        f"rates also {other_units()}",
        least="the four parts of the attitude's quaternion or a rate about x, y or z",
        first=("q_1", "is required with q_2, q_3 and q_4, or rates such as omega_body_deg_s_x"),
        guesses=tuple((f"q_{part}", f"q{part}") for part in (1, 2, 3, 4)),
    )


class BodySensors:
    """A star tracker's quaternion, a gyro's rates in body axes, or both."""

    contract = _contract()
    assumes = ClockAssumptions(
        earliest="one axis is on time; biases, lag of each and the gyro's gain are estimated "
        "beside it",
        equally_late="all axes are equally late; biases and the gyro's gain are estimated beside "
        "it",
        ideal="no lag and a gyro's gains of one, neither of which is seen; each bias is estimated",
    )

    def __init__(self, plan: FlightPlan) -> None:
        platform = plan.scenario.platform
        assert isinstance(platform, BodyPlatform)  # the registry's kind
        self.plan, self.platform = plan, platform
        self.turned = turned_table(plan.table)
        self.motions = tuple(PlannedMotion(self.turned, axis) for axis in range(3))

    @property
    def bounds(self) -> tuple[MotionBounds, ...]:
        """Of agility; one of a vector's length is asked of each axis by itself."""
        rate, acceleration, _ = self.platform.envelope.by_order_rad.tolist()
        return tuple(
            MotionBounds(angle_rad=None, rate_rad_s=most, acceleration_rad_s2=faster)
            for most, faster in zip(rate, acceleration, strict=True)
        )

    def read(self, columns: Sequence[TelemetryColumn], tag_s: Array) -> ReadColumns:
        """Rates as they are; a quaternion as three angles, with the order that suits it best."""
        rates = [one for one in columns if one.meaning.unit != "1"]
        parts = {one.meaning.axis: one for one in columns if one.meaning.unit == "1"}
        told = [
            ToldColumn(name=r.name, axis="xyz"[r.meaning.axis], kind="rate", unit=r.meaning.unit)
            for r in rates
        ]
        if not parts:
            return ReadColumns(columns, tuple(told))
        if len(parts) < len(_PARTS):
            lost = ", ".join(f"q_{part + 1}" for part in range(4) if part not in parts)
            raise InvalidInput(
                f"an attitude has four parts, and {lost} hold nothing: send all of them, or rates "
                "alone",
                field="samples",
            )
        sent = np.column_stack([parts[part].value for part in range(4)])
        norm = np.linalg.norm(sent, axis=1)
        is_whole = np.abs(norm - 1.0) < OPTIONS.norm_off_max  # False for NaN
        sent[~is_whole] = np.nan
        order, offset_s = self._best_order(sent, tag_s)
        kind: ToldKind = "attitude"
        names = dict(zip(range(4), order.parts, strict=True))
        told += [
            ToldColumn(name=parts[k].name, axis=names[k], kind=kind, unit="1") for k in range(4)
        ]
        angles = [
            TelemetryColumn(
                name=f"attitude about {letter}",
                meaning=ColumnMeaning(axis=axis, kind="angle", unit="rad"),
                value=value,
            )
            for axis, (letter, value) in enumerate(
                zip("xyz", self._angles_rad(order, sent, tag_s, offset_s).T, strict=True)
            )
        ]
        return ReadColumns([*angles, *rates], tuple(told), _notes(parts, order, norm, is_whole))

    def _best_order(self, sent_xyzw: Array, tag_s: Array) -> tuple[QuaternionOrder, float]:
        """And about what the clock's offset is."""
        reach_s = CLOCK.offset_max_s
        near = (tag_s > -reach_s) & (tag_s < self.motions[0].stop_s + reach_s)
        rows = _evenly(np.flatnonzero(np.isfinite(sent_xyzw[:, 0]) & near), CLOCK.rows)
        if not len(rows):
            return ORDERS[0], 0.0
        t_s = tag_s[rows] - offsets_s()[:, None]
        table = self.plan.table
        # Straight lines between rows do here.
        planned = np.stack([np.interp(t_s, table.t_s, part) for part in table.position.T], axis=-1)
        planned /= np.linalg.norm(planned, axis=-1, keepdims=True)
        room_rad = max(float(np.linalg.norm(np.std(self.turned.position, axis=0))), CLOCK.still_rad)
        is_within = self.motions[0].is_within(t_s)
        found = []
        for order in ORDERS:
            q_xyzw = order.q_eci_from_body_xyzw(sent_xyzw[rows])
            likeness = np.abs(np.einsum("ork,rk->or", planned, q_xyzw)).clip(0.0, 1.0)
            share = np.minimum(2.0 * np.arccos(likeness) / room_rad, 1.0)
            misfit = np.where(is_within, share, 0.5).mean(axis=1)
            # Of equals, as in a steady attitude, the least offset.
            least = np.flatnonzero(misfit <= misfit.min() + 1e-9)
            found.append((float(misfit.min()), order, min(offsets_s()[least].tolist(), key=abs)))
        _, order, offset_s = min(found, key=lambda one: one[0])
        return order, offset_s

    def _angles_rad(
        self, order: QuaternionOrder, sent_xyzw: Array, tag_s: Array, offset_s: float
    ) -> Array:
        """Turned about the body's axes, (n, 3); a row that repeats the one before stays equal."""
        rows = np.flatnonzero(np.isfinite(sent_xyzw[:, 0]) & np.isfinite(tag_s))
        rows = rows[np.argsort(tag_s[rows], kind="stable")]
        q_xyzw = order.q_eci_from_body_xyzw(sent_xyzw[rows])
        few = _evenly(np.arange(len(rows)), OPTIONS.rows)
        drift = 0.0
        for _ in range(OPTIONS.rounds):
            t_s = (tag_s[rows[few]] - offset_s) / (1.0 + drift)
            inside = self.motions[0].is_within(t_s)
            off_rad, omega_rad_s = self._off_rad(q_xyzw[few][inside], t_s[inside])
            late_s, gained = _late(off_rad, omega_rad_s, t_s[inside], drift)
            offset_s, drift = offset_s + late_s, drift + gained
        t_s = (tag_s[rows] - offset_s) / (1.0 + drift)
        off_rad, _ = self._off_rad(q_xyzw, t_s)
        own = np.column_stack([motion.angle_rad(t_s) for motion in self.motions]) + off_rad
        is_new = np.ones(len(rows), dtype=bool)
        is_new[1:] = (np.diff(sent_xyzw[rows], axis=0) != 0.0).any(axis=1)
        own = own[np.maximum.accumulate(np.where(is_new, np.arange(len(rows)), 0))]
        angles_rad = np.full((len(tag_s), 3), np.nan)
        angles_rad[rows] = own
        return angles_rad

    def _off_rad(self, q_xyzw: Array, t_s: Array) -> tuple[Array, Array]:
        """The small turn from the planned attitude to a measured one, and the planned rate, in body
        axes, (n, 3) each."""
        table = self.plan.table
        assert table.acceleration_rad_s2 is not None  # a body's
        q_eci_from_body, moved = body_motion_at(
            table.position, table.rate_rad_s, table.acceleration_rad_s2, t_s
        )
        turn = q_eci_from_body.inv() * Rotation.from_quat(q_xyzw)
        return np.asarray(turn.as_rotvec()), moved.omega_body_rad_s

    def pointing(
        self,
        comparison: Comparison,
        corrections: Sequence[AttitudeCorrection],
        image_offsets: Sequence[ImageOffset],
    ) -> list[PointingParts]:
        """None: a body has no carrier whose attitude a law would state."""
        for field, asked in (("corrections", corrections), ("image_offsets", image_offsets)):
            if asked:
                raise InvalidInput(
                    f"correct the attitude of a carrier, and {self.platform.name} steers itself: "
                    "leave them out; its telemetry tells its own attitude",
                    field=field,
                )
        return []

    def found(self, comparison: Comparison, names: Sequence[str]) -> PlatformFound | None:
        """How far its control lets it wander, and how long."""
        if names:
            raise InvalidInput(
                f"names parameters of drives, and {self.platform.name} has none: leave it out; how "
                "its attitude wanders is found without",
                field="identify",
            )
        knowledge = self.platform.knowledge
        sigma_rad = _mean([one.wander_rad for one in comparison.axes if one.wander_rad])
        half_life_s = _mean(
            [one.wander_half_life_s for one in comparison.axes if one.wander_half_life_s]
        )
        if sigma_rad is None or half_life_s is None:
            return None
        control = Parameter(
            name="knowledge.control_sigma_arcsec",
            planned=knowledge.control_sigma_arcsec,
            found=sigma_rad.value * _ARCSEC_PER_RAD,
            sigma=sigma_rad.sigma * _ARCSEC_PER_RAD,
        )
        forgets = Parameter(
            name="knowledge.correlation_s",
            planned=knowledge.correlation_s,
            found=half_life_s.value,
            sigma=half_life_s.sigma,
        )
        learnt = replace(
            knowledge,
            control_sigma_arcsec=control.found,
            correlation_s=forgets.found,
        )
        return PlatformFound(
            parameters=(control, forgets), platform=replace(self.platform, knowledge=learnt)
        )


def turned_table(table: CommandTable) -> CommandTable:
    """The body's table with angles turned about x, y and z since the first row for its attitude:
    integrals of the rates that it flies between rows, by Gauss and Legendre's three points."""
    node, weight = np.polynomial.legendre.leggauss(3)
    t_s = table.t_s[:-1, None] + 0.5 * COMMAND_STEP_S * (1.0 + node)
    assert table.acceleration_rad_s2 is not None  # a body's
    _, moved = body_motion_at(
        table.position, table.rate_rad_s, table.acceleration_rad_s2, t_s.ravel()
    )
    omega_rad_s = moved.omega_body_rad_s.reshape(*t_s.shape, 3)
    step_rad = 0.5 * COMMAND_STEP_S * np.einsum("k,nkj->nj", weight, omega_rad_s)
    return replace(
        table,
        channels=axis_channels(table.dof_names),
        position=np.concatenate([np.zeros((1, 3)), np.cumsum(step_rad, axis=0)]),
    )


def _late(
    off_rad: Array, omega_rad_s: Array, t_s: Array, drift_share: float
) -> tuple[float, float]:
    """By how much the clock is farther ahead, and gains more, than it was set to: robust least
    squares of small turns (n, 3), with a bias of each."""
    if not len(t_s):
        return 0.0, 0.0
    biases = np.tile(np.eye(3), (len(t_s), 1))
    slope = np.column_stack([-omega_rad_s.ravel(), (-omega_rad_s * t_s[:, None]).ravel(), biases])
    off = off_rad.ravel()
    parts = np.array([0.0, 0.0, *np.median(off_rad, axis=0)])
    before = np.array([0.0, -drift_share, *parts[2:]])
    weights = (
        np.array([OPTIONS.offset_sigma_s, OPTIONS.drift_sigma, np.inf, np.inf, np.inf]) ** -2.0
    )
    for _ in range(OPTIONS.rounds):
        left = off - slope @ parts
        scale = 1.4826 * float(np.median(np.abs(left))) + 1e-12
        share = np.minimum(1.0, OPTIONS.robust * scale / np.maximum(np.abs(left), 1e-300))
        weighted = slope * (share / scale**2)[:, None]
        normal = weighted.T @ slope + np.diag(weights)
        parts = np.linalg.solve(normal, weighted.T @ off + weights * before)
    return float(parts[0]), float(parts[1])


def _mean(found: Sequence[Estimate]) -> Estimate | None:
    """Of estimates of the same, each by its share of error, as that grows with the value; None of
    none."""
    if not found:
        return None
    weights = np.array([(one.value / one.sigma) ** 2 for one in found])
    value = math.exp(float(weights @ np.log([one.value for one in found]) / weights.sum()))
    return Estimate(value=value, sigma=value * float(weights.sum() ** -0.5))


def _evenly(rows: Indices, most: int) -> Indices:
    """At most so many of them."""
    if len(rows) <= most:
        return rows
    return rows[np.linspace(0, len(rows) - 1, most).round().astype(np.intp)]


def _notes(
    parts: dict[int, TelemetryColumn], order: QuaternionOrder, norm_value: Array, is_whole: Mask
) -> tuple[str, ...]:
    notes = []
    broken = int(np.sum(np.isfinite(norm_value) & ~is_whole))
    if broken:
        notes.append(f"{broken} rows of the attitude are no unit quaternions and were left out")
    if order != ORDERS[0] and parts[0].name.lower() == ORDERS[0].parts[0]:
        notes.append(
            f"the attitude fits the plan as {', '.join(order.parts)}, in its columns' order, and "
            "not as they are named: it was read so"
        )
    return tuple(notes)
