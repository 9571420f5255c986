"""The sensors of one kind of platform, as a comparison asks them, and what a flight teaches."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

from planner.base.answer_members import Count, Internal, NotNegative, Signed, answer
from planner.base.arrays import Array
from planner.inflight.telemetry.following import (
    MotionBounds,
    PlannedMotion,
    SignedArcsec,
    SizeArcsec,
)
from planner.inflight.telemetry.samples import (
    ColumnContract,
    ColumnUnit,
    ImageOffset,
    Kind,
    TelemetryColumn,
)
from planner.world.attitude.corrections import AttitudeCorrection
from planner.world.frames.time_scales import Utc
from planner.world.platforms import BodyPlatform, PlatformDefinition

if TYPE_CHECKING:
    from planner.inflight.telemetry.compare import Comparison

ToldKind = Kind | Literal["attitude"]


@answer
class ToldColumn:
    """The reading of one column.

    name: as it was sent.
    axis: the axis it belongs to; of an attitude, the part of the quaternion that it holds.
    kind: of its angle or its rate, or of a body's attitude.
    unit: in which it was read, as its name or `columns` says; of a rate, per second.
    """

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


@answer
class PointingParts:
    """Distance of the target from the frame's centre at an instant, and its causes: along the
    frame's first side and its second.

    at_utc: time of the measurement; UTC. E.g. `"2015-02-27T17:37:00.000Z"`.
    session: number of the session then, from 0; null outside of sessions. E.g. `0`.
    measured: source of the measured attitude: a rotation as of the horizon, or the target in an
    image. E.g. `"image"`.
    axes_rad: error of the boresight by the axes; null without angles of both. E.g.
    `[2.5, -1.0]`.
    attitude_rad: of the target by the attitude, beyond what the plan reckoned with. E.g.
    `[432.0, -180.0]`.
    attitude_sigma_rad: 1-sigma of each. E.g. `[3.6, 3.6]`.
    target_rad: of the target from the frame's centre: attitude less axes; null without axes.
    E.g. `[429.5, -179.0]`.
    correction: the attitude against its law without corrections, as a plan takes it.
    """

    at_utc: Utc
    session: Count | None
    measured: Literal["rotation", "image"]
    axes_rad: tuple[SignedArcsec, ...] | None
    attitude_rad: tuple[SignedArcsec, ...]
    attitude_sigma_rad: tuple[SizeArcsec, ...]
    target_rad: tuple[SignedArcsec, ...] | None
    correction: Internal[AttitudeCorrection]


@answer
class Parameter:
    """A parameter of the platform, estimated from the telemetry.

    name: path of the field in `platform`; of a drive the axis's name, a dot, and the field's. E.g.
    `"beta.coulomb_deg_s2"`.
    planned: value of the plan's platform, in the field's unit. E.g. `0.05`.
    found: value estimated from the telemetry. E.g. `0.1`.
    sigma: 1-sigma error; null where the found one is a bound, as of `rate_min_deg_s`, below which
    the axis was seen to stick and slip. E.g. `0.001`.
    """

    name: str
    planned: Signed
    found: Signed
    sigma: NotNegative | None


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
