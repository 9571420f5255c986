"""Disturbed flights of a plan: each with errors of its own, judged by what its frames hold."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.inflight.flights.draws import Draw, draw_run, undisturbed
from planner.inflight.flights.frames import Frames, frames_of
from planner.inflight.flights.outcomes import RunOutcomes
from planner.inflight.flights.scene import SeenTarget, SessionScene
from planner.inflight.simulation.platforms.flyer import FlownTable
from planner.planning.sessions.uncertainty import OPTIONS as BUDGET_OPTIONS

FRAMES_COMPARED = 11  # of a session, for the causes' shares: errors change slowly, as the budget's
FRAMES_AT_ONCE = 4000  # 60 MB


def fly_runs(
    scenes: Sequence[SessionScene],
    seed: int,
    first: int,
    count: int,
    on_run: Callable[[int], None] = lambda _: None,
) -> list[RunOutcomes]:
    """Runs `first` to before `first` + `count`, by session.

    first: even, as runs 2 k and 2 k + 1 are compared with each other.
    on_run: told how many are done.
    """
    if first % 2:
        raise ValueError(f"runs are flown in pairs, from an even one on, not from {first}")
    found: list[list[_Judged]] = [[] for _ in scenes]
    pairs: list[list[_Pair]] = [[] for _ in scenes]
    for run in range(first, first + count, 2):
        draws = [
            draw_run(seed, k, scenes[0].modes, scenes[0].flyer.flown_causes)
            for k in range(run, min(run + 2, first + count))
        ]
        for number, scene in enumerate(scenes):
            judged, pair = _fly_pair(scene, draws)
            found[number] += judged
            if pair is not None:
                pairs[number].append(pair)
        on_run(run + len(draws) - first)
    causes = scenes[0].flyer.causes
    return [_outcomes(causes, *both) for both in zip(found, pairs, strict=True)]


class NominalFlight(NamedTuple):
    """A session as planned.

    range_m, position: (n,) and (n, c), as frames begin.  saturated_s: (d,), how long each drive
    gives all it has, in the session and before it.  rate_error_rad_s, gyro_numbers: of
    gyros' control, (n, 3), None without, and (k,).
    """

    frames: Frames
    range_m: Array
    position: Array
    saturated_s: Array
    rate_error_rad_s: Array | None
    gyro_numbers: Array


def fly_nominal(scene: SessionScene) -> NominalFlight:
    """Without errors but those of drives and vibration."""
    [seen] = scene.seen([undisturbed(scene.modes)])
    motion = scene.flyer.fly(scene.table, scene.from_s, scene.number, None)
    begins_s = scene.at_s[:, 0]
    frames = _frames(scene, motion, seen, scene.at_s)
    return NominalFlight(
        frames,
        seen.ranges_m(begins_s),
        motion.at(begins_s - scene.from_s)[0],
        motion.saturated_s,
        motion.rate_errors_rad_s(begins_s - scene.from_s),
        scene.steadiness(motion),
    )


@dataclass(frozen=True, kw_only=True)
class _Judged:
    """Members of `RunOutcomes`, of one run."""

    holds: bool
    sharp: bool
    holds_share: float
    sharp_share: float
    miss_rad: float
    miss_m: float
    smear_px: float
    gyro_numbers: Array


@dataclass(frozen=True, kw_only=True, eq=False)
class _Pair:
    """Members of `RunOutcomes`, of one pair."""

    variance_px2: Array
    total_px2: Array
    first_px2: Array


def _fly_pair(scene: SessionScene, draws: Sequence[Draw]) -> tuple[list[_Judged], _Pair | None]:
    """One run or two, and the causes' part in what sets these apart."""
    flyer, motions = scene.flyer, dict[tuple[int, ...], FlownTable]()

    def flown(draw: Draw) -> FlownTable:
        key = tuple(draw.seeds.values())
        if key not in motions:
            motions[key] = flyer.fly(scene.table, scene.from_s, scene.number, draw.seeds)
        return motions[key]

    outside = [cause for cause in flyer.causes if cause not in flyer.flown_causes]
    exchanged = [
        mine.with_cause_of(other, cause) for mine, other in _both_ways(draws) for cause in outside
    ]
    seen = scene.seen([*draws, *exchanged])
    own, swapped = seen[: len(draws)], iter(seen[len(draws) :])
    judged = [
        _judged(_frames(scene, flown(draw), view, scene.at_s), view, scene.steadiness(flown(draw)))
        for draw, view in zip(draws, own, strict=True)
    ]
    if len(draws) < 2:
        return judged, None
    rows = np.unique(np.linspace(0, len(scene.at_s) - 1, FRAMES_COMPARED).round().astype(np.intp))
    at_s = scene.at_s[rows]

    def shows(draw: Draw, view: SeenTarget) -> tuple[Array, Array]:
        frames = _frames(scene, flown(draw), view, at_s)
        return frames.place_px, frames.smear_px

    plain = [shows(draw, view) for draw, view in zip(draws, own, strict=True)]
    total, first = np.zeros((2, len(flyer.causes))), np.zeros((2, len(flyer.causes)))
    for mine, other in ((0, 1), (1, 0)):
        changed = {cause: shows(draws[mine], next(swapped)) for cause in outside}
        for cause in flyer.flown_causes:
            draw = draws[mine].with_cause_of(draws[other], cause)
            changed[cause] = shows(draw, own[mine])
        for column, cause in enumerate(flyer.causes):
            total[:, column] += 0.5 * _half_squares(changed[cause], plain[mine])
            first[:, column] += 0.5 * _half_squares(changed[cause], plain[other])
    return judged, _Pair(variance_px2=_half_squares(*plain), total_px2=total, first_px2=first)


def _both_ways(draws: Sequence[Draw]) -> Iterator[tuple[Draw, Draw]]:
    if len(draws) == 2:
        yield draws[0], draws[1]
        yield draws[1], draws[0]


def _half_squares(one_px: tuple[Array, Array], other_px: tuple[Array, Array]) -> Array:
    """Of places and of smears, summed over the frames, (2,)."""
    return np.array([0.5 * np.sum((a - b) ** 2) for a, b in zip(one_px, other_px, strict=True)])


def _frames(scene: SessionScene, motion: FlownTable, seen: SeenTarget, at_s: Array) -> Frames:
    blocks = []
    for first in range(0, len(at_s), FRAMES_AT_ONCE):
        block_s = at_s[first : first + FRAMES_AT_ONCE]
        position, turn_rad = motion.at(block_s.ravel() - scene.from_s)
        directions_base = seen.directions_at(block_s)
        blocks.append(
            frames_of(scene.scenario.platform, block_s, position, turn_rad, directions_base)
        )
    return blocks[0] if len(blocks) == 1 else Frames.joined(blocks)


def _judged(frames: Frames, seen: SeenTarget, gyro_numbers: Array) -> _Judged:
    range_m = seen.ranges_m(frames.begins_s)
    miss_m = np.where(range_m < BUDGET_OPTIONS.range_max_m, frames.error_rad * range_m, np.inf)
    return _Judged(
        holds=bool(frames.holds.all()),
        sharp=bool(frames.is_sharp.all()),
        holds_share=float(frames.holds.mean()),
        sharp_share=float(frames.is_sharp.mean()),
        miss_rad=float(frames.error_rad.max()),
        miss_m=float(miss_m.max()),
        smear_px=float(np.median(frames.smear_px)),
        gyro_numbers=gyro_numbers,
    )


def _outcomes(
    causes: tuple[str, ...], judged: Sequence[_Judged], pairs: Sequence[_Pair]
) -> RunOutcomes:
    members = {
        name: np.array([getattr(run, name) for run in judged])
        for name in _Judged.__dataclass_fields__
    }
    shape = (len(pairs), 2, len(causes))
    return RunOutcomes(
        causes=causes,
        **members,
        variance_px2=np.array([pair.variance_px2 for pair in pairs]).reshape(shape[:2]),
        total_px2=np.array([pair.total_px2 for pair in pairs]).reshape(shape),
        first_px2=np.array([pair.first_px2 for pair in pairs]).reshape(shape),
    )
