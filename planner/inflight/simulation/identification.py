"""Identification of a platform's drives from the angles or rates that they flew."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import CommandTable
from planner.inflight.simulation.candidates import (
    FRICTION,
    Candidates,
    candidates,
    with_parameters,
)
from planner.world.platforms import AxisDrive, TwoAxisPlatform

# Scatter of fitted parameters about the truth, from the residuals of the fit.

_LAGS_SHARE = 0.02  # of a flight's samples: how far errors may go together


def covariance(
    slope_matrix: Array, missed_sigma: Array, weights: Array, prior_parameters: Array
) -> Array:
    """Covariance of n parameters, (n, n), fitted by weighted least squares; errors may go together.

    slope_matrix: (c, k, n), of the misses by the parameters, of c columns of k samples in order of
    time.  missed_sigma, weights: (c, k).  prior_parameters: (n,), 1 sigma.
    Size and autocorrelation of a column's errors are taken where its samples tell of the
    parameters, each counting by its leverage; that is what sums of pulls over stretches can't tell
    where all is decided by one stretch, whose pulls the fit has made zero.  Bartlett's window keeps
    the result a covariance (Newey and West 1987, Econometrica 55, 703).
    Never less than samples by themselves tell, their errors being those of the sensors.
    """
    n = slope_matrix.shape[2]
    prior = np.diag(1.0 / prior_parameters**2)
    information = prior + np.einsum("ckn,ck,ckm->nm", slope_matrix, weights, slope_matrix)
    inverse = np.linalg.inv(information)
    middle = prior.copy()
    for slope, missed, weight in zip(slope_matrix, missed_sigma, weights, strict=True):
        there = missed != 0.0
        if np.count_nonzero(there) <= n:
            continue
        middle += _sandwich_middle(
            np.sqrt(weight[there])[:, None] * slope[there],
            np.sqrt(weight[there]) * missed[there],
            inverse,
        )
    factor = np.linalg.cholesky(inverse)
    values, vectors = np.linalg.eigh(factor.T @ middle @ factor)  # 1 where errors are as stated
    root = factor @ vectors
    return np.asarray((root * np.maximum(values, 1.0)) @ root.T, dtype=np.float64)


def _sandwich_middle(slope_matrix: Array, missed_sigma: Array, inverse_matrix: Array) -> Array:
    """The middle of one column: slope' R slope, R the covariance of its errors."""
    leverage = np.clip(
        np.einsum("kn,nm,km->k", slope_matrix, inverse_matrix, slope_matrix), 0.0, 0.99
    )
    alone = np.sqrt(leverage / (1.0 - leverage)) * missed_sigma
    lags = min(max(round(_LAGS_SHARE * len(missed_sigma)), 1), len(missed_sigma) - 1)
    total = float(alone @ alone) * (slope_matrix.T @ slope_matrix)
    for lag in range(1, lags + 1):
        alike = float(alone[lag:] @ alone[:-lag]) * (1.0 - lag / (lags + 1.0))
        beside = slope_matrix[lag:].T @ slope_matrix[:-lag]
        total += alike * (beside + beside.T)
    return np.asarray(total / max(float(np.sum(leverage)), 1e-12))


# Sticking and slipping has many local optima. Friction is tried from a sixth of the platform's to
# six times by what is left of its misses over a period of the loop, which hardly feels when the
# axis slips; then around the best, closer than slips keep step, as the platform's axes let go and
# as ones do that are nearly rigid before they slide.
_COARSE_TRIES = np.linspace(-math.log(6.0), math.log(6.0), 31)
_FINE_TRIES = np.linspace(-0.18, 0.18, 10)
_MANNERS: tuple[Mapping[str, float], ...] = (
    {},
    {"presliding_arcsec": -1.6, "presliding_damping": -2.0, "damping": 0.1},
)


@dataclass(frozen=True, kw_only=True)
class IdentificationOptions:
    """How the drives' parameters are fitted."""

    least_sigma_arcsec: float = 0.1  # and arcsec/s: what telemetry between two control steps costs
    robust_sigmas: float = 5.0  # above, a residual weighs by its size, not its square
    difference: float = 1e-3  # of logarithms: a thousand times what the integrator leaves uncertain
    # evaluations of the loop and its derivatives; then the fit is reported as it is
    rounds_max: int = 25
    # of a friction's logarithm: by which Karnopp's law, flown, is mistaken for ours
    law_sigma: float = 0.03


OPTIONS = IdentificationOptions()

_ARCSEC_RAD = math.radians(1.0 / 3600.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Identified:
    """Parameters of the drives with their uncertainty.

    names: (n,), `axis.field` of `AxisDrive`.  parameters: (n,), in the field's unit.
    covariance_parameters: (n, n), in their products: of what the samples show, errors that go
    together counted as such, held by a prior of a factor of ten.
    drives: the platform's with these parameters.
    residual_rad, residual_rad_s: (2,), root mean square of each axis's angles and rates; NaN
    where none were measured.  bias_rad_s: (2,), of the gyros, taken out before.
    """

    names: tuple[str, ...]
    parameters: Array
    covariance_parameters: Array
    drives: tuple[AxisDrive, AxisDrive]
    residual_rad: Array
    residual_rad_s: Array
    bias_rad_s: Array


def identify(
    table: CommandTable,
    platform: TwoAxisPlatform,
    t_s: Array,
    measured_angle_rad: Array | None,
    measured_rate_rad_s: Array | None,
    names: Sequence[str],
) -> Identified:
    """Fit by least squares between what was measured and what the simulator makes of the table.

    t_s: (k,), ascending seconds since the table's epoch; samples before its first row or after
    its last aren't used.  measured_angle_rad, measured_rate_rad_s: (k, 2), NaN where there is
    none; of the encoders and of rate gyros, whose constant bias is estimated, too.
    names: `axis.field`, fields of `IDENTIFIABLE`; a constant pull of the cables shows only where
    the loop has no integral.  Coulomb friction takes the breakaway along in
    proportion unless that is named, too; where either is named, how the axis lets go (breakaway
    over Coulomb friction, Stribeck's rate, presliding) and its loop's damping are fitted along
    around the platform's, and what they leave open is in the covariance.  All else is the
    platform's: what is wrong there goes into residuals and parameters.  A latency and an offset
    of the clock look alike.
    """
    tried = candidates(table, platform, t_s, measured_angle_rad, measured_rate_rad_s, names)
    moved = _best_start(tried)
    sigma = _miss_sigmas(tried, moved)
    moved = _fit_parameters(tried, moved, sigma)
    sigma = _miss_sigmas(tried, moved)
    moved = _fit_parameters(tried, moved, sigma)
    covariance_moved = _moved_covariance(tried, moved, _miss_sigmas(tried, moved))
    n, slope = len(names), tried.slope(moved)
    parameters = tried.values(moved)[:n]
    angle_rad, rate_rad_s, bias_rad_s = tried.residuals(tried.drives(moved))
    return Identified(
        names=tuple(names),
        parameters=parameters,
        covariance_parameters=(covariance_moved * np.outer(slope, slope))[:n, :n],
        drives=with_parameters(platform, platform.drives, names, parameters),
        residual_rad=_root_mean_square(angle_rad),
        residual_rad_s=_root_mean_square(rate_rad_s),
        bias_rad_s=bias_rad_s,
    )


def _best_start(tried: Candidates) -> Array:
    """Where the search begins."""
    best, friction = np.zeros(len(tried.names)), tried.is_one_of(*FRICTION)
    if not np.any(friction):
        return best
    coarse = [_period_cost(tried, best + shift * friction) for shift in _COARSE_TRIES]
    best = best + friction * _COARSE_TRIES[_cheapest_try(coarse)][tried.of_axis]
    sigma = _miss_sigmas(tried, best)
    fine = []
    for manner in _MANNERS:
        to = np.array([manner.get(name.split(".")[1], 0.0) for name in tried.names])
        fine += [best + to + shift * friction for shift in _FINE_TRIES]
    first = _cheapest_try([_robust_cost(tried.misses(moved, sigma)) for moved in fine])
    found: Array = np.array(fine)[first[tried.of_axis], np.arange(len(best))]
    return found


def _cheapest_try(costs_by_try: Sequence[Array]) -> Array:
    """The number of the cheapest try of each axis, (2,)."""
    found: Array = np.argmin(np.array(costs_by_try), axis=0)
    return found


def _robust_cost(missed_sigma: Array) -> Array:
    """The cost as least_squares adds it up, of each axis, (2,)."""
    size = (missed_sigma / OPTIONS.robust_sigmas) ** 2
    total: Array = np.sum(np.sqrt(1.0 + size) - 1.0, axis=0)
    return total


def _period_cost(tried: Candidates, moved_parameters: Array) -> Array:
    """The cost of misses averaged over a period of each axis's loop, (2,)."""
    drives = tried.drives(moved_parameters)
    missed = tried.misses(moved_parameters, _sensors(tried.platform)).reshape(2, len(tried.t_s), 2)
    spacing_s = float(np.median(np.diff(tried.t_s)))
    costs = np.zeros(2)
    for axis, drive in enumerate(drives):
        together = max(round(1.0 / (drive.bandwidth_hz * spacing_s)), 1)
        window = np.ones(together) / math.sqrt(together)
        for column in missed[:, :, axis]:
            costs[axis] += float(_robust_cost(np.convolve(column, window, "valid")[:, None])[0])
    return costs


def _sensors(platform: TwoAxisPlatform) -> Array:
    """1 sigma of angles and of rates of each axis, as the platform has it, (2, 2)."""

    def sigma_of(step: str, noise: str) -> list[float]:
        return [
            _ARCSEC_RAD
            * math.hypot(
                getattr(drive, step) / math.sqrt(12.0),
                getattr(drive, noise),
                OPTIONS.least_sigma_arcsec,
            )
            for drive in platform.drives
        ]

    return np.array(
        [
            sigma_of("encoder_step_arcsec", "encoder_noise_arcsec"),
            sigma_of("gyro_step_arcsec_s", "gyro_noise_arcsec_s"),
        ]
    )


def _miss_sigmas(tried: Candidates, moved_parameters: Array) -> Array:
    """The sigmas, as large as half of the samples miss by, where that is more."""
    sigma = _sensors(tried.platform)
    angle_rad, rate_rad_s, _ = tried.residuals(tried.drives(moved_parameters))
    for kind, missed in enumerate((angle_rad, rate_rad_s)):
        for axis, column in enumerate(missed.T):
            there = column[np.isfinite(column)]
            if len(there) > 0:
                spread = 1.4826 * float(np.median(np.abs(there)))
                sigma[kind, axis] = max(sigma[kind, axis], spread)
    return sigma


def _miss_slopes(tried: Candidates, moved_parameters: Array, sigma: Array) -> Array:
    """Of the misses, (2 k, 2), by the parameters of their own axis, (2 k, 2, n): the axes hardly
    feel each other, so that one flight moves a parameter of each."""
    here = tried.misses(moved_parameters, sigma)
    slopes = np.zeros((*here.shape, len(moved_parameters)))
    own = [np.flatnonzero(tried.of_axis == axis) for axis in range(2)]
    for number in range(max(len(one) for one in own)):
        moved = moved_parameters.copy()
        now = [(axis, one[number]) for axis, one in enumerate(own) if number < len(one)]
        for _, k in now:
            moved[k] += OPTIONS.difference
        change = (tried.misses(moved, sigma) - here) / OPTIONS.difference
        for axis, k in now:
            slopes[:, axis, k] = change[:, axis]
    return slopes


def _fit_parameters(tried: Candidates, start_parameters: Array, sigma: Array) -> Array:
    """Parameters as they fit best from where the search starts."""
    from scipy.optimize import least_squares  # half a second, which most processes never need

    prior = tried.prior_parameters

    def misses_of(moved_parameters: Array) -> Array:
        scaled = tried.misses(moved_parameters, sigma).ravel()
        return np.append(scaled, moved_parameters / prior)

    def slopes_of(moved_parameters: Array) -> Array:
        scaled = _miss_slopes(tried, moved_parameters, sigma).reshape(-1, len(prior))
        return np.concatenate([scaled, np.diag(1.0 / prior)])

    found = least_squares(
        misses_of,
        start_parameters,
        slopes_of,
        bounds=(tried.least_parameters, np.inf),
        loss="soft_l1",
        f_scale=OPTIONS.robust_sigmas,
        xtol=1e-4,
        ftol=1e-4,
        max_nfev=OPTIONS.rounds_max,
    )
    return np.asarray(found.x)


def _moved_covariance(tried: Candidates, moved_parameters: Array, sigma: Array) -> Array:
    """Covariance of what moves the parameters, (n, n); the axes' don't go together.

    Friction's with what the law itself leaves open, which no residual of one flight shows.
    """
    samples, n = len(tried.t_s), len(moved_parameters)
    missed = tried.misses(moved_parameters, sigma)
    slopes = _miss_slopes(tried, moved_parameters, sigma)
    weights = 1.0 / np.sqrt(1.0 + (missed / OPTIONS.robust_sigmas) ** 2)
    found = np.zeros((n, n))
    for axis in range(2):
        own = np.flatnonzero(tried.of_axis == axis)
        if len(own) > 0:
            found[np.ix_(own, own)] = covariance(
                slopes[:, axis, own].reshape(2, samples, len(own)),
                missed[:, axis].reshape(2, samples),
                weights[:, axis].reshape(2, samples),
                tried.prior_parameters[own],
            )
    return found + np.diag(tried.is_one_of(*FRICTION) * OPTIONS.law_sigma**2)


def _root_mean_square(missed_value: Array) -> Array:
    """Root mean square of each column, without what isn't there."""
    there = np.isfinite(missed_value)
    count = np.count_nonzero(there, axis=0)
    squares = np.sum(np.where(there, missed_value, 0.0) ** 2, axis=0)
    found: Array = np.where(count > 0, np.sqrt(squares / np.maximum(count, 1)), np.nan)
    return found
