"""How an attitude to the local vertical goes on after the end of its history.

A vehicle in torque equilibrium swings about its mean attitude with the orbit and its
harmonics; one that has just manoeuvred does not.  Which description foretells best is
measured on the history's own tail, data that the description has not seen.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from planner.arrays import Array

TAIL_S = 60.0  # the present rate is fitted to this much of the history
OFFSET_TAIL_S = 120.0
CUTS = 5
LEAST_CUTS = 2
_LEAST_ROWS = 3


@dataclass(frozen=True)
class Description:
    """What is fitted: `terms` orbital harmonics over the last `orbits`, or none of them.

    Without harmonics: a constant rate relative to LVLH (`has_rate`), or a constant attitude.
    """

    terms: int = 0
    orbits: float = 0.0
    has_rate: bool = False

    def __str__(self) -> str:
        if self.terms:
            plural = "" if self.orbits == 1.0 else "s"
            return f"harmonics to order {self.terms} fitted over {self.orbits:g} orbit{plural}"
        return "constant rate relative to LVLH" if self.has_rate else "constant LVLH attitude"


DESCRIPTIONS = (
    Description(),
    Description(has_rate=True),
    Description(terms=1, orbits=0.5),
    Description(terms=1, orbits=1.0),
    Description(terms=1, orbits=2.0),
    Description(terms=3, orbits=2.0),
)


@dataclass(frozen=True, eq=False)
class Extrapolation:
    """A description fitted; its clock is that of the history, `end_s` its last instant.

    q_reference: body from LVLH.  coefficients_rad: shape (columns, 3), of the rotation vector
    that carries q_reference on.
    """

    description: Description
    period_s: float
    end_s: float
    q_reference: Rotation
    coefficients_rad: Array

    def at(self, t_s: Array) -> Rotation:
        """Body from LVLH at n instants."""
        basis = _basis(self.description, self.period_s, t_s - self.end_s)
        return Rotation.from_rotvec(basis @ self.coefficients_rad) * self.q_reference


@dataclass(frozen=True, eq=False)
class ChosenExtrapolation:
    """The extrapolation chosen, and how all did on the held-out tail.

    lead_s: (k,) edges of the leads tried.  error_rms_body_rad: (k, 3), rms of the
    chosen one's error about each body axis up to each.  rms_by_description_rad: every
    description tried with its rms over all leads.
    """

    extrapolation: Extrapolation
    lead_s: Array
    error_rms_body_rad: Array
    rms_by_description_rad: tuple[tuple[Description, float], ...]


def choose(
    t_s: Array, q_body_from_lvlh: Rotation, period_s: float, lead_s: float
) -> ChosenExtrapolation:
    """Fit what foretells best over `lead_s` (less when the history is short).

    t_s: shape (n,), increasing.  ValueError when the history is too short to try anything.
    """
    lead_s = min(lead_s, (t_s[-1] - t_s[0] - TAIL_S) / 3.0)
    if lead_s < TAIL_S:
        raise ValueError(
            f"the history is only {t_s[-1] - t_s[0]:.0f} s long; at least {4.0 * TAIL_S:.0f} s are "
            "needed to try an extrapolation on its tail"
        )
    cuts_s = [t_s[-1] - lead_s * (1.0 + k / (CUTS - 1)) for k in range(CUTS)]
    trials = []
    for description in DESCRIPTIONS:
        errors = _held_out_errors(description, t_s, q_body_from_lvlh, period_s, cuts_s, lead_s)
        if errors is not None:
            trials.append((description, errors))
    if not trials:
        raise ValueError("the history has too few rows in its tail; send it without gaps")
    rms_rad = [float(np.sqrt(np.mean(np.sum(turn_rad**2, axis=1)))) for _, (_, turn_rad) in trials]
    description, (leads_s, error_body_rad) = trials[int(np.argmin(rms_rad))]
    edges_s = lead_s * np.array([0.25, 0.5, 0.75, 1.0])
    bins = [(leads_s > edge - 0.25 * lead_s) & (leads_s <= edge) for edge in edges_s]
    extrapolation = fit_extrapolation(description, t_s, q_body_from_lvlh, period_s)
    assert extrapolation is not None, "fitted on less history already"
    return ChosenExtrapolation(
        extrapolation=extrapolation,
        lead_s=edges_s,
        error_rms_body_rad=np.array(
            [np.sqrt(np.mean(error_body_rad[b if b.any() else ...] ** 2, axis=0)) for b in bins]
        ),
        rms_by_description_rad=tuple((d, rms) for (d, _), rms in zip(trials, rms_rad, strict=True)),
    )


def _held_out_errors(
    description: Description,
    t_s: Array,
    q_body_from_lvlh: Rotation,
    period_s: float,
    cuts_s: Sequence[float],
    lead_s: float,
) -> tuple[Array, Array] | None:
    """Leads (s) and errors about the body axes (rad, (n, 3)) after each cut.

    None if too few leave enough history before.
    """
    leads, errors = [], []
    for cut_s in cuts_s:
        is_known = t_s <= cut_s
        is_ahead = ~is_known & (t_s <= cut_s + lead_s)
        extrapolation = fit_extrapolation(
            description, t_s[is_known], q_body_from_lvlh[is_known], period_s
        )
        if extrapolation is None:
            break
        miss = extrapolation.at(t_s[is_ahead]) * q_body_from_lvlh[is_ahead].inv()
        leads.append(t_s[is_ahead] - cut_s)
        errors.append(miss.as_rotvec())
    if len(errors) < LEAST_CUTS:
        return None
    return np.concatenate(leads), np.concatenate(errors)


def fit_extrapolation(
    description: Description, t_s: Array, q_body_from_lvlh: Rotation, period_s: float
) -> Extrapolation | None:
    """The description fitted to a history, or None where that is too short for it."""
    window_s = description.orbits * period_s if description.terms else TAIL_S
    if not len(t_s) or t_s[-1] - t_s[0] < 0.95 * window_s:
        return None
    since_end_s = t_s - t_s[-1]
    used = since_end_s >= -window_s
    used[-_LEAST_ROWS:] = True
    q_reference = q_body_from_lvlh[-1]
    turn_rad = (q_body_from_lvlh[used] * q_reference.inv()).as_rotvec()
    basis = _basis(description, period_s, since_end_s[used])
    coefficients_rad: Array = np.asarray(
        np.linalg.lstsq(basis, turn_rad, rcond=None)[0], dtype=np.float64
    )
    if description.terms:
        left_rad = turn_rad - basis @ coefficients_rad
        recent = since_end_s[used] >= -OFFSET_TAIL_S
        coefficients_rad[0] += np.median(left_rad[recent], axis=0)
    return Extrapolation(description, period_s, float(t_s[-1]), q_reference, coefficients_rad)


def _basis(description: Description, period_s: float, since_end_s: Array) -> Array:
    """Columns of the linear model, shape (n, columns); the first is constant."""
    columns = [np.ones_like(since_end_s)]
    if description.has_rate:
        columns.append(since_end_s)
    for term in range(1, description.terms + 1):
        phase_rad = 2.0 * np.pi * term / period_s * since_end_s
        columns += [np.cos(phase_rad), np.sin(phase_rad)]
    return np.stack(columns, axis=1)
