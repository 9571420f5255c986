"""The flyer: everything that flights ask of how a platform flies a table, whatever its kind."""

from collections.abc import Mapping
from typing import ClassVar, Protocol

from planner.base.arrays import Array
from planner.base.commands import CommandTable
from planner.base.rotation import Rotation
from planner.world.attitude import AttitudeErrors
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates

# Causes of errors, as the pointing budget names them.
ORBIT, ATTITUDE, EARTH, CLOCK = "orbit", "attitude", "Earth orientation", "clock"


class FlownTable(Protocol):
    """A table as it was flown."""

    @property
    def saturated_s(self) -> Array:
        """For how long each degree of freedom is given all that moves it, (d,)."""
        ...

    def rate_errors_rad_s(self, t_s: Array) -> Array | None:
        """Of gyros' control at n instants, in body axes, (n, 3); None without gyros."""
        ...

    def steadiness(self, start_s: float, stop_s: float) -> Array:
        """While the camera images, (k,), as `worst_of` reads them; (0,) without gyros."""
        ...

    def at(self, t_s: Array) -> tuple[Array, Array]:
        """True position, (n, c), and how the camera has turned beside it, (n, 3).

        t_s: n instants on the table's clock.  The turn is a small rotation vector in the base's
        axes: directions fixed to the camera become d + turn x d.
        """
        ...


class Flyer(Protocol):
    """The flight of one scenario's platform.

    causes: of errors that differ from flight to flight.  flown_causes: those of them that lie in
    the flight itself; each is given a seed.  lead_s: flown before a session, for all that moves to
    be at work when it begins.
    """

    causes: ClassVar[tuple[str, ...]]
    flown_causes: ClassVar[tuple[str, ...]]

    @property
    def lead_s(self) -> float: ...

    def q_base_from_eci(
        self, instants: Instants, states: OrbitStates, turned_body_rad: Array | None = None
    ) -> Rotation:
        """What the platform moves against, (n,).

        turned_body_rad: rotation vectors, (n, 3), from the base's planned attitude to its true one.
        """
        ...

    def base_errors(self, instants: Instants) -> AttitudeErrors:
        """How well the base's attitude is known beforehand."""
        ...

    def fly(
        self, table: CommandTable, from_s: float, session: int, seeds: Mapping[str, int] | None
    ) -> FlownTable:
        """Fly a session's rows of a plan's table.

        from_s: of the first of them on the clock of the plan's table.  session: its number.
        seeds: by flown cause; None for a flight as planned.
        """
        ...
