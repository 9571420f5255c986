"""Errors of a carrier's predicted attitude."""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import Within, spec

# The vehicle's two attitude solutions in the telemetry of 2018-10-12 are 138 arcsec apart.
KNOWLEDGE_RAD = np.deg2rad(138.0 / 3600.0) / np.sqrt(6.0)
MEAN_SIGMA_DEG = 0.05
# What is left of the ISS's motion about body x, y, z beside mean and swing, and how long it stays
# `alike`: by how much telemetry differs from what it was an orbit, and some minutes, before
# (bench/attitude_figures.py of commit 54f03d3).
REST_RAD = np.deg2rad([0.0095, 0.0165, 0.0045])
REST_MEMORY_S = 500.0
_TurnDeg = Annotated[float, Within(0.0, 180.0)]


@spec
class AttitudeUncertainty:
    """Uncertainty of the carrier's attitude about its law, instead of slewtrack's own figures.

    The law's own figures where one is not given. Only the pointing budget of a plan rests on them.

    sigma_body_deg: 1-sigma of a turn about each body axis, constant over a session. E.g. `[0.1,
    0.1, 0.2]`.
    swing_rms_body_deg: rms about each body axis of a sinusoid at the orbital rate, its phase
    unknown. E.g. `[0.2, 0.0, 0.0]`.
    """

    sigma_body_deg: tuple[_TurnDeg, _TurnDeg, _TurnDeg] | None = None
    swing_rms_body_deg: tuple[_TurnDeg, _TurnDeg, _TurnDeg] | None = None


@dataclass(frozen=True, eq=False)
class AttitudeErrors:
    """Independent small turns about the body axes, 1-sigma each, the vehicle's knowledge included.

    sigma_body_rad: (n, 3) or (3,), of errors that are constant over a session.
    swing_rms_body_rad: (3,), of sinusoids at the orbital rate whose phases are unknown.
    modes_body_rad: (m, n, 3), instead of sigma_body_rad where there are any: independent errors,
    each a turn over the n instants.
    forgotten_body_rad: (n, 3) or (3,), what of sigma_body_rad doesn't last: it is `alike` within
    memory_s.  The rest of it stays for good.
    parts_body_rad: (k, n, 3), what sigma_body_rad is the root of the squares of, where that is
    known: each times a number of its own.
    basis: on what evidence.  better: a way to make them smaller.
    """

    sigma_body_rad: Array
    swing_rms_body_rad: Array
    basis: str
    better: str
    forgotten_body_rad: Array
    memory_s: float = REST_MEMORY_S
    modes_body_rad: Array = field(default_factory=lambda: np.zeros((0, 1, 3)))
    parts_body_rad: Array = field(default_factory=lambda: np.zeros((0, 1, 3)))

    def unless_stated(self, uncertainty: AttitudeUncertainty | None) -> "AttitudeErrors":
        """What the request states in their place, where it does."""
        request = uncertainty or AttitudeUncertainty()
        sigma_deg, swing_deg = request.sigma_body_deg, request.swing_rms_body_deg
        if sigma_deg is None and swing_deg is None:
            return self
        basis, better = "as attitude.uncertainty states", "an attitude known better than that"
        if sigma_deg is None or swing_deg is None:
            basis += f" of its {'swing' if sigma_deg is None else 'sigma'}; else {self.basis}"
            better = self.better
        return AttitudeErrors(
            self.sigma_body_rad if sigma_deg is None else np.deg2rad(sigma_deg),
            self.swing_rms_body_rad if swing_deg is None else np.deg2rad(swing_deg),
            basis,
            better,
            self.forgotten_body_rad if sigma_deg is None else soon_forgotten(np.deg2rad(sigma_deg)),
            self.memory_s if sigma_deg is None else REST_MEMORY_S,
            parts_body_rad=self.parts_body_rad if sigma_deg is None else np.zeros((0, 1, 3)),
        )


def known_errors(
    measured_body_rad: Array, basis: str, better: str, memory_s: float = REST_MEMORY_S
) -> AttitudeErrors:
    """Error of a law that follows the swing itself; the vehicle's knowledge, which lasts, added."""
    sigma_body_rad = np.hypot(KNOWLEDGE_RAD, measured_body_rad)
    return AttitudeErrors(sigma_body_rad, np.zeros(3), basis, better, measured_body_rad, memory_s)


def soon_forgotten(sigma_body_rad: Array) -> Array:
    """REST_RAD of an error, or most of it where it is less."""
    return np.asarray(REST_RAD * sigma_body_rad / np.hypot(sigma_body_rad, REST_RAD))


def alike(apart_s: Array, memory_s: float) -> Array:
    """Correlation of what is forgotten.

    Source: Rasmussen and Williams 2006, eq. 4.17, the Matern class with nu = 5/2.
    """
    x = np.sqrt(5.0) / memory_s * np.abs(apart_s)
    return np.asarray((1.0 + x + x**2 / 3.0) * np.exp(-x))
