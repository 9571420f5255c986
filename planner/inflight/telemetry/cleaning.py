"""Rows in order, each once: what damaged telemetry loses before it is compared, and why."""

from collections import Counter
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.inflight.telemetry.samples import Dropped


@dataclass(frozen=True, kw_only=True)
class CleaningOptions:
    """Which rows of a file are late, sent again, or of a clock that began anew."""

    same_tag_s: float = 1e-6  # a microsecond, the resolution of a time tag
    part_rows_min: int = 10  # fewer in order are a few rows late, no clock that began anew
    overlap_min: float = 0.2  # of a part's rows, with an earlier one's time
    coarse_min: float = 0.2  # of the rows; fewer are packets sent again
    room: float = 2.5  # steps from row to row that noise may put a late row off


OPTIONS = CleaningOptions()


@dataclass(frozen=True, eq=False)
class Ordered:
    """row: numbers of the rows kept, by their tags.  dropped: rows by reason.  reordered: how
    many of the kept came before an earlier one.  notes: on tags too coarse."""

    row: Indices
    dropped: Counter[Dropped]
    reordered: int
    notes: tuple[str, ...]


def order(tag_s: Array, value: Array) -> Ordered:
    """Sorted, each time once, from the longest stretch between resets of the clock.

    tag_s: (n,), NaN where unreadable.  value: (n, k), NaN where there is none.
    """
    dropped: Counter[Dropped] = Counter()
    has_time, has_value = np.isfinite(tag_s), np.isfinite(value).any(axis=1)
    dropped["no_time"] = int(np.sum(~has_time))
    dropped["no_value"] = int(np.sum(has_time & ~has_value))
    row = np.flatnonzero(has_time & has_value)
    kept = _longest_between_resets(tag_s[row], value[row])
    dropped["clock_reset"] = len(row) - int(np.sum(kept))
    row = row[kept]
    reordered = int(np.sum(tag_s[row] < np.maximum.accumulate(tag_s[row]))) if len(row) else 0
    row = row[np.argsort(tag_s[row], kind="stable")]
    is_new = np.diff(tag_s[row], prepend=-np.inf) > OPTIONS.same_tag_s
    dropped["repeated"] = int(np.sum(~is_new))
    return Ordered(row[is_new], dropped, reordered, _notes(tag_s[row], value[row], is_new))


def _notes(tag_s: Array, value: Array, is_new: Mask) -> tuple[str, ...]:
    """tag_s: increasing, as are the rows of value."""
    first = np.maximum.accumulate(np.where(is_new, np.arange(len(is_new)), 0))
    differs = ~is_new & ~((value == value[first]) | ~np.isfinite(value)).all(axis=1)
    if differs.sum() < OPTIONS.coarse_min * len(is_new):
        return ()
    step_s = float(np.median(np.diff(tag_s[is_new]))) if is_new.sum() > 1 else 0.0
    return (
        f"{int(differs.sum())} rows have the time tag of another row, and other values: the tags "
        f"are too coarse, or those of several sources; time_offset_s may be off by {step_s:.3g} s, "
        "whatever its sigma",
    )


def _longest_between_resets(tag_s: Array, value: Array) -> Mask:
    """A clock that began anew gives times that it gave before to other values."""
    starts = [0, *(np.flatnonzero(np.diff(tag_s) < -OPTIONS.same_tag_s) + 1), len(tag_s)]
    parts = [
        range(first, last)
        for first, last in pairwise(starts)
        if last - first >= OPTIONS.part_rows_min
    ]
    longest = max(parts, key=len, default=range(0))
    kept = np.ones(len(tag_s), dtype=bool)
    for part in parts:
        if part != longest and _contradicts(tag_s, value, part, longest):
            kept[part.start : part.stop] = False
    return kept


def _contradicts(tag_s: Array, value: Array, part: range, longest: range) -> bool:
    mine, other = (slice(one.start, one.stop) for one in (part, longest))
    inside = (tag_s[mine] >= tag_s[other][0]) & (tag_s[mine] <= tag_s[other][-1])
    if inside.mean() < OPTIONS.overlap_min:
        return False
    place = np.clip(np.searchsorted(tag_s[other], tag_s[mine][inside]), 1, len(longest) - 1)
    low, high = value[other][place - 1], value[other][place]
    off = (
        np.abs(value[mine][inside] - 0.5 * (low + high)) > OPTIONS.room * np.abs(high - low) + 1e-12
    )
    told = np.isfinite(value[mine][inside]) & np.isfinite(low) & np.isfinite(high)
    return bool(told.any()) and float(off[told].mean()) > 0.5
