"""Stick-slip of an axis: it stands while its command creeps, then catches up.

Windows of rows, averaged as far as their noise and the command ask for, are cut into parts in
which the axis stands (its measured angle is constant) or follows (its error is): the cut with the
least squares and a price on each part.  An axis is told to stick where that explains its errors
better than steps of an axis that follows and than a swing, by more than chance.  Source: optimal
partitioning, Jackson et al. 2005, sec. 2.
"""

import itertools
import math
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Annotated

import numpy as np

from planner.base.answer_members import Count, Member, answer
from planner.base.arrays import Array, Mask
from planner.inflight.telemetry.following import (
    Followed,
    SizeArcsec,
    Stretch,
    row_noise,
    sensor_step,
)


@dataclass(frozen=True, kw_only=True)
class StickSlipOptions:
    """When an axis is told to have stuck and slipped."""

    window: int = 288  # of averaged rows
    coarser: tuple[int, ...] = (1, 2, 4, 8, 16)  # rows averaged: slow slips show in many
    # sigmas that a window's squares are beyond those of noise, to be looked at
    above_noise: float = 4.0
    clearly: float = 80.0  # squares over the noise's: errors that wander by chance come to 63
    slips_min: int = 3  # fewer are no series
    # of the time stuck: a swing about the command stands still for 0.25 at most
    share_min: float = 0.3
    quanta_min: float = 3.0  # of an encoder's steps in a slip
    exact_rad: float = 1e-10  # JSON's ninth decimal of a degree is 2e-11
    # faster is no creeping: what is told then is a servo's swing
    rate_max_rad_s: float = np.radians(0.2)
    rate_min_rad_s: float = np.radians(0.5 / 3600.0)  # slower is standing
    part_price: float = 6.0  # squares over the noise's: two free numbers a part
    stand_rows_min: int = 3  # fewer may be level by chance


OPTIONS = StickSlipOptions()


@dataclass(frozen=True)
class StaircasePart:
    """Rows first to last, without last.  level: constant part of the angle, or of the error."""

    first: int
    last: int
    stands: bool
    level: float


@dataclass(frozen=True)
class Staircase:
    """cost: squares left over the noise's, and the price of the parts.  left_variance_rad2: of a
    row."""

    cost: float
    left_variance_rad2: float
    parts: tuple[StaircasePart, ...]

    def stands(self, rows: int) -> Mask:
        """Of so many rows, (n,)."""
        mask = np.zeros(rows, dtype=bool)
        for part in self.parts:
            mask[part.first : part.last] = part.stands
        return mask


def fit_staircase(
    error_rad: Array, angle_rad: Array, variance_rad2: float, *, may_stand: bool
) -> Staircase:
    """The cheapest parts.  error_rad, angle_rad: (n,), measured less planned, and measured; n up to
    a few hundred."""
    count = len(error_rad)
    cost_of_part = _squares_of_parts(error_rad)
    is_stand = np.zeros_like(cost_of_part, dtype=bool)
    if may_stand:
        standing = _squares_of_parts(angle_rad)
        too_short = np.tri(count, count + 1, OPTIONS.stand_rows_min - 1, dtype=bool)
        standing[too_short] = np.inf
        is_stand = standing < cost_of_part
        cost_of_part = np.minimum(cost_of_part, standing)
    cost_of_part = cost_of_part / variance_rad2 + OPTIONS.part_price
    cost, origin = np.zeros(count + 1), np.zeros(count + 1, dtype=np.intp)
    for last in range(1, count + 1):
        total = cost[:last] + cost_of_part[:last, last]
        origin[last] = first = int(total.argmin())
        cost[last] = total[first]
    parts: list[StaircasePart] = []
    last = count
    while last:
        first = int(origin[last])
        stands = bool(is_stand[first, last])
        level = float(np.mean((angle_rad if stands else error_rad)[first:last]))
        parts.append(StaircasePart(first, last, stands, level))
        last = first
    left = (float(cost[count]) - OPTIONS.part_price * len(parts)) * variance_rad2
    free = max(count - 2 * len(parts), 1)
    return Staircase(float(cost[count]), left / free, tuple(reversed(parts)))


def swing_squares(t_s: Array, error: Array, variance_rad2: float) -> float:
    """Least squares over the noise's of a swing beside a parabola, at the price of three parts."""
    place = np.linspace(-1.0, 1.0, len(t_s))
    trend, _ = np.linalg.qr(np.polynomial.legendre.legvander(place, 2))
    left = error - trend @ (trend.T @ error)
    cycles = np.arange(1.0, 2.0 * (len(t_s) - 1)) / 4.0  # of the stretch, up to half a row's rate
    phase = 2.0 * np.pi * cycles[:, None] * (t_s - t_s[0]) / (t_s[-1] - t_s[0])
    waves = np.stack([np.cos(phase), np.sin(phase)], axis=1)  # (frequencies, 2, n)
    waves = waves - waves @ trend @ trend.T
    along = waves @ left
    inverse = np.linalg.pinv(waves @ waves.transpose(0, 2, 1), 1e-9)
    explained = np.einsum("fi,fij,fj->f", along, inverse, along)
    return float(left @ left - explained.max()) / variance_rad2 + 3.0 * OPTIONS.part_price


def _squares_of_parts(value: Array) -> Array:
    """About their means, of rows first to last without it, (n, n + 1); infinite where none are."""
    centred = value - value.mean()
    sums, squares = (np.concatenate([[0.0], np.cumsum(one)]) for one in (centred, centred**2))
    last = np.arange(len(value) + 1)
    rows = last - last[:-1, None]
    own = squares - squares[:-1, None] - (sums - sums[:-1, None]) ** 2 / np.maximum(rows, 1)
    return np.where(rows > 0, np.maximum(own, 0.0), np.inf)


@answer
class StickSlip(Stretch):
    """A stretch in which the axis stands while its command moves, and catches up in slips.

    slips: number of slips. E.g. `4`.
    stuck_share: of the time that it stood. E.g. `0.6`.
    slip_rad: the farthest slip. E.g. `10.5`.
    rate_rad_s: largest rate commanded meanwhile [arcsec/s]. E.g. `18.2`.
    """

    slips: Count
    stuck_share: Annotated[float, Member(least=0.0, greatest=1.0, decimals=3)]
    slip_rad: SizeArcsec
    rate_rad_s: SizeArcsec


@dataclass(frozen=True, eq=False)
class _Rows:
    """Averaged rows of a stretch, (n,) each; the command grows.  variance_rad2: of the noise."""

    epoch_utc: datetime
    t_s: Array
    error_rad: Array
    command_rad: Array
    variance_rad2: float

    def cut(self, first: int, last: int) -> "_Rows":
        rows = slice(first, last)
        t_s, error_rad, command_rad = self.t_s[rows], self.error_rad[rows], self.command_rad[rows]
        return replace(self, t_s=t_s, error_rad=error_rad, command_rad=command_rad)


def stick_slip(followed: Followed) -> list[StickSlip]:
    """In order of time."""
    found: list[StickSlip] = []
    quantum_rad = sensor_step(followed.motion.angle_rad(followed.t_s) + followed.error_rad)
    for run in followed.runs:
        t_s = followed.t_s[run]
        if len(t_s) < 8:
            continue
        rate_rad_s = followed.motion.rate_rad_s(t_s)
        creeps = (np.abs(rate_rad_s) > OPTIONS.rate_min_rad_s) & (
            np.abs(rate_rad_s) < OPTIONS.rate_max_rad_s
        )
        kind = np.where(creeps, np.sign(rate_rad_s), 0.0)
        ends = [0, *(np.flatnonzero(np.diff(kind)) + 1).tolist(), len(kind)]
        noise_rad = row_noise(followed.left_rad[run])
        for first, last in itertools.pairwise(ends):
            if kind[first]:
                rows = slice(run.start + first, run.start + last)
                found += _in_stretch(followed, rows, noise_rad, quantum_rad)
    return _apart(found)


def _in_stretch(
    followed: Followed, rows: slice, noise_rad: float, quantum_rad: float
) -> list[StickSlip]:
    t_s, error_rad = followed.t_s[rows], followed.left_rad[rows]
    epoch_utc = followed.motion.table.epoch_utc
    command_rad = followed.motion.angle_rad(t_s)
    if command_rad[-1] < command_rad[0]:
        command_rad, error_rad = -command_rad, -error_rad
    found: list[StickSlip] = []
    for coarser in OPTIONS.coarser:
        first = 0
        while first < len(t_s) - 8:
            moves_rad = float(np.median(np.diff(command_rad[first : first + OPTIONS.window])))
            # Averaged until the command moves by the noise of an average.
            least = (noise_rad / max(moves_rad, 1e-15)) ** (2.0 / 3.0)
            each = coarser * int(min(max(0.5 * least, 1.0), len(t_s)))
            count = min(OPTIONS.window, (len(t_s) - first) // each)
            if count >= 8:
                part = slice(first, first + count * each)
                averages = [
                    one[part].reshape(count, each).mean(axis=1)
                    for one in (t_s, error_rad, command_rad)
                ]
                variance_rad2 = noise_rad**2 / each + quantum_rad**2 / 12.0 + OPTIONS.exact_rad**2
                window = _Rows(epoch_utc, averages[0], averages[1], averages[2], variance_rad2)
                one = _in_window(window, quantum_rad)
                found += [one] if one else []
            first += max(OPTIONS.window // 2 * each, 1)
    return found


def _in_window(rows: _Rows, quantum_rad: float) -> StickSlip | None:
    """What sticks in it, if that is clear."""
    place = np.linspace(-1.0, 1.0, len(rows.t_s))
    trend = np.polynomial.legendre.legvander(place, 2)
    left = rows.error_rad - trend @ np.linalg.lstsq(trend, rows.error_rad, rcond=None)[0]
    free = len(left) - 3
    if np.sum(left**2) < rows.variance_rad2 * (free + OPTIONS.above_noise * math.sqrt(2.0 * free)):
        return None
    variance_rad2 = rows.variance_rad2
    for _ in range(3):  # errors that neither explains are noise, too
        stairs = _stairs(rows, variance_rad2, may_stand=True)
        if stairs.left_variance_rad2 < 1.2 * variance_rad2:
            break
        variance_rad2 = stairs.left_variance_rad2
    stands = [part for part in stairs.parts if part.stands]
    if len(stands) < OPTIONS.slips_min:
        return None
    first, last = stands[0].first, stands[-1].last
    if last < len(rows.t_s):  # the slip that ends it
        last += 1
    stretch = replace(rows, variance_rad2=variance_rad2).cut(first, last)
    return _told(stretch, quantum_rad)


def _stairs(rows: _Rows, variance_rad2: float, *, may_stand: bool) -> Staircase:
    angle_rad = rows.command_rad + rows.error_rad
    return fit_staircase(rows.error_rad, angle_rad, variance_rad2, may_stand=may_stand)


def _told(rows: _Rows, quantum_rad: float) -> StickSlip | None:
    stairs = _stairs(rows, rows.variance_rad2, may_stand=True)
    if not _is_clear(rows, stairs.cost):
        return None
    stands = [part for part in stairs.parts if part.stands]
    command_rad = rows.command_rad
    caught_up = [
        part.level - before.level - (command_rad[part.first] - command_rad[before.last - 1])
        for before, part in itertools.pairwise(stands)
    ]
    ends = rows.error_rad[stands[-1].last :]
    if len(ends):
        caught_up.append(float(ends.max() - rows.error_rad[stands[-1].last - 1]))
    slips = [one for one in caught_up if one > 0.0]
    share = float(stairs.stands(len(rows.t_s)).mean())
    least_rad = OPTIONS.quanta_min * quantum_rad
    if len(slips) < OPTIONS.slips_min or share < OPTIONS.share_min or np.median(slips) <= least_rad:
        return None
    return StickSlip(
        epoch_utc=rows.epoch_utc,
        start_s=float(rows.t_s[0]),
        stop_s=float(rows.t_s[-1]),
        slips=len(slips),
        stuck_share=share,
        slip_rad=max(slips),
        rate_rad_s=float(np.max(np.diff(command_rad) / np.diff(rows.t_s))),
    )


def _is_clear(rows: _Rows, cost: float) -> bool:
    """Whether standing leaves so much less than following and than a swing do."""
    follows = _stairs(rows, rows.variance_rad2, may_stand=False).cost
    if follows - cost < OPTIONS.clearly:
        return False
    # Errors that come and go by chance, and swings, look alike to a command turned round.
    turned = replace(rows, command_rad=-rows.command_rad)
    least = cost + follows - _stairs(turned, rows.variance_rad2, may_stand=True).cost
    if follows - least < OPTIONS.clearly:
        return False
    return swing_squares(rows.t_s, rows.error_rad, rows.variance_rad2) - least >= OPTIONS.clearly


def _apart(found: list[StickSlip]) -> list[StickSlip]:
    """Stretches that overlap, of windows that do and of averages over more rows, as one."""
    apart: list[StickSlip] = []
    for one in sorted(found, key=lambda one: one.start_s):
        if not apart or one.start_s > apart[-1].stop_s:
            apart.append(one)
            continue
        before = apart[-1]
        start_s, stop_s = before.start_s, max(before.stop_s, one.stop_s)
        longer = max(before, one, key=lambda one: one.slips)
        # As often outside of the longer as in it.
        grown = (stop_s - start_s) / max(longer.stop_s - longer.start_s, 1e-9)
        apart[-1] = replace(
            longer,
            start_s=start_s,
            stop_s=stop_s,
            slips=round(longer.slips * grown),
            rate_rad_s=max(before.rate_rad_s, one.rate_rad_s),
        )
    return apart
