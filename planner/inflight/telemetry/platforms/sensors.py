"""The sensors of one kind of platform, as a comparison asks them, and what a flight teaches."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

from planner.base.arrays import Array
from planner.inflight.telemetry.following import MotionBounds, PlannedMotion
from planner.inflight.telemetry.samples import (
    ColumnContract,
    ColumnUnit,
    ImageOffset,
    Kind,
    TelemetryColumn,
)
from planner.world.attitude.corrections import AttitudeCorrection
from planner.world.platforms import BodyPlatform, PlatformDefinition

if TYPE_CHECKING:
    from planner.inflight.telemetry.compare import Comparison

ToldKind = Kind | Literal["attitude"]


class ToldColumn(NamedTuple):
    """The reading of a column.  axis: whose motion it measures, or which part of the attitude."""

    name: str
    axis: str
    kind: ToldKind
    unit: ColumnUnit


class ReadColumns(NamedTuple):
    """columns: angles and rates of the motions.  told: as they were sent.  notes: on doubts."""

    columns: Sequence[TelemetryColumn]
    told: tuple[ToldColumn, ...]
    notes: tuple[str, ...] = ()


class ClockAssumptions(NamedTuple):
    """Words on what each estimate of the clock takes for granted."""

    earliest: str
    equally_late: str
    ideal: str


@dataclass(frozen=True, kw_only=True)
class PointingParts:
    """How far the target was from the frame's centre and why, along the frame's two sides.

    axes_rad: the boresight's error by the axes alone, None where there is no telemetry of both.
    attitude_rad: by which the attitude moved the target, beyond what the plan reckoned with.
    attitude_sigma_rad: of each.
    target_rad: of the target in the frame: attitude less axes; None without axes.
    correction: the attitude against its law without corrections, as a plan takes it.
    """

    epoch_utc: datetime
    session: int | None
    measured: Literal["rotation", "image"]
    axes_rad: tuple[float, float] | None
    attitude_rad: tuple[float, float]
    attitude_sigma_rad: tuple[float, float]
    target_rad: tuple[float, float] | None
    correction: AttitudeCorrection


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """name: `axis.field`, or the field's path.  planned_value: what the platform has.  found_value,
    sigma: the estimate; sigma None where it is a bound."""

    name: str
    planned_value: float
    found_value: float
    sigma: float | None


@dataclass(frozen=True, kw_only=True)
class PlatformFound:
    """parameters: those found.  platform: as planned with, but for these."""

    parameters: tuple[Parameter, ...]
    platform: PlatformDefinition | BodyPlatform


class PlatformSensors(Protocol):
    """Knows what the columns of one platform's telemetry mean, and how that moves as planned."""

    contract: ColumnContract
    assumes: ClockAssumptions

    @property
    def motions(self) -> tuple[PlannedMotion, ...]:
        """Of each axis, in their order."""

    @property
    def bounds(self) -> tuple[MotionBounds, ...]:
        """Of each axis."""

    def read(self, columns: Sequence[TelemetryColumn], tag_s: Array) -> ReadColumns:
        """As angles and rates; tag_s: (n,), the telemetry's clock less the table's epoch.

        Raises InvalidInput for columns that measure nothing without others.
        """

    def pointing(
        self,
        comparison: "Comparison",
        corrections: Sequence[AttitudeCorrection],
        image_offsets: Sequence[ImageOffset],
    ) -> list[PointingParts]:
        """In order of time.  Raises InvalidInput for what says nothing of the attitude."""

    def found(self, comparison: "Comparison", names: Sequence[str]) -> PlatformFound | None:
        """What the next plan learns of the platform, with its parameters of these names; None:
        nothing.  Raises InvalidInput for names and plans that can't be identified."""
