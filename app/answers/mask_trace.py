"""A platform's mask in a view: the boresight's angle from it, and its outline."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from app.answers.columns import columns_of, numbers
from app.answers.members import degrees
from app.answers.ranges import Count, HalfTurnDeg, Signed

if TYPE_CHECKING:
    from planner.output.view.masks import MaskTrace

_DECIMALS = 6  # of a unit vector: 0.2 arcsec


@dataclass(frozen=True, kw_only=True)
class MaskTraceOut:
    """One of the platform's `masks`, which are fixed to its base: its outline stays where it is.

    number: of the mask among the platform's, from 0. E.g. `0`.
    name: of the mask. E.g. `"radiator"`.
    asked_deg: angle from it that the boresight must keep, the mask's `margin_deg`. E.g. `1.0`.
    away_deg: of the boresight from the mask's region; negative inside. E.g. `[14.2, 13.9]`.
    outline_platform: unit vectors in the platform frame around the region, without what is asked,
    the first again at the end. E.g. `[[0.0, 0.6, 0.8], [0.0, 0.8, 0.6], [0.6, 0.0, 0.8], [0.0, 0.6,
    0.8]]`.
    outline_deg: per axis, for each of the two ways of pointing there, axis angles at these points;
    null where no angles point there. E.g. `{"alpha": [[10.0, null]], "beta": [[20.0, null]]}`.
    """

    number: Count
    name: str
    asked_deg: HalfTurnDeg
    away_deg: list[Signed]
    outline_platform: list[list[Signed]]
    outline_deg: dict[str, list[list[Signed | None]]]


def mask_trace_out(axis_names: tuple[str, ...], mask: "MaskTrace") -> MaskTraceOut:
    """In degrees."""
    return columns_of(
        MaskTraceOut,
        mask,
        number=mask.number,
        name=mask.name,
        asked_deg=degrees(mask.asked_rad),
        outline_platform=numbers(mask.outline_platform, 1.0, _DECIMALS),
        outline_deg={
            name: numbers(mask.outline_rad[..., axis], math.degrees(1.0), 3)
            for axis, name in enumerate(axis_names)
        },
    )
