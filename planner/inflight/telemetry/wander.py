"""Wander of an attitude about its plan, and the noise of its sensor from row to row.

The error's spectrum is fitted by that of a wander that forgets half of itself in a time, and of
white noise.  Source: debiased Whittle likelihood, Sykulski et al. 2019, eqs. 9, 10.
"""

import math
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.inflight.telemetry.estimates import Estimate
from planner.inflight.telemetry.following import Followed


@dataclass(frozen=True, kw_only=True)
class WanderOptions:
    """How much of an error is looked at, and when it is told to wander."""

    rows_min: int = 128  # of a stretch without a gap: a spectrum of fewer tells no shape
    rows_max: int = 8192  # of a spectrum: a longer stretch is cut, and its parts' are averaged
    starts_s: tuple[float, ...] = (0.3, 3.0, 30.0)  # half-lives begun with
    half_lives_min: float = 8.0  # in a stretch: fewer and its size is a matter of chance
    step_log: float = 1e-4  # of the slopes of the spectrum by its parameters' logarithms
    # Times what the spectrum tells: the fit of clock and biases takes some of a wander with it, and
    # squares of errors over the spectrum's sigmas come to 1.2 to 1.5 squared in 48 flights.
    room: float = 1.25
    spread_log_max: float = 0.5  # 1 sigma of a logarithm, for a wander to be told
    likelier: float = 12.0  # by how much, in logarithm, than noise alone: 1e-5 by chance
    line_above: float = 20.0  # times the spectrum's power: 2e-9 by chance


OPTIONS = WanderOptions()


@dataclass(frozen=True, kw_only=True)
class Wander:
    """sigma_rad, half_life_s: of the wander; None where none is told.  noise_rad: of the sensor,
    1 sigma, each row by itself."""

    sigma_rad: Estimate | None
    half_life_s: Estimate | None
    noise_rad: Estimate

    def explains(
        self, frequency_hz: float, amplitude_rad: float, rows: float, step_s: float
    ) -> bool:
        """Whether it may swing so by chance, in so many rows."""
        power_rad2 = self.noise_rad.value**2
        if self.sigma_rad is not None and self.half_life_s is not None:
            kept = 0.5 ** (step_s / self.half_life_s.value)
            turned = 1.0 - 2.0 * kept * math.cos(2.0 * math.pi * frequency_hz * step_s) + kept**2
            power_rad2 += self.sigma_rad.value**2 * (1.0 - kept**2) / turned
        return amplitude_rad**2 * rows / 4.0 < OPTIONS.line_above * power_rad2


def wander_of(followed: Followed) -> Wander | None:
    """Of what gain and bias leave of the angles; None where no stretch is long enough."""
    runs = [run for run in followed.runs if run.stop - run.start >= OPTIONS.rows_min]
    if followed.basis != "angles" or not runs:
        return None
    rows = min(max(run.stop - run.start for run in runs), OPTIONS.rows_max)
    powers, step_s = [], 0.0
    for run in runs:
        t_s, left_rad = followed.t_s[run], followed.left_rad[run]
        step_s = step_s or float(np.median(np.diff(t_s)))
        for first in range(0, len(t_s) - rows + 1, rows):
            # The fastest half is enough: at none is the mean, which the bias has taken.
            transform = np.fft.rfft(left_rad[first : first + rows])[1 : (rows + 1) // 2]
            powers.append(np.abs(transform) ** 2 / rows)
    power = np.mean(powers, axis=0)
    return _told(power, len(powers), rows, step_s)


def _told(power_rad2: Array, blocks: int, rows: int, step_s: float) -> Wander | None:
    from scipy.optimize import minimize

    size_rad2 = float(np.mean(power_rad2))
    if not size_rad2 > 0.0:
        return None

    def misfit(log_parameters: Array) -> float:
        spectrum = _spectrum(log_parameters, rows, step_s)
        return float(np.mean(np.log(spectrum / size_rad2) + power_rad2 / spectrum))

    low, high = math.log(size_rad2 * 1e-8), math.log(size_rad2 * 1e4)
    bounds = [(low, high), (math.log(0.2 * step_s), math.log(rows * step_s)), (low, high)]
    found = min(
        (
            minimize(misfit, [math.log(size_rad2), math.log(start_s), math.log(size_rad2)],
                     method="L-BFGS-B", bounds=bounds)
            for start_s in OPTIONS.starts_s
        ),
        key=lambda one: float(one.fun),
    )  # fmt: skip
    log_parameters = np.asarray(found.x, dtype=np.float64)
    variance_log2 = _variances(log_parameters, blocks, rows, step_s)
    wander_s, half_life, noise = (
        # The first and the last are of squares.
        Estimate(
            value=math.exp(log * share),
            sigma=OPTIONS.room * math.exp(log * share) * share * math.sqrt(variance),
        )
        for log, share, variance in zip(
            log_parameters.tolist(), (0.5, 1.0, 0.5), variance_log2.tolist(), strict=True
        )
    )
    if len(power_rad2) * blocks * (1.0 - float(found.fun)) < OPTIONS.likelier:
        white = math.sqrt(size_rad2)
        noise = Estimate(value=white, sigma=white / math.sqrt(2.0 * rows * blocks))
        return Wander(sigma_rad=None, half_life_s=None, noise_rad=noise)
    is_told = (
        math.sqrt(float(variance_log2[:2].max())) < OPTIONS.spread_log_max
        and half_life.value * OPTIONS.half_lives_min < rows * step_s
    )
    return Wander(
        sigma_rad=wander_s if is_told else None,
        half_life_s=half_life if is_told else None,
        noise_rad=noise,
    )


def _variances(log_parameters: Array, blocks: int, rows: int, step_s: float) -> Array:
    """Of the parameters' logarithms, by the information of the spectrum."""
    step = OPTIONS.step_log
    slopes = []
    for turn in step * np.eye(len(log_parameters)):
        ahead, behind = (
            _spectrum(log_parameters + sign * turn, rows, step_s) for sign in (1.0, -1.0)
        )
        slopes.append(np.log(ahead / behind) / (2.0 * step))
    information = blocks * np.array(slopes) @ np.transpose(slopes)
    unit = np.sqrt(np.maximum(np.diag(information), 1e-12))
    inverse = np.linalg.pinv(information / np.outer(unit, unit), rcond=1e-12)
    return np.asarray(np.maximum(np.diag(inverse), 1.0) / unit**2)


def _spectrum(log_parameters: Array, rows: int, step_s: float) -> Array:
    """Expected power at the frequencies of so many rows, but for none and the highest.

    log_parameters: of the wander's variance, its half-life, the noise's variance.
    """
    variance_rad2, half_life_s, noise_rad2 = np.exp(log_parameters)
    late = np.arange(rows)
    covariance = variance_rad2 * 0.5 ** (late * step_s / half_life_s) * (1.0 - late / rows)
    covariance[0] += noise_rad2
    both = 2.0 * np.real(np.fft.rfft(covariance, 2 * rows))[2 : 2 * ((rows + 1) // 2) : 2]
    return np.asarray(both - covariance[0])
