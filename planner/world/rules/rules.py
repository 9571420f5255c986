"""The rules of a kind: what a request may ask of a platform, and where its motion may begin."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

from planner.world.attitude import Attitude
from planner.world.platforms import AnyPlatform

if TYPE_CHECKING:  # which asks them as it is made
    from planner.world.scenario import Scenario, SlewOptions

State = Mapping[str, Any]  # members of an initial state, by name


class Travel(NamedTuple):
    """The way of one degree of freedom, and its limits on it."""

    angle_rad: float
    rate_max_rad_s: float
    acceleration_max_rad_s2: float
    jerk_max_rad_s3: float


class Rules(Protocol):
    """Of one platform.

    state_members: of an initial state: position, rate and acceleration.
    """

    state_members: ClassVar[tuple[str, str, str]]

    def __init__(self, platform: AnyPlatform) -> None: ...

    def require(self, scenario: "Scenario") -> None:
        """Raises ValueError for what the platform can't be asked for, by field."""
        ...

    def require_rest(
        self,
        rest_angles_deg: Mapping[str, float] | None,
        attitude: Attitude | None,
        slew: "SlewOptions",
    ) -> None:
        """The same of a campaign, which begins and ends at rest."""
        ...

    def at_rest(self) -> State:
        """Where it begins unless told; empty where it rests on a motion of its own."""
        ...

    def told(self, state: State) -> tuple[str, dict[str, Any]]:
        """Where it begins, in words and as a request might say it."""
        ...

    def farthest(self, state: State) -> list[Travel]:
        """Of each degree of freedom as far as it goes from there."""
        ...
