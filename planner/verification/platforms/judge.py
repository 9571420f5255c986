"""The judge of one kind of platform, as the rest of the verification asks it."""

from collections.abc import Iterator
from typing import NamedTuple, Protocol

from planner.base.arrays import Array, Indices, Mask
from planner.verification.report import (
    ExclusionMargin,
    Finding,
    GyroMargin,
    KeepOutMargin,
    LimitMargin,
    MaskMargin,
    SessionReport,
    SlowStretch,
)
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.targets import BenchMotionTarget

JudgedSession = tuple[SessionReport | None, tuple[Finding, ...]]


class FlownInstants(NamedTuple):
    """Of a table: n instants, each u_s after the row that its cell begins with."""

    cell: Indices
    u_s: Array
    instants: Instants


class Judge(Protocol):
    """Knows the columns of one table, what is flown between its rows, and how that points.

    Made of a table and its scenario; imports nothing of the planner's geometry.  Where `fault`
    finds something, nothing else may be asked.
    """

    def fault(self) -> Finding | None:
        """What of the columns leaves nothing to judge: their names, shapes, numbers."""

    def row_findings(self) -> Iterator[Finding]:
        """How rows disagree with each other, the first with the initial, the last with the final
        state."""

    def margins(self) -> tuple[LimitMargin, ...]:
        """To every limit of the motion, anywhere between the first and the last row."""

    def keep_out(self) -> tuple[KeepOutMargin, ...]:
        """To the cones that a request names.  Raises OutsideCoverage."""

    def masks(self) -> tuple[MaskMargin, ...]:
        """To what stands in the platform's view."""

    def exclusions(self) -> tuple[ExclusionMargin, ...]:
        """To what directions of a body keep away from.  Raises OutsideCoverage."""

    def gyros(self) -> tuple[GyroMargin, ...]:
        """To what gyros can give that turn a body.  Raises OutsideCoverage."""

    def slow_stretches(self, cells: Mask, *, standing: bool) -> Iterator[SlowStretch]:
        """Where a drive is slower than it runs smoothly within these cells, shape (n - 1,).

        standing: whether one that stands still throughout a cell counts as slow.
        """

    def boresight_eci(self, at: FlownInstants, states: OrbitStates) -> Array:
        """Where the payload points, unit vectors (n, 3)."""

    def direction_eci(self, direction: Array, at: FlownInstants, states: OrbitStates) -> Array:
        """What is fixed to the structure that its `direction_...` name, (3,), as vectors (n, 3)."""

    def is_idle_at(self, rows: Indices) -> Mask:
        """At which rows it stands still, or a body keeps its idle attitude, (k,)."""

    def turn_most_rad(self) -> Array:
        """By how much the boresight may turn in space within a step of each row, shape (n,)."""

    def session_findings(
        self, number: int, at: FlownInstants, states: OrbitStates
    ) -> Iterator[Finding]:
        """What else is wrong while the session of that index looks at its target."""

    def prescribed(self, number: int, rows: range, target: BenchMotionTarget) -> JudgedSession:
        """A session whose target prescribes the motion itself, over rows that the table has."""

    @property
    def derives_attitude(self) -> bool:
        """Whether directions in space come from the request's own numbers alone."""
