"""Parts of a view that the platform's kind decides: keyholes, baseline, zones to keep out of."""

from typing import NamedTuple

from planner.output.view.columns import (
    BaselineSlew,
    ConeTrace,
    ExclusionTrace,
    GyroTrace,
    MaskTrace,
)

OUTLINE_POINTS = 37  # of a cone: every 10 deg around, the first again at the end


class KindParts(NamedTuple):
    """As in `PlanView`; cones and exclusions over the rows of the scene, gyros over those shown."""

    keyholes_rad: tuple[float, ...] = ()
    baseline: tuple[BaselineSlew, ...] = ()
    keep_out: tuple[ConeTrace, ...] = ()
    masks: tuple[MaskTrace, ...] = ()
    exclusions: tuple[ExclusionTrace, ...] = ()
    gyros: GyroTrace | None = None
