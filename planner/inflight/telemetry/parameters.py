"""The platform's parameters as identified: of its drives, and its least smooth rate.

The drives' are those with which the simulator makes the same of the table.  A delay that the
drives share looks like a clock that is ahead; here it is taken to be what the platform's own
drives have, and the rest the clock's.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.base.errors import InvalidInput
from planner.inflight.simulation.candidates import IDENTIFIABLE
from planner.inflight.simulation.flight import fly
from planner.inflight.simulation.identification import identify
from planner.inflight.telemetry.alignment import Channel, align
from planner.inflight.telemetry.compare import Comparison
from planner.inflight.telemetry.motion import PlannedMotion
from planner.world.platforms import AxisDrive, TwoAxisPlatform

TABLE_MAX_S = 600.0  # flown about a hundred times, 0.3 s each
SAMPLES_MAX = 20_000
_LEAST_RATE = "rate_min_deg_s"
_ROOM = 1.1  # above the fastest command at which an axis was seen to stick


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """name: `axis.field`.  planned_value: what the platform has.  found_value, sigma: the estimate;
    sigma None where it is a bound."""

    name: str
    planned_value: float
    found_value: float
    sigma: float | None


@dataclass(frozen=True, kw_only=True)
class PlatformFound:
    """parameters: those found.  platform: as planned with, but for these."""

    parameters: tuple[Parameter, ...]
    platform: TwoAxisPlatform


def platform_found(comparison: Comparison, names: Sequence[str]) -> PlatformFound | None:
    """With the drives' parameters of these names, `axis.field`; None where nothing was found.

    Raises InvalidInput for names and plans that can't be identified.
    """
    platform = comparison.plan.scenario.platform
    found: tuple[Parameter, ...] = ()
    if names:
        found, drives = _drives(comparison, names)
        platform = replace(platform, drives=drives)
    least = _least_rates(comparison)
    if not found and not least:
        return None
    limits = list(platform.axis_limits)
    for one in least:
        axis = platform.axis_names.index(one.name.rpartition(".")[0])
        limits[axis] = replace(limits[axis], rate_min_rad_s=math.radians(one.found_value))
    return PlatformFound(
        parameters=(*found, *least), platform=platform.with_limits((limits[0], limits[1]))
    )


def _least_rates(comparison: Comparison) -> list[Parameter]:
    """Of axes that stuck and slipped at commands that the platform takes for smooth."""
    found = []
    for axis in comparison.axes:
        motion = axis.followed.motion
        limits = comparison.plan.scenario.platform.axis_limits[motion.axis]
        fastest_rad_s = max((one.rate_rad_s for one in axis.stick_slip), default=0.0)
        if limits.rate_min_rad_s < fastest_rad_s < limits.rate_max_rad_s / _ROOM:
            found.append(
                Parameter(
                    name=f"{axis.name}.{_LEAST_RATE}",
                    planned_value=math.degrees(limits.rate_min_rad_s),
                    found_value=math.degrees(_ROOM * fastest_rad_s),
                    sigma=None,
                )
            )
    return found


def _drives(
    comparison: Comparison, names: Sequence[str]
) -> tuple[tuple[Parameter, ...], tuple[AxisDrive, AxisDrive]]:
    plan, platform = comparison.plan, comparison.plan.scenario.platform
    _require_identifiable(names, platform, plan.table.t_s[-1])
    clean = comparison.samples
    t_s = comparison.alignment.t_s(clean.tag_s) + _own_delay_s(comparison)
    inside = (t_s >= 0.0) & (t_s <= plan.table.t_s[-1])
    rows = np.flatnonzero(inside)[:: -(-int(inside.sum()) // SAMPLES_MAX)]
    angle_rad, rate_rad_s = (
        column[rows] if np.isfinite(column[rows]).any() else None
        for column in (clean.angle_rad, clean.rate_rad_s)
    )
    try:
        found = identify(plan.table, platform, t_s[rows], angle_rad, rate_rad_s, names)
    except ValueError as fault:
        raise InvalidInput(f"can't be found: {fault}", field="identify") from None
    sigma = np.sqrt(np.diag(found.covariance_parameters))
    parameters = tuple(
        Parameter(
            name=name,
            planned_value=_value(platform, name),
            found_value=float(value),
            sigma=float(error),
        )
        for name, value, error in zip(found.names, found.parameters, sigma, strict=True)
    )
    return parameters, found.drives


def _require_identifiable(names: Sequence[str], platform: TwoAxisPlatform, table_s: float) -> None:
    for number, name in enumerate(names):
        axis, _, field = name.rpartition(".")
        if axis not in platform.axis_names or field not in IDENTIFIABLE:
            raise InvalidInput(
                f"{name[:60]!r} is no parameter that a flight shows; name an axis "
                f"({', '.join(platform.axis_names)}), a dot and one of {', '.join(IDENTIFIABLE)}",
                field=f"identify.{number}",
            )
        if name in names[:number]:
            raise InvalidInput(f"{name!r} is named twice", field=f"identify.{number}")
    if table_s > TABLE_MAX_S:
        raise InvalidInput(
            f"parameters are found of plans up to {TABLE_MAX_S:g} s, not {table_s:g}: leave "
            "identify out, or compare with a plan of one session",
            field="identify",
        )


def _own_delay_s(comparison: Comparison) -> float:
    """By how much the platform's drives are late by themselves, as telemetry would show it."""
    table, platform = comparison.plan.table, comparison.plan.scenario.platform
    flown = fly(table, platform)
    told = {one.followed.motion.axis for one in comparison.axes}
    channels = [
        Channel(
            motion=PlannedMotion(table, axis),
            kind="angle",
            tag_s=flown.t_s,
            value=flown.measured_angle_rad[:, axis],
        )
        for axis in sorted(told)
    ]
    return align(channels, 0.0, len(platform.axis_names)).offset_s.value


def _value(platform: TwoAxisPlatform, name: str) -> float:
    axis, _, field = name.rpartition(".")
    return float(getattr(platform.drives[platform.axis_names.index(axis)], field))
