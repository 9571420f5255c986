"""A platform of kind body: a spacecraft that turns as a whole to point its camera."""

import math
from dataclasses import field, replace
from functools import cached_property
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from planner.base.arrays import Array
from planner.base.commands import BODY_CHANNELS, GIMBAL_CHANNELS, Channel
from planner.base.rotation import Rotation
from planner.base.spec import UnitPart, VectorPart, Within, spec
from planner.world.platforms.camera import PIXELS_ARCSEC, Camera
from planner.world.platforms.field_mask import FieldMask
from planner.world.platforms.geometry import Described, MotionBounds, Scanning, vector_text
from planner.world.platforms.gyros import GyroEnvelope, GyroSet
from planner.world.platforms.kept_direction import (
    Celestial,
    Direction,
    KeptDeg,
    KeptDirection,
    require_long,
    require_name,
    unit_vector,
)

Matrix3 = tuple[
    tuple[VectorPart, VectorPart, VectorPart],
    tuple[VectorPart, VectorPart, VectorPart],
    tuple[VectorPart, VectorPart, VectorPart],
]
BodyLimit = Annotated[float, Within(1e-4, 1e3)]
AxisTriple = tuple[BodyLimit, BodyLimit, BodyLimit]
_SettleS = Annotated[float, Within(0.0, 600.0)]
LimitKind = Literal["magnitude", "axis"]


@spec
class MagnitudeAgility:
    """The largest motion of the body about any axis: limits of the vectors' lengths.

    rate_max_deg_s: largest rate against GCRF. E.g. `1.5`.
    acceleration_max_deg_s2: largest angular acceleration. E.g. `0.12`.
    jerk_max_deg_s3: largest derivative of the acceleration. E.g. `0.06`.
    settle_s: time on the target's track between a slew and the session, for the structure to
    calm down.
    """

    limits: Literal["magnitude"] = "magnitude"
    rate_max_deg_s: BodyLimit
    acceleration_max_deg_s2: BodyLimit
    jerk_max_deg_s3: BodyLimit
    settle_s: _SettleS = 0.0

    @property
    def by_order_rad(self) -> Array:
        """A row each of rate, acceleration and jerk, rad and s, (3, 3): three times the length."""
        lengths_deg = [self.rate_max_deg_s, self.acceleration_max_deg_s2, self.jerk_max_deg_s3]
        return np.repeat(np.deg2rad(lengths_deg)[:, None], 3, axis=1)


@spec
class AxisAgility:
    """The largest motion about each body axis by itself.

    rate_max_deg_s: largest rates against GCRF about body x, y, z. E.g. `[1.5, 1.5, 0.8]`.
    acceleration_max_deg_s2: largest angular accelerations about them. E.g. `[0.12, 0.1, 0.1]`.
    jerk_max_deg_s3: largest derivatives of these accelerations. E.g. `[0.06, 0.05, 0.05]`.
    settle_s: time on the target's track between a slew and the session, for the structure to
    calm down.
    """

    limits: Literal["axis"] = "axis"
    rate_max_deg_s: AxisTriple
    acceleration_max_deg_s2: AxisTriple
    jerk_max_deg_s3: AxisTriple
    settle_s: _SettleS = 0.0

    @property
    def by_order_rad(self) -> Array:
        """A row each of rate, acceleration and jerk about body x, y, z, rad and s, (3, 3)."""
        return np.deg2rad([self.rate_max_deg_s, self.acceleration_max_deg_s2, self.jerk_max_deg_s3])


Agility = Annotated[MagnitudeAgility | AxisAgility, Field(discriminator="limits")]
Envelope = MagnitudeAgility | AxisAgility | GyroEnvelope


@spec
class FrameCamera(Camera):
    """A camera of the body that takes one frame after the other.

    boresight_body: direction it looks in; needs no unit length.
    side_body: direction of the frame's first side, square to the boresight.
    field_of_view_deg: along the frame's first side and its second. E.g. `[2.0, 1.5]`.
    """

    type: Literal["frame"] = "frame"
    boresight_body: Direction = (0.0, 0.0, 1.0)
    side_body: Direction = (1.0, 0.0, 0.0)
    field_of_view_deg: tuple[
        Annotated[float, Within(1e-6, 170.0)], Annotated[float, Within(1e-6, 170.0)]
    ]

    def __post_init__(self) -> None:
        _require_square("side_body", self.side_body, "boresight_body", self.boresight_body)
        Camera.__post_init__(self)

    @property
    def c_payload_from_body(self) -> Array:
        """Rows: the payload's axes, +X along the first side, +Z the boresight, (3, 3)."""
        return _triad(self.side_body, self.boresight_body)

    @property
    def frame_half_rad(self) -> tuple[float, float]:
        """Half the field of view along +X and +Y of the payload."""
        along_deg, across_deg = self.field_of_view_deg
        return math.radians(along_deg) / 2.0, math.radians(across_deg) / 2.0

    @property
    def held_half_rad(self) -> tuple[float, float]:
        """The frame holds what is inside it."""
        return self.frame_half_rad

    @property
    def both_ways(self) -> bool:
        """A frame looks the same, whichever way the ground moves through it."""
        return True


@spec
class PushbroomCamera:
    """A camera whose one line of pixels is swept over the ground.

    boresight_body: direction that the middle of the line looks in; needs no unit length.
    line_body: direction along the line of pixels, square to the boresight. With it as +Y and the
    boresight as +Z, the image moves along +X.
    pixel_arcsec: angle a pixel sees. E.g. `0.275`.
    pixels: number of pixels of the line. E.g. `8192`.
    tdi_lines: lines that are added up.
    both_ways: true where the image may move the other way, too, as TDI in both directions lets it.
    line_rate_max_hz: largest number of lines in a second.
    """

    type: Literal["pushbroom"] = "pushbroom"
    boresight_body: Direction = (0.0, 0.0, 1.0)
    line_body: Direction = (0.0, 1.0, 0.0)
    pixel_arcsec: Annotated[float, Within(*PIXELS_ARCSEC)]
    pixels: Annotated[int, Within(1, 1_000_000)]
    tdi_lines: Annotated[int, Within(1, 1024)] = 1
    both_ways: bool = False
    line_rate_max_hz: Annotated[float, Within(1.0, 1e6)] = 10_000.0

    def __post_init__(self) -> None:
        _require_square("line_body", self.line_body, "boresight_body", self.boresight_body)
        width_deg = self.pixels * self.pixel_arcsec / 3600.0
        if not width_deg <= 170.0:
            raise ValueError(
                f"pixels of {self.pixel_arcsec:g} arcsec each see {width_deg:.6g} deg together, "
                f"more than 170: give fewer than {self.pixels}, or smaller ones"
            )

    @property
    def pixel_rad(self) -> float:
        """Angle a pixel sees."""
        return math.radians(self.pixel_arcsec / 3600.0)

    @property
    def c_payload_from_body(self) -> Array:
        """Rows: the payload's axes, +Y along the line, +Z the boresight, (3, 3)."""
        line, boresight = unit_vector(self.line_body), unit_vector(self.boresight_body)
        return _triad(np.cross(line, boresight), self.boresight_body)

    @property
    def frame_half_rad(self) -> tuple[float, float]:
        """Half of what is seen at a time along +X and +Y of the payload: across, along the line."""
        return self.tdi_lines * self.pixel_rad / 2.0, self.pixels * self.pixel_rad / 2.0

    @property
    def held_half_rad(self) -> tuple[float, float]:
        """The ground is swept along +X: a point beside the line there is imaged at another time."""
        return math.pi / 2.0, self.frame_half_rad[1]

    @property
    def exposure_s(self) -> float:
        """Time in which a point crosses the lines that are added up, at the largest line rate."""
        return self.tdi_lines / self.line_rate_max_hz

    def exposures_s(self, image_rad_s: Array) -> Array:
        """The same at line rates that follow the image, a line for each pixel it moves; (n,).

        image_rad_s: the image's rate across the line; where it is 0 the largest line rate is
        taken, as it is where the image moves faster than that.
        """
        line_rate_hz = np.minimum(image_rad_s / self.pixel_rad, self.line_rate_max_hz)
        return self.tdi_lines / np.where(line_rate_hz > 0.0, line_rate_hz, self.line_rate_max_hz)

    @property
    def frames_per_s(self) -> float:
        """So many lines of a second are looked at, as errors change slowly beside them."""
        return min(10.0, 1.0 / self.exposure_s)


BodyCamera = Annotated[FrameCamera | PushbroomCamera, Field(discriminator="type")]


@spec
class LinesAcrossMotion:
    """The camera's +X lies along the motion of the looked-at point over the ground.

    The image of a pushbroom then runs across its line. It needs a target that moves over the
    ground, as paths do; where the motion dies away, the line turns faster and faster.
    """

    rule: Literal["lines_across_motion"] = "lines_across_motion"


@spec
class LinesAcrossTrack:
    """The camera's +X lies along the satellite's motion over the turning Earth."""

    rule: Literal["lines_across_track"] = "lines_across_track"


@spec
class NearestRoll:
    """The attitude nearest to the one before the slew; then no turn about the line of sight."""

    rule: Literal["nearest"] = "nearest"


@spec
class SunSide:
    """A direction of the body is turned towards the Sun, as near as the line of sight lets it.

    direction_body: such as the normal of the solar panels; needs no unit length. E.g.
    `[-1.0, 0.0, 0.0]`.
    """

    rule: Literal["sun_side"] = "sun_side"
    direction_body: Direction

    def __post_init__(self) -> None:
        require_long("direction_body", self.direction_body)


@spec
class AzimuthRoll:
    """The camera's +X lies along an azimuth at the target on the ground.

    azimuth_deg: from north by east. E.g. `15.0`.
    """

    rule: Literal["azimuth"] = "azimuth"
    azimuth_deg: Annotated[float, Within(-360.0, 360.0)]


RollRule = Annotated[
    LinesAcrossMotion | LinesAcrossTrack | NearestRoll | SunSide | AzimuthRoll,
    Field(discriminator="rule"),
]


@spec
class NadirIdle:
    """Between sessions a body direction looks down, another one forward.

    direction_body: to the geocentric nadir. E.g. `[0.0, 0.0, 1.0]`.
    forward_body: as near to the flight's direction as the first lets it. E.g. `[1.0, 0.0, 0.0]`.
    """

    law: Literal["nadir"] = "nadir"
    direction_body: Direction = (0.0, 0.0, 1.0)
    forward_body: Direction = (1.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        _require_apart("forward_body", self.forward_body, "direction_body", self.direction_body)


@spec
class SunIdle:
    """Between sessions a body direction looks at the Sun's centre, in the Earth's shadow too.

    direction_body: to the Sun, such as the normal of the panels. E.g. `[0.0, 0.0, -1.0]`.
    north_body: as near to the celestial north pole as the first lets it; unless given, the body
    axis least along the first one. E.g. `[1.0, 0.0, 0.0]`.
    """

    law: Literal["sun"] = "sun"
    direction_body: Direction
    north_body: Direction | None = None

    def __post_init__(self) -> None:
        require_long("direction_body", self.direction_body)
        if self.north_body is not None:
            _require_apart("north_body", self.north_body, "direction_body", self.direction_body)

    @property
    def north(self) -> Direction:
        """`north_body`, given or not."""
        if self.north_body is not None:
            return self.north_body
        least = int(np.argmin(np.abs(self.direction_body)))
        return ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))[least]


@spec
class InertialIdle:
    """Between sessions the body keeps one attitude among the stars.

    q_body_from_eci_xyzw: carries GCRF axes onto the body's, scalar last. E.g.
    `[0.0, 0.0, 0.0, 1.0]`.
    """

    law: Literal["inertial"] = "inertial"
    q_body_from_eci_xyzw: tuple[UnitPart, UnitPart, UnitPart, UnitPart]

    def __post_init__(self) -> None:
        norm = math.hypot(*self.q_body_from_eci_xyzw)
        if not abs(norm - 1.0) <= 1e-6:
            raise ValueError(f"q_body_from_eci_xyzw must have unit length, not {norm}")


IdleLaw = Annotated[NadirIdle | SunIdle | InertialIdle, Field(discriminator="law")]


@spec
class PointingKnowledge:
    """Errors of the attitude, 1 sigma about each axis.

    sigma_arcsec: of the attitude as the spacecraft knows it.
    control_sigma_arcsec: of the attitude flown against the one commanded.
    jitter_arcsec: of vibration faster than the exposure.
    correlation_s: time in which the errors of knowledge and control forget half of themselves.
    """

    sigma_arcsec: Annotated[float, Within(0.0, 36e3)] = 10.0
    control_sigma_arcsec: Annotated[float, Within(0.0, 36e3)] = 10.0
    jitter_arcsec: Annotated[float, Within(0.0, 3600.0)] = 0.0
    correlation_s: Annotated[float, Within(0.01, 1e5)] = 10.0


@spec
class StarTracker:
    """A star tracker, which sees no stars too near to the Sun, the Moon or the Earth.

    name: name of the tracker in margins and refusals. E.g. `"st1"`.
    boresight_body: direction it looks in; needs no unit length. E.g. `[0.5, -0.6, -0.62]`.
    sun_deg: least angle from the edge of the Sun's disk.
    moon_deg: least angle from the edge of the Moon's disk.
    limb_deg: least angle from the Earth's limb.
    """

    name: str
    boresight_body: Direction
    sun_deg: KeptDeg = 0.0
    moon_deg: KeptDeg = 0.0
    limb_deg: KeptDeg = 0.0

    def __post_init__(self) -> None:
        require_name(self.name)
        require_long("boresight_body", self.boresight_body)

    @property
    def least_deg(self) -> tuple[tuple[Celestial, float], ...]:
        """What it keeps from, and by how much."""
        return (("sun", self.sun_deg), ("moon", self.moon_deg), ("limb", self.limb_deg))


@spec
class StarTrackers:
    """The star trackers, of which some must see stars while the camera images.

    needed: number that must see stars at a time.
    each: up to 8 trackers.
    """

    needed: Annotated[int, Within(0, 8)] = 1
    each: tuple[StarTracker, ...]

    def __post_init__(self) -> None:
        _require_few_and_named("each", self.each)
        if self.needed > len(self.each):
            raise ValueError(
                f"needed must be at most {len(self.each)}, the trackers there are, "
                f"not {self.needed}"
            )


@spec
class Exclusion(KeptDirection):
    """A direction of the body that keeps away from something around it or stays near it.

    when: always, or only while the camera images; only then near the limb.
    """

    when: Literal["always", "imaging"] = "always"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.near == "limb" and self.when == "always":
            raise ValueError(
                'when must be "imaging" of a direction that stays near the limb: slews keep away '
                "from cones only"
            )


@spec
class BodyPlatform:
    """A spacecraft that turns as a whole, within an envelope of agility or by its gyros.

    kind: body, a spacecraft that turns as a whole.
    name: name of the platform in plans. E.g. `"smallsat-120kg"`.
    agility: the motion that it can do, by magnitude or by body axis; or gyros in its place.
    gyros: control moment gyros that turn it, with the inertia. Its motion keeps within what they
    can always give.
    off_nadir_max_deg: largest angle between boresight and geocentric nadir while a target on the
    Earth is imaged; targets in the sky know no such limit.
    roll: rule by which the camera lies about the line of sight. lines_across_motion gives way to
    nearest for targets that don't move over the ground, azimuth for those in the sky.
    idle: the attitude between sessions.
    inertia_kg_m2: of the whole spacecraft about its centre of mass, in body axes. E.g.
    `[[11.0, 0.1, 0.0], [0.1, 13.0, 0.0], [0.0, 0.0, 9.0]]`.
    torque_max_n_m: length of the largest torque on the body, with the inertia: the motion that
    agility allows must not ask for more. E.g. `0.03`.
    camera: the camera on the body: its frame, or its line.
    knowledge: errors of the attitude.
    star_trackers: star trackers, and the number that must see stars while imaging.
    exclusions: up to 16 directions of the body with what they keep away from or stay near.
    """

    masks: ClassVar[tuple[FieldMask, ...]] = ()  # its structure turns with the camera
    frame_turn_rad: ClassVar[float] = 0.0

    kind: Literal["body"] = "body"
    name: str
    agility: Agility | None = None
    gyros: GyroSet | None = None
    off_nadir_max_deg: Annotated[float, Within(0.1, 90.0)] = 45.0
    roll: RollRule = NearestRoll()
    idle: IdleLaw = field(default_factory=NadirIdle)
    inertia_kg_m2: Matrix3 | None = None
    torque_max_n_m: Annotated[float, Within(1e-6, 1e6)] | None = None
    camera: BodyCamera
    knowledge: PointingKnowledge = field(default_factory=PointingKnowledge)
    star_trackers: StarTrackers | None = None
    exclusions: tuple[Exclusion, ...] = ()

    def __post_init__(self) -> None:
        require_name(self.name)
        if self.agility is None and self.gyros is None:
            raise ValueError("agility is required, or gyros in its place")
        if self.inertia_kg_m2 is not None:
            _require_physical(np.array(self.inertia_kg_m2))
        if self.gyros is not None:
            self._require_gyros()
        elif self.inertia_kg_m2 is not None:
            self._require_torque(np.array(self.inertia_kg_m2))
        elif self.torque_max_n_m is not None:
            raise ValueError(
                "torque_max_n_m says nothing without inertia_kg_m2: give both, or leave it out"
            )
        if len(self.exclusions) > 16:
            raise ValueError(
                f"exclusions must hold at most 16 exclusions, not {len(self.exclusions)}"
            )
        _require_own_names("exclusions", [exclusion.name for exclusion in self.exclusions])
        self.require_roll("roll", self.roll)

    def require_roll(self, name: str, roll: RollRule) -> None:
        """Raises ValueError where the camera looks along what the rule turns to the Sun."""
        if isinstance(roll, SunSide):
            boresight_body = self.camera.boresight_body
            _require_apart(
                f"{name}.direction_body",
                roll.direction_body,
                "camera.boresight_body",
                boresight_body,
            )

    def _require_gyros(self) -> None:
        if self.agility is not None:
            raise ValueError(
                "agility must be left out with gyros: their torque says what it can do"
            )
        if self.inertia_kg_m2 is None:
            raise ValueError("inertia_kg_m2 is required with gyros: they turn it")
        if self.torque_max_n_m is not None:
            raise ValueError(
                "torque_max_n_m must be left out with gyros: give gyros.turns.torque_max_n_m"
            )
        _ = self.envelope  # refuses gyros that can't give any

    @cached_property
    def envelope(self) -> Envelope:
        """The motion that it can do: `agility`, or what gyros can always give."""
        if self.agility is not None:
            return self.agility
        assert self.gyros is not None  # else it was refused
        return self.gyros.envelope(np.array(self.inertia_kg_m2))

    def _require_torque(self, inertia_kg_m2: Array) -> None:
        """J alpha + omega x J omega at most: the second by half the spread of the moments."""
        rate, acceleration, _ = self.envelope.by_order_rad
        if self.envelope.limits == "magnitude":
            rate, acceleration = rate[:1], acceleration[:1]
        least, _, most = np.linalg.eigvalsh(inertia_kg_m2)
        needed_n_m = most * math.hypot(*acceleration) + 0.5 * (most - least) * (rate @ rate)
        if self.torque_max_n_m is not None and self.torque_max_n_m < needed_n_m:
            raise ValueError(
                f"torque_max_n_m must be {needed_n_m:.4g} or more, which agility may ask for, not "
                f"{self.torque_max_n_m:g}: or lower agility.acceleration_max_deg_s2"
            )

    @property
    def q_base_from_carrier(self) -> Rotation:
        """Identity: its base is GCRF."""
        return Rotation.identity()

    @property
    def dof_names(self) -> tuple[str, ...]:
        """The body axes."""
        return ("x", "y", "z")

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Attitude, rates and accelerations, and of gyros their gimbals' angles and rates."""
        return BODY_CHANNELS if self.gyros is None else (*BODY_CHANNELS, *GIMBAL_CHANNELS)

    @property
    def frame_half_rad(self) -> tuple[float, float]:
        """Half of what the camera sees along +X and +Y of the payload."""
        return self.camera.frame_half_rad

    @property
    def held_half_rad(self) -> tuple[float, float]:
        """How far from the middle a target is still imaged, along +X and +Y of the payload."""
        return self.camera.held_half_rad

    @property
    def scanning(self) -> Scanning:
        """With the lines, or the frame's first side, across the motion."""
        return Scanning(
            self.camera.frame_half_rad[1], self.camera.both_ways, self.envelope.settle_s
        )

    @property
    def boresight_body(self) -> Array:
        """Unit vector, (3,)."""
        return unit_vector(self.camera.boresight_body)

    def motion_bounds(self, jerk_max_deg_s3: float | None = None) -> tuple[MotionBounds, ...]:
        """About each body axis; no request gives a body another jerk."""
        by_axis = self.envelope.by_order_rad.T.tolist()
        return tuple((None, (-v, v), (-a, a), (-j, j)) for v, a, j in by_axis)

    def described(self) -> Described:
        """How its quaternion turns, the camera's mount, the payload's axes."""
        mount = ", ".join(map(vector_text, self.camera.c_payload_from_body))
        return Described(
            "q_eci_from_body is scalar last and turns vectors of the body into GCRF; omega_body "
            "and alpha_body are the body's rate and acceleration against GCRF in body axes, about "
            "x, y, z",
            f"payload axes in body axes: {mount}",
            "payload: +Z boresight, +X along the frame's first side or across the line of pixels",
            "between rows the body flies the quintic in modified Rodrigues parameters that meets "
            "attitude, rate and acceleration of both"
            + ("; gimbal rates are held until the next row" if self.gyros else ""),
        )

    @cached_property
    def _mount(self) -> Rotation:
        """The camera's, payload from body."""
        return Rotation.from_matrix(self.camera.c_payload_from_body)

    def q_payload_from_body(self, position: Array) -> Rotation:
        """The camera's mount, for n instants; position: (n, 4)."""
        return Rotation.concatenate([self._mount] * len(position))

    def q_payload_from_base(self, position: Array) -> Rotation:
        """n rotations from GCRF to the payload's axes.

        position: `q_eci_from_body_xyzw`, (n, 4).
        """
        return self._mount * Rotation.from_quat(position).inv()

    def omega_payload_rad_s(self, position: Array, rate_rad_s: Array) -> Array:
        """Angular velocity of the payload against GCRF in payload axes, (n, 3).

        position: (n, 4).  rate_rad_s: of the body, in body axes, (n, 3).
        """
        return np.asarray(self._mount.apply(rate_rad_s))

    @property
    def always_excluded(self) -> tuple[Exclusion, ...]:
        """What its directions keep away from also while nothing is imaged."""
        return tuple(one for one in self.exclusions if one.when == "always")

    def keeping(self, directions: tuple[KeptDirection, ...]) -> "BodyPlatform":
        """The same with a request's directions among its exclusions, while it images."""
        asked = (
            Exclusion(**{**vars(one), "name": f"directions.{one.name}"}, when="imaging")
            for one in directions
        )
        more = tuple(one for one in asked if one not in self.exclusions)
        return replace(self, exclusions=self.exclusions + more) if more else self

    def direction_of(self, exclusion: KeptDirection) -> Array:
        """As `KeptDirection.away`, a unit vector in body axes, (3,)."""
        return exclusion.away(unit_vector(exclusion.direction_body or self.camera.boresight_body))


def _triad(x_body: Direction | Array, z_body: Direction) -> Array:
    """Rows +X, +Y, +Z in body axes: +Z as given, +X as near to x_body as that lets it."""
    z = unit_vector(z_body)
    across = np.asarray(x_body) - (np.asarray(x_body) @ z) * z
    x = across / np.linalg.norm(across)
    return np.stack([x, np.cross(z, x), z])


def _require_few_and_named(what: str, trackers: tuple[StarTracker, ...]) -> None:
    if not 1 <= len(trackers) <= 8:
        raise ValueError(f"{what} must hold 1 to 8 trackers, not {len(trackers)}")
    _require_own_names(what, [tracker.name for tracker in trackers])


def _require_own_names(what: str, names: list[str]) -> None:
    for number, name in enumerate(names):
        if name in names[:number]:
            raise ValueError(f"{what}.{number}.name must be its own, not {name!r} again")


def _angle_deg(a: Direction, b: Direction) -> float:
    a_unit, b_unit = unit_vector(a), unit_vector(b)
    across = float(np.linalg.norm(np.cross(a_unit, b_unit)))
    return math.degrees(math.atan2(across, float(a_unit @ b_unit)))


def _require_apart(name: str, direction: Direction, other: str, other_direction: Direction) -> None:
    """Both long enough, and neither along the other: else nothing says how the body lies."""
    require_long(other, other_direction)
    require_long(name, direction)
    angle_deg = _angle_deg(direction, other_direction)
    if not 1.0 <= angle_deg <= 179.0:
        raise ValueError(
            f"{name} must stand 1 deg or more off the line of {other}, "
            f"not {min(angle_deg, 180.0 - angle_deg):.3g} deg"
        )


def _require_square(
    name: str, direction: Direction, other: str, other_direction: Direction
) -> None:
    require_long(other, other_direction)
    require_long(name, direction)
    angle_deg = _angle_deg(direction, other_direction)
    if not abs(angle_deg - 90.0) <= 0.01:
        raise ValueError(f"{name} must stand square to {other}, not at {angle_deg:.6g} deg")


def _require_physical(inertia_kg_m2: Array) -> None:
    """Refuse a matrix that is no body's: its moments are sums of squares of lengths."""
    for row, column in ((0, 1), (0, 2), (1, 2)):
        there, back = inertia_kg_m2[row, column], inertia_kg_m2[column, row]
        if abs(there - back) > 1e-9 * np.max(np.abs(inertia_kg_m2)):
            raise ValueError(
                f"inertia_kg_m2.{column}.{row} must be {there:g} as inertia_kg_m2.{row}.{column}, "
                f"not {back:g}: an inertia is symmetric"
            )
    least, middle, most = np.linalg.eigvalsh(inertia_kg_m2).tolist()
    if not least > 0.0:
        raise ValueError(
            f"inertia_kg_m2 must have positive principal moments, not {least:g} kg m2: "
            "check the signs of its products"
        )
    if least + middle < most * (1.0 - 1e-9):
        raise ValueError(
            f"inertia_kg_m2 has the principal moments {least:g}, {middle:g} and {most:g} kg m2, "
            "and no body's largest exceeds the sum of the others: check its entries"
        )
