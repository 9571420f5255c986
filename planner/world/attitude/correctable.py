"""The base of every attitude law: its uncertainty, and its correction by measurements."""

from abc import ABC, abstractmethod
from functools import cached_property
from typing import Annotated

import numpy as np

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.base.spec import Within, spec
from planner.world.attitude.corrections import Correction, Corrections
from planner.world.attitude.errors import AttitudeErrors, AttitudeUncertainty
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates

PERIOD_RANGE_S = (5000.0, 90000.0)  # from the lowest orbit to beyond the geostationary


@spec
class CorrectableAttitude(ABC):
    """A law that measured rotations correct.

    orbital_period_s: of the carrier's swing; the default is the ISS's.
    uncertainty: uncertainty of the carrier's attitude about the law.
    corrections: measured differences from the law, which condition that; one 5 sigma off is
    refused.
    """

    orbital_period_s: Annotated[float, Within(*PERIOD_RANGE_S)] = 5560.0
    uncertainty: AttitudeUncertainty | None = None
    corrections: Corrections = ()

    def q_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """Attitude at the n instants of `states`, as far as it is known."""
        law = self.q_law_body_from_eci(instants, states)
        return Rotation.from_rotvec(self.turn_rad(instants)) * law if self.corrections else law

    def turn_rad(self, instants: Instants) -> Array:
        """Rotation vectors by which corrections turn the body from its law's, (n, 3)."""
        if not self.corrections:
            return np.zeros((len(instants), 3))
        return self._correction.turn_rad(instants)

    def errors(self, instants: Instants) -> AttitudeErrors:
        """How far the carrier may be off that over a session, at a few of its instants."""
        return self._correction.errors(instants) if self.corrections else self._given(instants)

    def errors_each(self, instants: Instants) -> AttitudeErrors:
        """The errors at each instant by itself, however many there are."""
        return self._correction.errors_each(instants) if self.corrections else self._given(instants)

    def warnings_at(self, instants: Instants) -> tuple[str, ...]:
        """Warnings of the law, and by how much it is corrected."""
        warnings = self.law_warnings_at(instants)
        return (*warnings, self._correction.warning(instants)) if self.corrections else warnings

    @abstractmethod
    def q_law_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """Without corrections."""

    @abstractmethod
    def law_errors(self, instants: Instants) -> AttitudeErrors:
        """Without corrections, and whatever the request states."""

    @abstractmethod
    def law_warnings_at(self, instants: Instants) -> tuple[str, ...]:
        """What the user should know of the law then."""

    @cached_property
    def _correction(self) -> Correction:
        return Correction(self.corrections, self._given, self.orbital_period_s)

    def _given(self, instants: Instants) -> AttitudeErrors:
        return self.law_errors(instants).unless_stated(self.uncertainty)
