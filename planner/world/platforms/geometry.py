"""The answers that every kind of platform gives about itself: names, camera, how it is turned."""

from typing import Protocol

from planner.base.arrays import Array
from planner.base.commands import Channel
from planner.base.rotation import Rotation
from planner.world.platforms.field_mask import FieldMask


class Pixels(Protocol):
    """What the camera of any kind of platform tells."""

    @property
    def pixel_rad(self) -> float: ...


class PlatformGeometry(Protocol):
    """A payload moved against a base: positions are those of `Motion`, (n, c).

    Of two axes the base is what the outer one is fixed to, turned in space by the carrier's
    attitude law; of a body it is GCRF, and the whole spacecraft is what moves.  Payload: +Z the
    boresight, +X and +Y carried along.
    q_base_from_carrier: how the base is fixed to what the attitude law turns; identity of a body.
    dof_names: what rates have a column for.  channels: of its table.
    masks: what stands in its view, fixed to the base.
    """

    @property
    def kind(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def frame_half_rad(self) -> tuple[float, float]: ...
    @property
    def frame_turn_rad(self) -> float: ...
    @property
    def camera(self) -> Pixels: ...
    @property
    def masks(self) -> tuple[FieldMask, ...]: ...
    @property
    def q_base_from_carrier(self) -> Rotation: ...
    @property
    def dof_names(self) -> tuple[str, ...]: ...
    @property
    def channels(self) -> tuple[Channel, ...]: ...

    def q_payload_from_base(self, position: Array) -> Rotation:
        """n rotations from the base's axes to the payload's."""
        ...

    def omega_payload_rad_s(self, position: Array, rate_rad_s: Array) -> Array:
        """Angular velocity of the payload against the base in payload axes, (n, 3)."""
        ...
