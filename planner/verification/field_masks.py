"""The check that the boresight enters no mask of the platform's view, on rows or between them."""

import math
from collections.abc import Iterator
from datetime import datetime
from typing import Protocol

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.verification.report import Finding, MaskMargin
from planner.world.frames.time_scales import shifted_utc
from planner.world.platforms import FieldMask

TOLERANCE_RAD = math.radians(0.1 / 3600.0)  # as for pointing
KNOWN_RAD = 1e-5  # 2 arcsec, to which the least distance is found
DIRECTIONS_AT_ONCE = 20_000


def mask_margins(
    masks: tuple[FieldMask, ...], path: "Path", epoch_utc: datetime
) -> tuple[MaskMargin, ...]:
    """How near the boresight comes to each mask, from the first row to the last.

    As near as told somewhere, and nowhere nearer by more than 2 arcsec: the path is halved until
    no part of it is long enough to come nearer.
    """
    margins = []
    for number, mask in enumerate(masks):
        away_rad, t_s = _nearest(path, Region(mask))
        margins.append(
            MaskMargin(
                number=number,
                name=mask.name,
                asked_rad=math.radians(mask.margin_deg),
                away_min_rad=away_rad,
                t_s=t_s,
                at_utc=shifted_utc(epoch_utc, t_s),
            )
        )
    return tuple(margins)


def mask_findings(margins: tuple[MaskMargin, ...]) -> Iterator[Finding]:
    """One error for each mask that is entered."""
    for margin in margins:
        if margin.away_min_rad < margin.asked_rad - TOLERANCE_RAD:
            yield Finding(
                limit="keep_out",
                t_s=margin.t_s,
                at_utc=margin.at_utc,
                detail=(
                    f'the boresight comes {_apart(margin.away_min_rad)} the mask "{margin.name}", '
                    f"{margin.t_s:.2f} s after the table's epoch, and must stay "
                    f"{math.degrees(margin.asked_rad):.3f} deg from it"
                ),
            )


def _apart(away_rad: float) -> str:
    where = "into" if away_rad < 0.0 else "near"
    return f"{abs(math.degrees(away_rad)):.3f} deg {where}"


class Path(Protocol):
    """The boresight's in the frame of the masks, over `count` cells of a table.

    moving: the cells that are looked at.
    """

    count: int
    moving: Indices

    def boresight(self, cell: Indices, u_s: Array) -> Array:
        """Unit vectors (n, 3), u_s after the rows of n cells."""

    def reach_rad(self, cell: Indices, middle_s: Array, half_s: float) -> Array:
        """How far it can be from the middle within half_s of it, (n,)."""


def _nearest(path: Path, region: "Region") -> tuple[float, float]:
    """The least distance and when: of a part of the path, its middle and how far its ends may
    be off that tell whether it must be halved."""
    cell = path.moving
    middle_s = np.full(len(cell), COMMAND_STEP_S / 2.0)
    half_s = COMMAND_STEP_S / 2.0
    last = path.count - 1
    ends = _away_rad(path, region, np.array([0, last]), np.array([0.0, COMMAND_STEP_S]))
    at = int(np.argmin(ends))
    best_rad, best_s = float(ends[at]), at * path.count / ROWS_PER_S
    while cell.size:
        away_rad = _away_rad(path, region, cell, middle_s)
        at = int(np.argmin(away_rad))
        if away_rad[at] < best_rad:
            best_rad = float(away_rad[at])
            best_s = float(cell[at] / ROWS_PER_S + middle_s[at])
        may_be_nearer = away_rad - path.reach_rad(cell, middle_s, half_s) < best_rad - KNOWN_RAD
        half_s /= 2.0
        cell = np.repeat(cell[may_be_nearer], 2)
        middle_s = np.repeat(middle_s[may_be_nearer], 2)
        middle_s[::2] -= half_s
        middle_s[1::2] += half_s
    return best_rad, best_s


def _away_rad(path: Path, region: "Region", cell: Indices, u_s: Array) -> Array:
    away_rad = np.empty(len(cell))
    for first in range(0, len(cell), DIRECTIONS_AT_ONCE):
        part = slice(first, first + DIRECTIONS_AT_ONCE)
        away_rad[part] = region.away_rad(path.boresight(cell[part], u_s[part]))
    return away_rad


class Region:
    """A mask's polygon, in coordinates along and across each side."""

    def __init__(self, mask: FieldMask) -> None:
        corners = np.array(mask.corners_platform)
        corners = corners / np.sqrt(np.sum(corners**2, axis=1, keepdims=True))
        if _solid_angle(corners) < 0.0:
            corners = corners[::-1]
        self._first, self._second = corners, np.roll(corners, -1, axis=0)
        across = np.cross(self._first, self._second)
        self._across = across / np.sqrt(np.sum(across**2, axis=1, keepdims=True))
        self._along = np.cross(self._across, self._first)
        self._length_rad = np.arctan2(
            np.sum(self._along * self._second, axis=1), np.sum(self._first * self._second, axis=1)
        )

    def away_rad(self, directions: Array) -> Array:
        """From unit vectors (n, 3) to the polygon; negative inside."""
        nearest = np.full(len(directions), math.inf)
        winding = np.zeros(len(directions))
        for k, length_rad in enumerate(self._length_rad):
            on_side = np.arctan2(directions @ self._along[k], directions @ self._first[k])
            beyond_middle = np.mod(on_side - length_rad / 2.0 + math.pi, 2.0 * math.pi) - math.pi
            place = length_rad / 2.0 + np.clip(beyond_middle, -length_rad / 2.0, length_rad / 2.0)
            point = np.outer(np.cos(place), self._first[k]) + np.outer(
                np.sin(place), self._along[k]
            )
            apart = np.linalg.norm(directions - point, axis=1)
            nearest = np.minimum(
                nearest, 2.0 * np.arctan2(apart, np.linalg.norm(directions + point, axis=1))
            )
            winding += _seen_angle(directions, self._first[k], self._second[k])
        return np.where(winding > math.pi, -nearest, nearest)


def _seen_angle(directions: Array, first_direction: Array, second_direction: Array) -> Array:
    """By which bearing from a direction a side turns, anticlockwise seen from outside, (n,).

    Over all sides they add up to a whole turn where the polygon winds about the direction, and to
    one backwards where it winds about the opposite one.
    """
    sine = directions @ np.cross(first_direction, second_direction)
    beside = (directions @ first_direction) * (directions @ second_direction)
    cosine = first_direction @ second_direction - beside
    return np.asarray(np.arctan2(sine, cosine))


def _solid_angle(corner_directions: Array) -> float:
    """Positive where the corners go anticlockwise, seen from outside the sphere.

    Source: Van Oosterom, Strackee 1983, of the triangles from the first corner.
    """
    a, b, c = corner_directions[0], corner_directions[1:-1], corner_directions[2:]
    triple = np.sum(a * np.cross(b, c), axis=1)
    return float(np.sum(2.0 * np.arctan2(triple, 1.0 + b @ a + c @ a + np.sum(b * c, axis=1))))
