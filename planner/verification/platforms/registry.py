"""The judge of each kind of platform."""

from collections.abc import Callable

from planner.base.commands import CommandTable
from planner.verification.platforms.body.judge import BodyJudge
from planner.verification.platforms.judge import Judge
from planner.verification.platforms.two_axis.judge import TwoAxisJudge
from planner.world.scenario import Scenario

JUDGES: dict[str, Callable[[CommandTable, Scenario], Judge]] = {
    "two_axis": TwoAxisJudge,
    "body": BodyJudge,
}


def judge_of(table: CommandTable, scenario: Scenario) -> Judge:
    """Of a table of the scenario's platform."""
    return JUDGES[scenario.platform.kind](table, scenario)
