"""Masks: parts of the carrier that stand in a platform's view."""

import math
from functools import cached_property
from typing import Annotated

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import LENGTH_MIN, VectorPart, Within, spec
from planner.world.platforms.spherical_polygon import SphericalPolygon, spherical_polygon, unit

CornerVector = tuple[VectorPart, VectorPart, VectorPart]
CORNERS_MAX = 64


@spec
class FieldMask:
    """A region of directions that the boresight must never enter, such as structure in the view.

    name: name of the mask in plans and refusals.
    corners_platform: 3 to 64 directions in the platform frame, in their order around the region,
    either way; they need no unit length, so that they may be the structure's corners as seen from
    where the axes meet. Great-circle arcs join them, and the region is the smaller side. E.g.
    `[[0.2, -0.9, 0.3], [0.9, -0.9, 0.3], [0.9, -0.9, -0.4], [0.2, -0.9, -0.4]]`.
    margin_deg: angle that the boresight must keep from the region.
    """

    name: str
    corners_platform: tuple[CornerVector, ...]
    margin_deg: Annotated[float, Within(0.0, 45.0)] = 0.0

    def __post_init__(self) -> None:
        if not self.name:
            raise ValueError("name must not be empty: refusals and margins are given by it")
        count = len(self.corners_platform)
        if not 3 <= count <= CORNERS_MAX:
            raise ValueError(f"corners_platform must hold 3 to {CORNERS_MAX} corners, not {count}")
        for place, corner in enumerate(self.corners_platform):
            if not math.hypot(*corner) >= LENGTH_MIN:
                raise ValueError(
                    f"corners_platform.{place} must be at least {LENGTH_MIN:g} long, not "
                    f"{math.hypot(*corner):g}"
                )
        try:
            self.polygon  # noqa: B018
        except ValueError as fault:
            raise ValueError(f"corners_platform {fault}") from None

    @property
    def title(self) -> str:
        """The mask's name in a sentence."""
        return f'the mask "{self.name}"'

    @cached_property
    def polygon(self) -> SphericalPolygon:
        """The region without its margin."""
        return spherical_polygon(unit(np.array(self.corners_platform)))

    @property
    def margin_rad(self) -> float:
        return math.radians(self.margin_deg)

    def depth_rad(self, directions_platform: Array) -> Array:
        """How far unit vectors (n, 3) are within the region and its margin; negative outside."""
        return self.polygon.depth_rad(directions_platform) + self.margin_rad
