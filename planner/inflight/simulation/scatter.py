"""Scatter of fitted parameters about the truth, from the residuals of the fit."""

import numpy as np

from planner.base.arrays import Array

_LAGS_SHARE = 0.02  # of a flight's samples: how far errors may go together


def covariance(
    slope_matrix: Array, missed_sigma: Array, weights: Array, prior_parameters: Array
) -> Array:
    """Of n parameters, (n, n), fitted by weighted least squares; errors may go together.

    slope_matrix: (c, k, n), of the misses by the parameters, of c columns of k samples in order of
    time.  missed_sigma, weights: (c, k).  prior_parameters: (n,), 1 sigma.
    Size and autocorrelation of a column's errors are taken where its samples tell of the
    parameters, each counting by its leverage; that is what sums of pulls over stretches can't tell
    where all is told by one stretch, whose pulls the fit has made zero.  Bartlett's window keeps
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
        middle += _middle(
            np.sqrt(weight[there])[:, None] * slope[there],
            np.sqrt(weight[there]) * missed[there],
            inverse,
        )
    factor = np.linalg.cholesky(inverse)
    values, vectors = np.linalg.eigh(factor.T @ middle @ factor)  # 1 where errors are as told
    root = factor @ vectors
    return np.asarray((root * np.maximum(values, 1.0)) @ root.T, dtype=np.float64)


def _middle(slope_matrix: Array, missed_sigma: Array, inverse_matrix: Array) -> Array:
    """Of one column: slope' R slope, R the covariance of its errors."""
    leverage = np.clip(
        np.einsum("kn,nm,km->k", slope_matrix, inverse_matrix, slope_matrix), 0.0, 0.99
    )
    told = np.sqrt(leverage / (1.0 - leverage)) * missed_sigma
    lags = min(max(round(_LAGS_SHARE * len(missed_sigma)), 1), len(missed_sigma) - 1)
    total = float(told @ told) * (slope_matrix.T @ slope_matrix)
    for lag in range(1, lags + 1):
        alike = float(told[lag:] @ told[:-lag]) * (1.0 - lag / (lags + 1.0))
        beside = slope_matrix[lag:].T @ slope_matrix[:-lag]
        total += alike * (beside + beside.T)
    return np.asarray(total / max(float(np.sum(leverage)), 1e-12))
