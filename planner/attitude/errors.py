"""How far a carrier may be off its predicted attitude."""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from planner.arrays import Array
from planner.spec import Within, spec

# The vehicle's two attitude solutions in the telemetry of 2018-10-12 are 138 arcsec apart.
KNOWLEDGE_RAD = np.deg2rad(138.0 / 3600.0) / np.sqrt(6.0)
MEAN_SIGMA_DEG = 0.05
# What is left of the ISS's motion about body x, y, z beside mean and swing, as REST_MEMORY_S of
# corrections.py has it.
REST_RAD = np.deg2rad([0.0095, 0.017, 0.007])
_TurnDeg = Annotated[float, Within(0.0, 180.0)]


@spec
class AttitudeUncertainty:
    """How far the carrier may be off the attitude of its law, instead of slewtrack's own figures.

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
    parts_body_rad: (k, n, 3), what sigma_body_rad is the root of the squares of, where that is
    known: each times a number of its own that stays the same for good.
    basis: on what evidence.  better: what would make them smaller.
    """

    sigma_body_rad: Array
    swing_rms_body_rad: Array
    basis: str
    better: str
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
            parts_body_rad=self.parts_body_rad if sigma_deg is None else np.zeros((0, 1, 3)),
        )


def known_errors(sigma_body_rad: Array, basis: str, better: str) -> AttitudeErrors:
    """Of a law that follows the swing itself; the vehicle's knowledge added."""
    return AttitudeErrors(np.hypot(KNOWLEDGE_RAD, sigma_body_rad), np.zeros(3), basis, better)
