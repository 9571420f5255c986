"""Wander of an attitude about its plan, and the noise of its sensor from row to row."""

import math
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.inflight.telemetry.error_spectrum import fit_spectrum, mean_power
from planner.inflight.telemetry.estimates import Estimate
from planner.inflight.telemetry.following import Followed


@dataclass(frozen=True, kw_only=True)
class WanderOptions:
    """How much of an error is looked at, and when it is told to wander."""

    rows_min: int = 128  # of a stretch without a gap: a spectrum of fewer tells no shape
    half_lives_min: float = 8.0  # in a stretch: fewer and its size is a matter of chance
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
    step_s = float(np.median(np.diff(followed.t_s[runs[0]])))
    power_rad2, blocks, rows = mean_power([followed.left_rad[run] for run in runs])
    return _told(power_rad2, blocks, rows, step_s)


def _told(power_rad2: Array, blocks: int, rows: int, step_s: float) -> Wander | None:
    found = fit_spectrum(power_rad2, rows, step_s)
    if found is None:
        return None
    variance_log2 = found.variances_log2(blocks)
    wander_s, half_life, noise = (
        # The first and the last are of squares.
        Estimate(
            value=math.exp(log * share),
            sigma=OPTIONS.room * math.exp(log * share) * share * math.sqrt(variance),
        )
        for log, share, variance in zip(
            found.log_parameters.tolist(), (0.5, 1.0, 0.5), variance_log2.tolist(), strict=True
        )
    )
    if len(power_rad2) * blocks * found.likelier_margin < OPTIONS.likelier:
        white = math.sqrt(float(np.mean(power_rad2)))
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
