"""The attitude laws."""

from typing import Annotated, Protocol, get_args

from pydantic import Field

from planner.base.rotation import Rotation
from planner.base.spec import About
from planner.world.attitude.aem import AemAttitude
from planner.world.attitude.corrections import AttitudeCorrection
from planner.world.attitude.errors import AttitudeErrors, AttitudeUncertainty
from planner.world.attitude.harmonic import HarmonicAttitude
from planner.world.attitude.inertial import InertialAttitude
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates


class AttitudeLaw(Protocol):
    """What every law answers."""

    def warnings_at(self, instants: Instants) -> tuple[str, ...]:
        """What the user should know about the attitude's quality then, and what was chosen."""
        ...

    def errors(self, instants: Instants) -> AttitudeErrors:
        """How far the carrier may be off it over a session, at n of its instants."""
        ...

    def errors_each(self, instants: Instants) -> AttitudeErrors:
        """The errors at each of n instants by itself, however many there are."""
        ...

    def q_body_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """n rotations, `states` being the orbit at the same n instants."""
        ...


Attitude = Annotated[
    LvlhAttitude | InertialAttitude | AemAttitude | HarmonicAttitude,
    Field(discriminator="law"),
    About("Attitude of the carrier's body, by one of these laws."),
]
ATTITUDES: dict[str, type[AttitudeLaw]] = {law.law: law for law in get_args(get_args(Attitude)[0])}

__all__ = [
    "ATTITUDES",
    "AemAttitude",
    "Attitude",
    "AttitudeCorrection",
    "AttitudeErrors",
    "AttitudeLaw",
    "AttitudeUncertainty",
    "HarmonicAttitude",
    "InertialAttitude",
    "LvlhAttitude",
]
