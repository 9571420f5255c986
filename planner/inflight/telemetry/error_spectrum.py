"""Spectrum of an error that wanders in time, beside noise of each row by itself.

The wander forgets half of itself in a time.  Source: debiased Whittle likelihood, Sykulski et al.
2019, eqs. 9, 10.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array


@dataclass(frozen=True, kw_only=True)
class SpectrumOptions:
    """Where the fit begins, and how its slopes are taken."""

    rows_max: int = 8192  # a longer stretch is cut, and its parts' powers are averaged
    starts_s: tuple[float, ...] = (0.3, 3.0, 30.0)  # half-lives begun with
    step_log: float = 1e-4  # of the slopes of the spectrum by its parameters' logarithms


OPTIONS = SpectrumOptions()


@dataclass(frozen=True, eq=False)
class ErrorSpectrum:
    """log_parameters: logarithms of the wander's variance, its half-life [s] and the noise's
    variance.  likelier_margin: by how much than noise alone, in logarithm, in the mean of the
    frequencies.  rows, step_s: of the stretch that it was found in.
    """

    log_parameters: Array
    likelier_margin: float
    rows: int
    step_s: float

    def covariance(self, rows: int) -> Array:
        """Of two rows so many steps apart, (rows,), in the error's unit squared."""
        variance, half_life_s, noise = np.exp(self.log_parameters)
        covariance = variance * 0.5 ** (np.arange(rows) * self.step_s / half_life_s)
        covariance[0] += noise
        return np.asarray(covariance)

    def variances_log2(self, blocks: int) -> Array:
        """Of the parameters' logarithms, (3,), by the information of so many stretches' spectra."""
        step = OPTIONS.step_log
        slopes = []
        for turn in step * np.eye(3):
            ahead, behind = (
                _spectrum(self.log_parameters + sign * turn, self.rows, self.step_s)
                for sign in (1.0, -1.0)
            )
            slopes.append(np.log(ahead / behind) / (2.0 * step))
        information = blocks * np.array(slopes) @ np.transpose(slopes)
        unit = np.sqrt(np.maximum(np.diag(information), 1e-12))
        inverse = np.linalg.pinv(information / np.outer(unit, unit), rcond=1e-12)
        return np.asarray(np.maximum(np.diag(inverse), 1.0) / unit**2)


def mean_power(error_stretches: Sequence[Array]) -> tuple[Array, int, int]:
    """Of errors in evenly spaced rows, at all frequencies but none and the highest; of how many
    stretches of how many rows, equally long parts of those that there are."""
    rows = min(max(map(len, error_stretches)), OPTIONS.rows_max)
    powers = [
        np.abs(np.fft.rfft(error[first : first + rows])[1 : (rows + 1) // 2]) ** 2 / rows
        for error in error_stretches
        for first in range(0, len(error) - rows + 1, rows)
    ]
    return np.asarray(np.mean(powers, axis=0)), len(powers), rows


def fit_spectrum(power_level: Array, rows: int, step_s: float) -> ErrorSpectrum | None:
    """The likeliest to the power of so many rows; None where there is no error at all."""
    from scipy.optimize import minimize

    size = float(np.mean(power_level)) if len(power_level) else 0.0
    if not size > 0.0:
        return None

    def misfit(log_parameters: Array) -> float:
        spectrum = _spectrum(log_parameters, rows, step_s)
        return float(np.mean(np.log(spectrum / size) + power_level / spectrum))

    low, high = math.log(size * 1e-8), math.log(size * 1e4)
    bounds = [(low, high), (math.log(0.2 * step_s), math.log(rows * step_s)), (low, high)]
    found = min(
        (
            minimize(misfit, [math.log(size), math.log(start_s), math.log(size)],
                     method="L-BFGS-B", bounds=bounds)
            for start_s in OPTIONS.starts_s
        ),
        key=lambda one: float(one.fun),
    )  # fmt: skip
    log_parameters = np.asarray(found.x, dtype=np.float64)
    return ErrorSpectrum(log_parameters, 1.0 - float(found.fun), rows, step_s)


def _spectrum(log_parameters: Array, rows: int, step_s: float) -> Array:
    """Expected power at the frequencies of `mean_power`.

    Of so many rows a covariance counts less the farther apart they are: the sum of a geometric
    series, and of one that grows with its terms.
    """
    variance, half_life_s, noise = np.exp(log_parameters)
    kept = 0.5 ** (step_s / half_life_s)
    z = kept * np.exp(-2j * np.pi / rows * np.arange(1, (rows + 1) // 2))
    later = 1.0 / (1.0 - z) - z * (1.0 - kept**rows) / (rows * (1.0 - z) ** 2)
    return np.asarray(variance * (2.0 * later.real - 1.0) + noise)
