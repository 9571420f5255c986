"""The slew of a whole body to solve: where it begins, the rows it may arrive at, its limits."""

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S, Motion
from planner.base.errors import InfeasibleSlew, figures
from planner.base.mrp import BodyMotion, MrpState, body_motion, mrp_state, quintic
from planner.base.rotation import Rotation

Objective = Literal["smooth", "minimum_time", "any"]
LimitKind = Literal["magnitude", "axis", "gyros"]
ORDERS = ("rate", "acceleration", "jerk")
UNIT_TEXTS = ("deg/s", "deg/s2", "deg/s3")


@dataclass(frozen=True, eq=False, kw_only=True)
class AgilityLimits:
    """Limits of body rate, acceleration and jerk, at every instant.

    kind: "magnitude", of the vectors' lengths; "axis", of each component in body axes; or "gyros",
    of the rate's components and of ellipsoids around the others, whose semi-axes are given.
    rate_rad_s, acceleration_rad_s2, jerk_rad_s3: (3,), by body axis; of lengths three times one.
    """

    kind: LimitKind
    rate_rad_s: Array
    acceleration_rad_s2: Array
    jerk_rad_s3: Array

    @classmethod
    def of_magnitudes(
        cls, rate_rad_s: float, acceleration_rad_s2: float, jerk_rad_s3: float
    ) -> "AgilityLimits":
        """Limits of the vectors' lengths."""
        return cls(
            kind="magnitude",
            rate_rad_s=np.full(3, rate_rad_s),
            acceleration_rad_s2=np.full(3, acceleration_rad_s2),
            jerk_rad_s3=np.full(3, jerk_rad_s3),
        )

    @cached_property
    def by_order(self) -> Array:
        """A column each of rate, acceleration and jerk, by body axis, (3, 3)."""
        return np.stack([self.rate_rad_s, self.acceleration_rad_s2, self.jerk_rad_s3], axis=1)

    @cached_property
    def lengths(self) -> tuple[float, float, float]:
        """No vector within the limits is longer: rate, acceleration, jerk."""
        longest = (np.max if is_round else np.linalg.norm for is_round in self.round_orders)
        rate, acceleration, jerk = (
            float(of(column)) for of, column in zip(longest, self.by_order.T, strict=True)
        )
        return rate, acceleration, jerk

    @property
    def round_orders(self) -> tuple[bool, bool, bool]:
        """Whether the limit of rate, acceleration, jerk is a ball or an ellipsoid; else a box."""
        return self.kind == "magnitude", self.kind != "axis", self.kind != "axis"

    @property
    def inscribed(self) -> "AgilityLimits":
        """The same but of gyros, where it is the balls inside: what knows no ellipsoids uses it."""
        if self.kind != "gyros":
            return self
        rate, acceleration, jerk = self.by_order.min(axis=0).tolist()
        return AgilityLimits.of_magnitudes(rate, acceleration, jerk)

    def about(self, axis_body: Array) -> tuple[float, float, float]:
        """Limits of a turn about one axis, a unit vector (3,): rate, acceleration, jerk."""
        if self.kind == "magnitude":
            return self.lengths
        shares = np.maximum(np.abs(axis_body), 1e-12)[:, None] / self.by_order
        rate, acceleration, jerk = 1.0 / np.where(
            self.round_orders, np.linalg.norm(shares, axis=0), shares.max(axis=0)
        )
        return float(rate), float(acceleration), float(jerk)

    def shares(self, body: BodyMotion) -> Array:
        """Of rows (n, 3), the shares used of rate, acceleration and jerk, (n, 3); 1: all of it."""
        used = np.stack(body, axis=-1) / self.by_order
        sizes = np.linalg.norm(used, axis=1), np.max(np.abs(used), axis=1)
        return np.asarray(np.where(self.round_orders, *sizes))


@dataclass(frozen=True, eq=False, kw_only=True)
class AvoidedCone:
    """A body direction stays half_rad or more away from a direction in GCRF, during the slew.

    name: of the exclusion, as a refusal tells it.  direction_body: a unit vector, (3,).
    centre_eci: unit vectors, (m, 3), one for each row of the table from the slew's first to the
    last it may arrive at.
    """

    name: str
    direction_body: Array
    centre_eci: Array
    half_rad: float


@dataclass(frozen=True, eq=False, kw_only=True)
class BodySlewProblem:
    """From a motion onto a goal that moves: a tracked target, or an idle attitude.

    start: one instant, row 0.  goal: n rows of the motion to join, 0.2 s apart; the slew may
    arrive at each of them, row k of it `first_arrival_row + k` rows after the start.
    objective: "smooth" arrives at the goal's last row with the least integral of squared jerk
    found, "any" with the first that is found; "minimum_time" at the earliest row for which a slew
    is found, with the least jerk.
    """

    start: Motion
    goal: Motion
    first_arrival_row: int
    limits: AgilityLimits
    cones: tuple[AvoidedCone, ...] = ()
    objective: Objective = "smooth"

    def __post_init__(self) -> None:
        if len(self.start.position) != 1 or not len(self.goal.position):
            raise ValueError("a slew begins at one instant, and its goal has a row or more")
        if self.first_arrival_row < 1:
            raise ValueError(f"a slew takes a row or more, not {self.first_arrival_row}")

    @property
    def arrival_rows(self) -> Array:
        """After how many rows it may arrive, (n,)."""
        return self.first_arrival_row + np.arange(len(self.goal.position), dtype=float)

    @property
    def last_arrival_row(self) -> int:
        """After how many rows it arrives at the latest."""
        return self.first_arrival_row + len(self.goal.position) - 1

    @property
    def available_s(self) -> float:
        """The longest that it may take."""
        return self.last_arrival_row / ROWS_PER_S

    @cached_property
    def angles_rad(self) -> Array:
        """Of the rotations from the start to each row of the goal, (n,), at most pi."""
        q_eci_from_start = Rotation.from_quat(self.start.position[0])
        return np.asarray(
            (q_eci_from_start.inv() * Rotation.from_quat(self.goal.position)).magnitude()
        )

    @property
    def is_rest_to_rest(self) -> bool:
        """Whether neither end moves, at any row of the goal."""
        ends = (self.start, self.goal)
        return not any(np.any(end.rate_rad_s) or np.any(end.acceleration_rad_s2) for end in ends)

    def arriving_at(self, row: int) -> "BodySlewProblem":
        """The slew that takes so many rows."""
        k = row - self.first_arrival_row
        return replace(self, goal=rows_of(self.goal, slice(k, k + 1)), first_arrival_row=row)

    def without_cones(self) -> "BodySlewProblem":
        """The same slew where nothing is to be avoided."""
        return replace(self, cones=())

    def at_rest(self) -> "BodySlewProblem":
        """The slew between the same attitudes, none of which moves."""

        def still(motion: Motion) -> Motion:
            none = np.zeros_like(motion.rate_rad_s)
            return Motion(motion.position, none, none)

        return replace(self, start=still(self.start), goal=still(self.goal))

    def with_patience(self, rows: int) -> "BodySlewProblem":
        """The slew that has so many rows, and whose goal stays as it is at the first arrival."""
        first = rows_of(self.goal, slice(1))
        parts = (first.position, first.rate_rad_s, first.acceleration_rad_s2)
        goal = Motion(*(np.repeat(part, rows, axis=0) for part in parts))
        return replace(self, goal=goal, first_arrival_row=1)


def rows_of(motion: Motion, rows: slice) -> Motion:
    """Some of a motion's rows."""
    return Motion(motion.position[rows], motion.rate_rad_s[rows], motion.acceleration_rad_s2[rows])


def between_rows(motion: Motion, shares: Array) -> tuple[Array, BodyMotion]:
    """What a body flies between rows 0.2 s apart: quintics in Rodrigues parameters.

    shares: of the time between two rows, (k,).  q_eci_from_body_xyzw (n - 1, k, 4), and body
    rates, (n - 1, k, 3) each.
    """
    q_eci_from_begin = Rotation.from_quat(motion.position[:-1])
    sigma = np.asarray((q_eci_from_begin.inv() * Rotation.from_quat(motion.position[1:])).as_mrp())
    omega, alpha = motion.rate_rad_s, motion.acceleration_rad_s2
    begin = MrpState(np.zeros_like(sigma), omega[:-1] / 4.0, alpha[:-1] / 4.0)
    end = mrp_state(sigma, omega[1:], alpha[1:])
    curves = [quintic(begin, end, COMMAND_STEP_S, np.full(len(sigma), x)) for x in shares]
    q_xyzw = [(q_eci_from_begin * Rotation.from_mrp(curve.mrp)).as_quat() for curve in curves]
    body = [body_motion(curve) for curve in curves]
    return np.stack(q_xyzw, axis=1), BodyMotion(
        *(np.stack(part, axis=1) for part in zip(*body, strict=True))
    )


def require_ends(problem: BodySlewProblem) -> None:
    """Raises InfeasibleSlew where the start, or every row of the goal, breaks a limit itself."""
    for side, motion in (("start", problem.start), ("end", problem.goal)):
        none = np.zeros_like(motion.rate_rad_s)
        body = BodyMotion(motion.rate_rad_s, motion.acceleration_rad_s2, none)
        least = problem.limits.shares(body).min(axis=0)
        for order, (name, unit) in enumerate(zip(ORDERS, UNIT_TEXTS, strict=True)):
            if least[order] <= 1.0:
                continue
            most = math.degrees(problem.limits.lengths[order])
            raise InfeasibleSlew(
                f"the body's {name} at the {side} of the slew is "
                f"{figures(float(least[order]), 1.0)} of its limit ({most:.4g} {unit}); "
                "begin or end the slew at another time, or slower",
                limit=name,
            )
    _require_brakable(problem)
    for cone in problem.cones:
        for side, motion, row in (
            ("start", problem.start, slice(1)),
            ("end", problem.goal, slice(problem.first_arrival_row, problem.last_arrival_row + 1)),
        ):
            inside_rad = float(np.min(depths_rad(cone, motion.position, cone.centre_eci[row])))
            if inside_rad > 0.0:
                raise InfeasibleSlew(
                    f"{cone.name}: the {side} of the slew lies {math.degrees(inside_rad):.4g} deg "
                    f"inside the {math.degrees(cone.half_rad):.4g} deg to be kept away; "
                    "choose another time or attitude",
                    limit="exclusion",
                )


def _require_brakable(problem: BodySlewProblem) -> None:
    """Raises InfeasibleSlew where the acceleration of an end takes the rate beyond its limit.

    Along the rate, or by axis, it goes on rising by a^2 / (2 jerk) however fast it is braked.
    """
    rate, _, jerk = problem.limits.by_order.T
    for side, motion, sense in (("start", problem.start, 1.0), ("end", problem.goal, -1.0)):
        omega, alpha = motion.rate_rad_s, sense * motion.acceleration_rad_s2
        if problem.limits.kind == "magnitude":
            size = np.linalg.norm(omega, axis=1, keepdims=True)
            along = np.sum(omega * alpha, axis=1, keepdims=True) / np.maximum(size, 1e-15)
            size = np.repeat(size, 3, axis=1)
        else:
            size, along = np.abs(omega), alpha * np.sign(omega)
        reached = (size + np.maximum(along, 0.0) ** 2 / (2.0 * jerk)) / rate
        share = float(np.min(np.max(reached, axis=1)))
        if share > 1.0 + 1e-9:
            raise InfeasibleSlew(
                f"the body's motion at the {side} of the slew can't be braked before its rate is "
                f"{figures(share, 1.0)} of the limit; begin or end the slew at another time, or "
                "slower",
                limit="rate",
            )


def depths_rad(cone: AvoidedCone, q_eci_from_body_xyzw: Array, centre_eci: Array) -> Array:
    """How deep inside the cone the body direction lies, (n,), of n attitudes and centres."""
    seen_eci = Rotation.from_quat(q_eci_from_body_xyzw).apply(cone.direction_body)
    across = np.linalg.norm(np.cross(seen_eci, centre_eci), axis=1)
    along = np.einsum("nj,nj->n", seen_eci, centre_eci)
    return np.asarray(cone.half_rad - np.arctan2(across, along))
