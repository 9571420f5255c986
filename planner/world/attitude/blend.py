"""Blends of attitude extrapolations: the share of each by lead time, and its expected error.

Measured on the history's own tail: each description is fitted to what came before a cut, for many
cuts, and compared with what came after.  Each lead has its own weights, since what is best for
the next minutes need not be for the next orbit, and descriptions that do alike are averaged.
"""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.rotation import Rotation
from planner.world.attitude.extrapolation import (
    DESCRIPTIONS,
    TAIL_S,
    Description,
    Extrapolation,
    fit_extrapolation,
)
from planner.world.attitude.manoeuvre import RANDOM_RMS_RAD, last_change, turn_rms_rad

LEADS_S = 150.0 * 2.0 ** np.arange(8)  # to beyond three orbits
LEAST_S = 4.0 * TAIL_S  # of history


@dataclass(frozen=True, kw_only=True)
class BlendOptions:
    """How descriptions of an attitude's course are weighed by the cuts they would have foretold."""

    cut_ratio: float = 1.2  # of the ages of neighbouring cuts
    oldest_cut: float = 4.0  # leads before the end: an older cut says less of how it moves now
    # or as many leads, of the size of the error: few cuts tell it badly
    oldest_told_s: float = 8340.0
    # A description is trusted where its cuts cover half the lead: fewer are alike, and may be
    # luck.
    covered: float = 0.5
    sharpness: float = 3.0  # of the weights in the mean square error; 2 to 3 did alike
    near: tuple[float, float] = (0.8, 1.2)  # leads whose errors count for a lead tried
    floor_rad: float = np.deg2rad(0.003)  # no description is better known than that
    rows: int = 5  # of telemetry, per cut and lead


OPTIONS = BlendOptions()

SETTLED_ORBITS = max(description.orbits for description in DESCRIPTIONS)


@dataclass(frozen=True, eq=False)
class Blend:
    """Descriptions fitted to the history, and for each of LEADS_S what each counts.

    extrapolations: k of them, all from the history's last row.  weights: (m, k), each row's sum
    is 1.  error_rms_body_rad: (m, 3), of the blend about each body axis, on the tail; beyond
    tried_s as it grows by the descriptions' own laws.  changed_s: on the history's clock, when a
    manoeuvre last began or ended; what is older is not used.  None where it holds none.
    under_way: it began, as lately as a swing takes to show.
    """

    extrapolations: tuple[Extrapolation, ...]
    weights: Array
    error_rms_body_rad: Array
    tried_s: float
    changed_s: float | None
    under_way: bool

    @property
    def end_s(self) -> float:
        """The history's last instant, on its clock."""
        return self.extrapolations[0].end_s

    def at(self, t_s: Array) -> Rotation:
        """Body from LVLH at n instants; two times differentiable."""
        q_reference = self.extrapolations[0].q_reference
        weights = _between_leads(self.weights, t_s - self.end_s)
        turn_rad = np.zeros((len(t_s), 3))
        for extrapolation, weight in zip(self.extrapolations, weights.T, strict=True):
            turn = extrapolation.at(t_s) * q_reference.inv()
            turn_rad += weight[:, None] * turn.as_rotvec()
        return Rotation.from_rotvec(turn_rad) * q_reference

    def error_rms_at(self, lead_s: Array) -> Array:
        """Expected rms about each body axis (rad), shape (n, 3).

        How a manoeuvre under way goes on its tail can't tell beyond the next minutes.
        """
        if self.under_way:
            turn_rad = turn_rms_rad(lead_s, self.extrapolations[0].period_s)
            rms_rad = np.hypot(self.error_rms_body_rad[0], turn_rad[:, None])
        else:
            rms_rad = _between_leads(self.error_rms_body_rad, lead_s)
        return np.asarray(np.minimum(rms_rad, RANDOM_RMS_RAD))

    def shares_at(self, lead_s: float) -> list[tuple[Description, float]]:
        """The descriptions and their weights, the weightiest first."""
        weights = _between_leads(self.weights, np.array([lead_s]))[0]
        found = [
            (e.description, float(w)) for e, w in zip(self.extrapolations, weights, strict=True)
        ]
        return sorted(found, key=lambda pair: -pair[1])


def blend(t_s: Array, q_body_from_lvlh: Rotation, period_s: float) -> Blend:
    """Fit and weigh the descriptions.

    t_s: shape (n,), increasing.  ValueError when the history is too short to try anything.
    """
    if t_s[-1] - t_s[0] < LEAST_S:
        raise ValueError(
            f"the history is only {t_s[-1] - t_s[0]:.0f} s long; at least {LEAST_S:.0f} s are "
            "needed to try an extrapolation on its tail"
        )
    change = last_change(t_s, q_body_from_lvlh)
    changed_s, under_way = None, False
    if change is not None:
        changed_s = float(t_s[change.row])
        since_s = float(t_s[-1]) - changed_s
        under_way = change.is_begin and since_s < SETTLED_ORBITS * period_s
        if since_s >= LEAST_S:
            t_s, q_body_from_lvlh = t_s[change.row :], q_body_from_lvlh[change.row :]
    fits = [fit_extrapolation(d, t_s, q_body_from_lvlh, period_s) for d in DESCRIPTIONS]
    extrapolations = tuple(fit for fit in fits if fit is not None)
    descriptions = tuple(extrapolation.description for extrapolation in extrapolations)
    trials = _lead_trials(descriptions, t_s, q_body_from_lvlh, period_s)
    # What swings at the orbital rate is farthest off half an orbit later, not what turns.
    growing_s = np.minimum(LEADS_S, np.inf if under_way else 0.5 * period_s)
    mean_square_rad2, rows_tried = _mean_squares(trials, descriptions, growing_s)
    if not len(rows_tried):
        raise ValueError("the history has too few rows in its tail; send it without gaps")
    likely = 1.0 / (mean_square_rad2 + OPTIONS.floor_rad**2) ** OPTIONS.sharpness
    weights = likely / likely.sum(axis=1, keepdims=True)
    return Blend(
        extrapolations=extrapolations,
        weights=weights,
        error_rms_body_rad=_blend_rms(trials, weights, mean_square_rad2, rows_tried),
        tried_s=float(LEADS_S[rows_tried[-1]]),
        changed_s=changed_s,
        under_way=under_way,
    )


@dataclass(frozen=True, eq=False)
class _Trial:
    """A cut age_s before the end: errors of k descriptions at n rows about a lead, (k, n, 3), NaN
    for a description that its history is too short for.
    """

    age_s: float
    error_rad: Array


def _lead_trials(
    descriptions: tuple[Description, ...], t_s: Array, q_body_from_lvlh: Rotation, period_s: float
) -> list[list[_Trial]]:
    """Trials of each lead, the youngest cut first."""
    trials: list[list[_Trial]] = [[] for _ in LEADS_S]
    age_s = LEADS_S[0]
    while age_s <= t_s[-1] - t_s[0] - TAIL_S:
        known = int(np.searchsorted(t_s, t_s[-1] - age_s, side="right"))
        fits = [
            fit_extrapolation(d, t_s[:known], q_body_from_lvlh[:known], period_s)
            for d in descriptions
        ]
        for lead_s, found in zip(LEADS_S, trials, strict=True):
            if lead_s <= age_s <= max(OPTIONS.oldest_cut * lead_s, OPTIONS.oldest_told_s):
                near_s = t_s[known - 1] + lead_s * np.array(OPTIONS.near)
                rows = np.arange(*np.searchsorted(t_s, near_s))
                rows = rows[:: max(1, len(rows) // OPTIONS.rows)]
                if len(rows) and any(fit is not None for fit in fits):
                    found.append(_Trial(age_s, _errors(fits, t_s[rows], q_body_from_lvlh[rows])))
        age_s *= OPTIONS.cut_ratio
    return trials


def _errors(fits: list[Extrapolation | None], t_s: Array, q_body_from_lvlh: Rotation) -> Array:
    error_rad = np.full((len(fits), len(t_s), 3), np.nan)
    for k, fit in enumerate(fits):
        if fit is not None:
            error_rad[k] = (fit.at(t_s) * q_body_from_lvlh.inv()).as_rotvec()
    return error_rad


def _mean_squares(
    trials: list[list[_Trial]], descriptions: tuple[Description, ...], growing_s: Array
) -> tuple[Array, Indices]:
    """Of each description's error at each lead (m, k), and at which leads any was measured.

    One not tried at a lead is taken to do as at the lead before, or the next one tried, grown or
    shrunk by its law with growing_s, (m,).
    """
    mean_square_rad2 = np.full((len(LEADS_S), len(descriptions)), np.nan)
    for row, (lead_s, found) in enumerate(zip(LEADS_S, trials, strict=True)):
        for k in range(len(descriptions)):
            recent = [trial for trial in found if trial.age_s <= OPTIONS.oldest_cut * lead_s]
            mine = [trial for trial in recent if not np.isnan(trial.error_rad[k, 0, 0])]
            covered_s = mine[-1].age_s - mine[0].age_s if mine else 0.0
            if len(mine) > 1 and (row == 0 or covered_s >= OPTIONS.covered * lead_s):
                squares = [np.sum(trial.error_rad[k] ** 2, axis=1) for trial in mine]
                mean_square_rad2[row, k] = np.mean(np.concatenate(squares))
    rows_tried = np.flatnonzero(np.isfinite(mean_square_rad2).any(axis=1))
    growth = growing_s[:, None] ** [2.0 * description.growth for description in descriptions]
    for row in range(1, len(LEADS_S)):
        unknown = np.isnan(mean_square_rad2[row])
        before = mean_square_rad2[row - 1] / growth[row - 1]
        mean_square_rad2[row, unknown] = (before * growth[row])[unknown]
    for row in range(len(LEADS_S) - 2, -1, -1):
        unknown = np.isnan(mean_square_rad2[row])
        after = mean_square_rad2[row + 1] / growth[row + 1]
        mean_square_rad2[row, unknown] = (after * growth[row])[unknown]
    return np.where(np.isnan(mean_square_rad2), np.inf, mean_square_rad2), rows_tried


def _blend_rms(
    trials: list[list[_Trial]], weights: Array, mean_square_rad2: Array, rows_tried: Indices
) -> Array:
    """Errors of the blend about each body axis, never less than at a shorter lead, shape (m, 3)."""
    finite = np.where(np.isfinite(mean_square_rad2), mean_square_rad2, 0.0)
    expected_rad = np.sqrt(np.sum(weights * finite, axis=1))
    rms_rad = np.zeros((len(LEADS_S), 3))
    for row in rows_tried:
        errors = []
        for trial in trials[row]:
            known = np.isfinite(trial.error_rad[:, 0, 0])
            share = np.where(known, weights[row], 0.0)
            errors.append(np.tensordot(share / share.sum(), np.nan_to_num(trial.error_rad), 1))
        rms_rad[row] = np.sqrt(np.mean(np.concatenate(errors) ** 2, axis=0))
    for row in np.setdiff1d(np.arange(len(LEADS_S)), rows_tried):
        near = max(rows_tried[rows_tried < row], default=rows_tried[0])
        rms_rad[row] = rms_rad[near] * expected_rad[row] / expected_rad[near]
    return np.asarray(np.maximum.accumulate(rms_rad, axis=0))


def _between_leads(rows: Array, lead_s: Array) -> Array:
    """Rows of LEADS_S blended at n leads by a quintic that is smooth to the second derivative."""
    place = np.log2(np.clip(lead_s, LEADS_S[0], LEADS_S[-1]) / LEADS_S[0])
    below = np.minimum(place.astype(int), len(LEADS_S) - 2)
    x = (place - below)[:, None]
    share = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    return np.asarray(rows[below] * (1.0 - share) + rows[below + 1] * share)
