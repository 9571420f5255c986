"""A direction fixed to a platform that keeps away from something around it, or stays near it."""

import math
from typing import Annotated, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import LENGTH_MIN, VectorPart, Within, spec

Direction = tuple[VectorPart, VectorPart, VectorPart]
Celestial = Literal["sun", "moon", "limb", "glint", "nadir", "inertial"]
KeptDeg = Annotated[float, Within(0.0, 179.0)]


@spec
class KeptDirection:
    """A direction of the body, or of the carrier that two axes stand on, that keeps away from
    something around it or stays near it.

    name: its name in margins and refusals. E.g. `"radiator"`.
    of: "camera" for the camera's boresight; else give direction_body.
    direction_body: the direction that keeps away or near; needs no unit length. E.g.
    `[0.0, 1.0, 0.0]`.
    away_from: with min_deg; "sun" and "moon" count from the edge of the disk, and not while the
    Earth hides it; "limb" from the Earth's edge, outwards; "glint" from where a calm sea would
    mirror the Sun; "nadir" from the geocentre; "inertial" from ra_deg and dec_deg.
    min_deg: least angle between them. E.g. `30.0`.
    near: with max_deg, in place of away_from: the direction stays near it, as panels do to the
    Sun; not while the Earth hides it. Near the limb is whatever lies below it, too. E.g. `"sun"`.
    max_deg: greatest angle, within which all of the disk lies. E.g. `40.0`.
    ra_deg, dec_deg: right ascension and declination of an inertial direction in GCRF axes. E.g.
    `10.0`.
    """

    name: str
    of: Literal["camera"] | None = None
    direction_body: Direction | None = None
    away_from: Celestial | None = None
    min_deg: KeptDeg | None = None
    near: Celestial | None = None
    max_deg: Annotated[float, Within(1.0, 179.0)] | None = None
    ra_deg: Annotated[float, Within(0.0, 360.0)] | None = None
    dec_deg: Annotated[float, Within(-90.0, 90.0)] | None = None

    def __post_init__(self) -> None:
        require_name(self.name)
        if (self.of is None) == (self.direction_body is None):
            raise ValueError('of must be "camera", or direction_body given, and not both')
        if self.direction_body is not None:
            require_long("direction_body", self.direction_body)
        keeps_away = self.away_from is not None, self.min_deg is not None
        stays_near = self.near is not None, self.max_deg is not None
        if {keeps_away, stays_near} != {(True, True), (False, False)}:
            raise ValueError(
                "away_from must be given with min_deg, or near with max_deg in place of both"
            )
        for name in ("ra_deg", "dec_deg"):
            if (getattr(self, name) is None) == (self.body == "inertial"):
                raise ValueError(
                    f'{name} must be given with "inertial", and left out with any other direction'
                )

    @property
    def about(self) -> Celestial | Array:
        """The same, or a unit vector in GCRF axes, (3,)."""
        if self.body != "inertial":
            return self.body
        ra_rad, dec_rad = math.radians(self.ra_deg or 0.0), math.radians(self.dec_deg or 0.0)
        across = math.cos(dec_rad)
        return np.array([across * math.cos(ra_rad), across * math.sin(ra_rad), math.sin(dec_rad)])

    @property
    def body(self) -> Celestial:
        """What the direction keeps away from, or stays near."""
        celestial = self.away_from or self.near
        assert celestial is not None  # else it was refused
        return celestial

    def away(self, direction: Array) -> Array:
        """What of a direction, (..., 3), keeps away: of one that stays near its opposite, but of
        one near the limb itself, whose margin is the other way round."""
        return direction if self.near in (None, "limb") else -direction

    @property
    def kept_deg(self) -> float:
        """The least angle of `away` from it, near the limb the greatest."""
        limit_deg = self.max_deg if self.min_deg is None else self.min_deg
        assert limit_deg is not None  # else it was refused
        return limit_deg if self.near in (None, "limb") else 180.0 - limit_deg


def unit_vector(direction: Direction) -> Array:
    """The direction with unit length, (3,)."""
    return np.asarray(direction) / math.hypot(*direction)


def require_name(name: str) -> None:
    if not name:
        raise ValueError("name must not be empty: refusals and margins are given by it")


def require_long(name: str, direction: Direction) -> None:
    if not math.hypot(*direction) >= LENGTH_MIN:
        raise ValueError(
            f"{name} must be at least {LENGTH_MIN:g} long, not {math.hypot(*direction):g}"
        )
