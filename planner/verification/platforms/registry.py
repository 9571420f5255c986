"""The judge of each kind of platform."""

from planner.base.commands import CommandTable
from planner.verification.platforms.body.judge import BodyJudge
from planner.verification.platforms.judge import Judge
from planner.verification.platforms.two_axis.judge import TwoAxisJudge
from planner.world.platforms.body import BodyPlatform
from planner.world.scenario import Scenario


def judge_of(table: CommandTable, scenario: Scenario) -> Judge:
    """Of a table of the scenario's platform."""
    if isinstance(scenario.platform, BodyPlatform):
        return BodyJudge(table, scenario.platform, scenario)
    return TwoAxisJudge(table, scenario)
