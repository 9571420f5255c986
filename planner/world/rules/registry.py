"""The rules of each kind: what a request may ask of a platform, and where its motion may begin."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from planner.base.commands import CommandTable
from planner.world.attitude import Attitude
from planner.world.platforms import AnyPlatform, RollRule
from planner.world.resources import Resources
from planner.world.rules.body import BodyRules
from planner.world.rules.two_axis import TwoAxisRules
from planner.world.targets import Target

if TYPE_CHECKING:  # which asks them as it is made
    from planner.world.scenario import InitialState, Quaternion, Scenario, SlewOptions


class Rules(Protocol):
    """Of one platform.

    state_members: of an initial state: position, rate and acceleration.  scan_roll: rule by which
    it lies on the lines of an imaging mode, unless a session says otherwise.
    """

    state_members: ClassVar[tuple[str, str, str]]
    scan_roll: ClassVar[RollRule | None]

    def __init__(self, platform: AnyPlatform) -> None: ...

    def require(self, scenario: "Scenario") -> None:
        """Raises ValueError for what the platform can't be asked for, by field."""

    def require_roll(self, name: str, roll: RollRule | None, target: Target) -> None:
        """Raises ValueError, which names the field, for a roll that it can't lie by on a target."""

    def require_wheels(self, resources: Resources | None) -> None:
        """Raises ValueError for a momentum of wheels where none turn the platform."""

    def require_attitude(self, attitude: Attitude | None) -> None:
        """Raises ValueError for the attitude of a carrier that the platform doesn't stand on."""

    def require_rest(
        self,
        rest_deg: Mapping[str, float] | None,
        begin_q_xyzw: "Quaternion | None",
        attitude: Attitude | None,
        slew: "SlewOptions",
    ) -> None:
        """The same of a campaign, which begins and ends at rest."""

    def at_rest(self) -> Mapping[str, Any]:
        """Where it begins unless told; empty where it rests on a motion of its own."""

    def told(self, state: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
        """Where it begins, in words and as a request might say it."""

    def state_at_end(self, table: CommandTable) -> dict[str, Any]:
        """Position, rate and acceleration in the last row, by the members of an initial state."""

    def may_wait_after(self, ended: AnyPlatform, start: "InitialState") -> bool:
        """Whether it waits as a plan of `ended`, which is over, has left it, until `start`."""


RULES: dict[str, type[Rules]] = {"two_axis": TwoAxisRules, "body": BodyRules}
# Members of an initial state that say where a platform is, whatever its kind.
POSITIONS = tuple(rules.state_members[0] for rules in RULES.values())


def rules_of(platform: AnyPlatform) -> Rules:
    """Of a platform."""
    return RULES[platform.kind](platform)
