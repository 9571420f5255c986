"""Disturbed flights of a plan: each with errors of its own, judged by what its frames hold."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.commands import CommandTable
from planner.inflight.flights.draws import CAUSES, DRIVE, Draw, draw_run, undisturbed
from planner.inflight.flights.frames import Frames, frames_of
from planner.inflight.flights.outcomes import RunOutcomes
from planner.inflight.flights.scene import SeenTarget, SessionScene
from planner.planning.sessions.uncertainty import OPTIONS as BUDGET_OPTIONS

FRAMES_COMPARED = 11  # of a session, for the causes' shares: errors change slowly, as the budget's
FRAMES_AT_ONCE = 4000  # 60 MB
GEOMETRY = tuple(cause for cause in CAUSES if cause != DRIVE)


class FlownTable(Protocol):
    """What flying a table gives: true shaft angles (k, 2) and the structure's turn (k, 3).

    is_saturated: (k, 2), whether each drive gives all it has.
    """

    @property
    def t_s(self) -> Array: ...
    @property
    def angle_rad(self) -> Array: ...
    @property
    def structure_rad(self) -> Array: ...
    @property
    def is_saturated(self) -> Mask: ...


# Flies the table of a session, told by its number, with the drives that a seed makes; None: as
# they are nominally.
Fly = Callable[[CommandTable, int, int | None], FlownTable]


def fly_runs(
    scenes: Sequence[SessionScene],
    fly: Fly,
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
            draw_run(seed, k, scenes[0].modes) for k in range(run, min(run + 2, first + count))
        ]
        for number, scene in enumerate(scenes):
            judged, pair = _fly_pair(scene, fly, draws)
            found[number] += judged
            if pair is not None:
                pairs[number].append(pair)
        on_run(run + len(draws) - first)
    return [_outcomes(*both) for both in zip(found, pairs, strict=True)]


class NominalFlight(NamedTuple):
    """A session as planned, by nominal drives.

    range_m, angle_rad: (n,) and (n, 2), as frames begin.  saturated_s: (2,), how long each drive
    gives all it has, in the session and the `LEAD_S` before it.
    """

    frames: Frames
    range_m: Array
    angle_rad: Array
    saturated_s: Array


def fly_nominal(scene: SessionScene, fly: Fly) -> NominalFlight:
    """Without errors but those of the drives."""
    [seen] = scene.seen([undisturbed(scene.modes)])
    motion = fly(scene.table, scene.number, None)
    begins_s = scene.at_s[:, 0]
    frames = _frames(scene, motion, seen, scene.at_s)
    return NominalFlight(
        frames,
        seen.ranges_m(begins_s),
        _at(begins_s - scene.from_s, motion.t_s, motion.angle_rad),
        np.diff(motion.t_s) @ motion.is_saturated[:-1],
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


@dataclass(frozen=True, kw_only=True, eq=False)
class _Pair:
    """Members of `RunOutcomes`, of one pair."""

    variance_px2: Array
    total_px2: Array
    first_px2: Array


def _fly_pair(
    scene: SessionScene, fly: Fly, draws: Sequence[Draw]
) -> tuple[list[_Judged], _Pair | None]:
    """One run or two, and the causes' part in what sets these apart."""
    exchanged = [
        mine.with_cause_of(other, cause) for mine, other in _both_ways(draws) for cause in GEOMETRY
    ]
    seen = scene.seen([*draws, *exchanged])
    own, swapped = seen[: len(draws)], seen[len(draws) :]
    motions = [fly(scene.table, scene.number, draw.drive) for draw in draws]
    judged = [
        _judged(_frames(scene, motion, view, scene.at_s), view)
        for motion, view in zip(motions, own, strict=True)
    ]
    if len(draws) < 2:
        return judged, None
    rows = np.unique(np.linspace(0, len(scene.at_s) - 1, FRAMES_COMPARED).round().astype(np.intp))
    at_s = scene.at_s[rows]

    def shows(motion: FlownTable, view: SeenTarget) -> tuple[Array, Array]:
        frames = _frames(scene, motion, view, at_s)
        return frames.place_px, frames.smear_px

    plain = [shows(motion, view) for motion, view in zip(motions, own, strict=True)]
    total, first = np.zeros((2, len(CAUSES))), np.zeros((2, len(CAUSES)))
    for mine, other in ((0, 1), (1, 0)):
        views = swapped[mine * len(GEOMETRY) : (mine + 1) * len(GEOMETRY)]
        changed = dict(zip(GEOMETRY, (shows(motions[mine], view) for view in views), strict=True))
        changed[DRIVE] = shows(motions[other], own[mine])
        for column, cause in enumerate(CAUSES):
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
        flown_s = block_s.ravel() - scene.from_s
        blocks.append(
            frames_of(
                scene.scenario.two_axis,
                block_s,
                _at(flown_s, motion.t_s, motion.angle_rad),
                _at(flown_s, motion.t_s, motion.structure_rad),
                seen.directions_platform(block_s),
            )
        )
    return blocks[0] if len(blocks) == 1 else Frames.joined(blocks)


def _at(t_s: Array, known_s: Array, angle_rad: Array) -> Array:
    """Linear between samples 0.02 s apart: a mode of 2.5 Hz is told 0.4 % too small at most."""
    return np.stack([np.interp(t_s, known_s, column) for column in angle_rad.T], axis=1)


def _judged(frames: Frames, seen: SeenTarget) -> _Judged:
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
    )


def _outcomes(judged: Sequence[_Judged], pairs: Sequence[_Pair]) -> RunOutcomes:
    members = {
        name: np.array([getattr(run, name) for run in judged])
        for name in _Judged.__dataclass_fields__
    }
    shape = (len(pairs), 2, len(CAUSES))
    return RunOutcomes(
        **members,
        variance_px2=np.array([pair.variance_px2 for pair in pairs]).reshape(shape[:2]),
        total_px2=np.array([pair.total_px2 for pair in pairs]).reshape(shape),
        first_px2=np.array([pair.first_px2 for pair in pairs]).reshape(shape),
    )
