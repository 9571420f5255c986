"""The telemetry's clock as the columns that follow their plan tell it, without spikes.

A column that doesn't, of an axis that is dead or flew another plan, tells nothing of the time.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.errors import InvalidInput
from planner.inflight.telemetry.alignment import Alignment, Channel, align
from planner.inflight.telemetry.columns import Kind
from planner.inflight.telemetry.following import spikes_of_angles, spikes_of_rates
from planner.inflight.telemetry.motion import PlannedMotion
from planner.inflight.telemetry.samples import SAMPLES_MIN
from planner.inflight.telemetry.unrelated_columns import follows

_NEAR_S = 60.0  # before and after the plan


@dataclass(frozen=True, kw_only=True, eq=False)
class ToldClock:
    """unrelated: columns that don't follow their plan, by axis and kind, and tell nothing of it."""

    alignment: Alignment
    is_spike: Mask
    unrelated: tuple[tuple[int, Kind], ...]


def tell_clock(
    tag_s: Array,
    angle_rad: Array,
    rate_rad_s: Array,
    motions: Sequence[PlannedMotion],
    start_s: float,
) -> ToldClock:
    """Aligned, spikes found against that, and aligned again without them.

    tag_s: (n,), increasing.  angle_rad, rate_rad_s: (n, 2), NaN where there is none.
    start_s: about what the offset is.
    """
    near = (tag_s > start_s - _NEAR_S) & (tag_s < motions[0].stop_s + start_s + _NEAR_S)
    is_spike = np.zeros(len(tag_s), dtype=bool)
    for _ in range(2):
        channels = _channels(tag_s, angle_rad, rate_rad_s, motions, near & ~is_spike)
        alignment = align(channels, start_s, len(motions))
        on_plan = _on_plan(channels, alignment, start_s, len(motions))
        if len(on_plan) < len(channels):
            alignment = align(on_plan, start_s, len(motions))
        if is_spike.any():
            break
        is_spike = _spikes(alignment.t_s(tag_s), angle_rad, rate_rad_s, motions)
        if not is_spike.any():
            break
    unrelated = [channel for channel in channels if channel not in on_plan]
    return ToldClock(
        alignment=alignment,
        is_spike=is_spike,
        unrelated=tuple((channel.motion.axis, channel.kind) for channel in unrelated),
    )


def _channels(
    tag_s: Array,
    angle_rad: Array,
    rate_rad_s: Array,
    motions: Sequence[PlannedMotion],
    usable: Mask,
) -> list[Channel]:
    kinds: tuple[tuple[Kind, Array], ...] = (("angle", angle_rad), ("rate", rate_rad_s))
    channels = [
        Channel(motion=motion, kind=kind, tag_s=tag_s[own], value=value[own, motion.axis])
        for motion in motions
        for kind, value in kinds
        if (own := usable & np.isfinite(value[:, motion.axis])).sum() >= SAMPLES_MIN
    ]
    if not channels:
        raise InvalidInput(
            f"a comparison needs {SAMPLES_MIN} samples of an axis while the plan is flown",
            field="samples",
        )
    return channels


def _on_plan(
    channels: Sequence[Channel], alignment: Alignment, start_s: float, axes: int
) -> list[Channel]:
    """Without those that follow neither with the clock of all nor with one of their own; all where
    none follows."""
    told = [_follows(one, alignment) for one in channels]
    follows_itself = [
        is_told is False and _follows(one, align([one], start_s, axes)) is True
        for one, is_told in zip(channels, told, strict=True)
    ]
    if not (True in told or True in follows_itself):
        return [*channels]
    return [
        one
        for one, is_told, by_itself in zip(channels, told, follows_itself, strict=True)
        if is_told is not False or by_itself
    ]


def _follows(channel: Channel, alignment: Alignment) -> bool | None:
    t_s = alignment.t_s(channel.tag_s)
    return follows(channel.value, channel.kind, t_s, channel.motion)


def _spikes(
    t_s: Array, angle_rad: Array, rate_rad_s: Array, motions: Sequence[PlannedMotion]
) -> Mask:
    bad = np.zeros(len(t_s), dtype=bool)
    for motion in motions:
        for value, planned, find in (
            (angle_rad[:, motion.axis], motion.angle_rad, spikes_of_angles),
            (rate_rad_s[:, motion.axis], motion.rate_rad_s, spikes_of_rates),
        ):
            own = np.flatnonzero(np.isfinite(value))
            if len(own):
                bad[own] |= find(value[own] - planned(t_s[own]))
    return bad
