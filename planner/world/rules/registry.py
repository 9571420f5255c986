"""The rules of each kind of platform, by name of the kind."""

from planner.world.platforms import AnyPlatform
from planner.world.rules.body import BodyRules
from planner.world.rules.rules import Rules
from planner.world.rules.two_axis import TwoAxisRules

RULES: dict[str, type[Rules]] = {"two_axis": TwoAxisRules, "body": BodyRules}
# Members of an initial state that say where a platform is, whatever its kind.
POSITIONS = tuple(rules.state_members[0] for rules in RULES.values())


def rules_of(platform: AnyPlatform) -> Rules:
    """Of a platform."""
    return RULES[platform.kind](platform)
