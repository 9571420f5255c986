"""The answers that every kind of platform gives about itself: names, camera, how it is turned."""

from collections.abc import Iterable
from typing import NamedTuple, Protocol

from planner.base.arrays import Array
from planner.base.commands import Channel
from planner.base.rotation import Rotation
from planner.world.platforms.camera import Shutter
from planner.world.platforms.field_mask import FieldMask

Bounds = tuple[float, float]  # least and greatest
# Of angle, rate, acceleration and jerk, in rad and s; a body turns to any angle.
MotionBounds = tuple[Bounds | None, Bounds, Bounds, Bounds]


class Described(NamedTuple):
    """What a table's columns mean: how they turn, the frames, what is flown between rows."""

    rotation_order: str
    mount: str
    payload_axes: str
    interpolation: str


class Scanning(NamedTuple):
    """What a platform's camera images along a line.

    half_width_rad: half of its view across the line.  both_ways: whether the image may move
    through it either way.  settle_s: time between a slew and a scan.
    """

    half_width_rad: float
    both_ways: bool
    settle_s: float


def vector_text(unit: Iterable[float]) -> str:
    """Its parts to 12 digits."""
    return "[" + ", ".join(f"{value + 0.0:.12g}" for value in unit) + "]"


class PlatformGeometry(Protocol):
    """A payload moved against a base: positions are those of `Motion`, (n, c).

    Of two axes the base is what the outer one is fixed to, turned in space by the carrier's
    attitude law; of a body it is GCRF, and the whole spacecraft is what moves.  Payload: +Z the
    boresight, +X and +Y carried along.
    dof_names: what rates have a column for.  channels: of its table.
    held_half_rad: how far from the middle of the view a target is still imaged, along +X and +Y.
    masks: what stands in its view, fixed to the base.
    """

    @property
    def name(self) -> str: ...
    @property
    def frame_half_rad(self) -> tuple[float, float]: ...
    @property
    def frame_turn_rad(self) -> float: ...
    @property
    def held_half_rad(self) -> tuple[float, float]: ...
    @property
    def camera(self) -> Shutter: ...
    @property
    def scanning(self) -> Scanning: ...
    @property
    def masks(self) -> tuple[FieldMask, ...]: ...
    @property
    def q_base_from_carrier(self) -> Rotation:
        """The base against what the attitude law turns; identity of a body."""
        ...

    @property
    def dof_names(self) -> tuple[str, ...]: ...
    @property
    def channels(self) -> tuple[Channel, ...]: ...

    def described(self) -> Described:
        """For the header of a file with its table."""
        ...

    def motion_bounds(self, jerk_max_deg_s3: float | None = None) -> tuple[MotionBounds, ...]:
        """Of each of `dof_names`; limits of magnitude hold for the whole vector.

        jerk_max_deg_s3: instead of the platform's own.
        """
        ...

    def q_payload_from_body(self, position: Array) -> Rotation:
        """n rotations from the axes of the carrier, or of the body itself, to the payload's."""
        ...

    def q_payload_from_base(self, position: Array) -> Rotation:
        """n rotations from the base's axes to the payload's."""
        ...

    def omega_payload_rad_s(self, position: Array, rate_rad_s: Array) -> Array:
        """Angular velocity of the payload against the base in payload axes, (n, 3)."""
        ...
