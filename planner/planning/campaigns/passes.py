"""Windows grouped into passes, each of which begins and ends with the platform at rest."""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Indices

SESSIONS_MAX = 200  # of one plan


@dataclass(frozen=True, kw_only=True)
class PassOptions:
    """Lengths of passes, and how finely the place of a cut between two is chosen."""

    usual_s: float = 3600.0  # longer ones make the choice slower and find no more
    table_max_s: float = 21_600.0  # a longer one's plan takes more work than one request may make
    cut_step_s: float = 10.0


OPTIONS = PassOptions()


@dataclass(frozen=True, kw_only=True, eq=False)
class Looks:
    """When looks are possible, by pass and time; arrays of shape (n,).

    target: row of the request's targets.  from_s, to_s: since the request's start.
    pass_number: ascending from 0.
    """

    target: Indices
    from_s: Array
    to_s: Array
    pass_number: Indices


def longest_pass_s(whole_s: float, rest_s: float) -> float:
    """From the first window to the last, so that a cut leaves room for a look of whole_s on either
    side, as far as a table with the way from rest and back allows."""
    return min(max(OPTIONS.usual_s, 2.0 * (whole_s + rest_s)), OPTIONS.table_max_s - 2.0 * rest_s)


def in_passes(
    target: Indices,
    from_s: Array,
    to_s: Array,
    least_s: Array,
    rest_s: float,
    most_s: float,
    whole_s: float,
) -> Looks:
    """Windows put into passes with room between them to come to rest and leave again.

    least_s: (n,), shorter windows are of no use.  rest_s: the room a pass needs at either end.
    A pass longer than most_s is cut where the least time is lost, and whole_s, the longest look,
    has room before it.
    """
    order = np.argsort(from_s, kind="stable")
    left = np.stack([target[order], from_s[order], to_s[order], least_s[order]], axis=1)
    left = left[left[:, 2] - left[:, 1] >= left[:, 3]]
    found: list[Array] = []
    while len(left):
        latest_s = np.maximum.accumulate(left[:, 2])
        gaps = np.flatnonzero(left[1:, 1] - latest_s[:-1] >= 2.0 * rest_s)
        count = int(gaps[0]) + 1 if gaps.size else len(left)
        one, left = left[:count], left[count:]
        if latest_s[count - 1] - one[0, 1] > most_s:
            one, later = _cut_rest(one, rest_s, most_s, whole_s)
            left = np.concatenate([later, left])
        if len(one):
            found.append(one)
    rows = np.concatenate(found) if found else np.empty((0, 4))
    numbers = np.repeat(np.arange(len(found)), [len(one) for one in found])
    return Looks(
        target=rows[:, 0].astype(np.intp),
        from_s=rows[:, 1],
        to_s=rows[:, 2],
        pass_number=numbers.astype(np.intp),
    )


def _cut_rest(
    window_rows: Array, rest_s: float, most_s: float, whole_s: float
) -> tuple[Array, Array]:
    """What lies before and after a rest within the pass, in order of time."""
    first_s = window_rows[0, 1]
    soonest_s = min(max(0.5 * most_s, whole_s + rest_s), most_s - OPTIONS.cut_step_s)
    middles_s = np.arange(first_s + soonest_s, first_s + most_s, OPTIONS.cut_step_s)
    lost_s = [
        np.maximum(
            np.minimum(window_rows[:, 2], middle_s + rest_s)
            - np.maximum(window_rows[:, 1], middle_s - rest_s),
            0.0,
        ).sum()
        for middle_s in middles_s
    ]
    middle_s = middles_s[int(np.argmin(lost_s))]
    before, after = window_rows.copy(), window_rows.copy()
    before[:, 2] = np.minimum(before[:, 2], middle_s - rest_s)
    after[:, 1] = np.maximum(after[:, 1], middle_s + rest_s)
    before, after = (part[part[:, 2] - part[:, 1] >= part[:, 3]] for part in (before, after))
    return before, after[np.argsort(after[:, 1], kind="stable")]
