"""The work that a table takes, and the sessions that are left in it."""

from dataclasses import dataclass, replace

from planner.base.commands import ROWS_PER_S
from planner.planning.sessions.platforms.mover import Join
from planner.world.frames.time_scales import elapsed_s, shifted_utc, tai_us
from planner.world.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class AssemblyPrices:
    """Costs in `effort` of putting a table together and of reporting it."""

    row: float = 0.3  # to assemble, judge and write down a row
    cone_row: float = 0.13  # more, for each cone
    mask_row: float = 0.03  # for each mask
    corner_row: float = 0.012  # and for each of its corners
    exclusion_row: float = 0.8  # for each exclusion of a body that always counts
    session: int = 1_500  # for its budget, comparison and report


OPTIONS = AssemblyPrices()


def table_work(scenario: Scenario, rows: int) -> float:
    """What a table of so many rows takes when all is found."""
    masks = scenario.platform.masks
    corners = sum(len(mask.corners_platform) for mask in masks)
    a_row = OPTIONS.row + OPTIONS.cone_row * len(scenario.slew.keep_out)
    a_row += OPTIONS.mask_row * len(masks) + OPTIONS.corner_row * corners
    a_row += OPTIONS.exclusion_row * len(scenario.platform.always_excluded)
    return a_row * rows + OPTIONS.session * len(scenario.sessions)


def sessions_after_conflicts(scenario: Scenario, joins: list[Join]) -> tuple[Scenario, list[str]]:
    """The sessions as they are left after conflicts, and what each of them lost."""
    epoch_utc = scenario.initial_state.epoch
    sessions, losses = [], []
    for number, (session, join) in enumerate(zip(scenario.sessions, joins, strict=True)):
        settled_utc, left_utc = (
            shifted_utc(epoch_utc, row / ROWS_PER_S)
            for row in (join.join_row + join.settle_rows, join.stop_row)
        )
        start = max(session.start, settled_utc, key=tai_us)
        stop = min(session.stop, left_utc, key=tai_us)
        late_s, early_s = elapsed_s(start, session.start), elapsed_s(session.stop, stop)
        lost = [
            f"{ends} {by_s:.1f} s {how}"
            for ends, by_s, how in (("starts", late_s, "later"), ("stops", early_s, "earlier"))
            if by_s
        ]
        sessions.append(replace(session, start=start, stop=stop) if lost else session)
        if lost:
            losses.append(
                f"session {number + 1} {' and '.join(lost)} than asked, so that the slew between "
                f"sessions fits ({scenario.on_conflict})"
            )
    return replace(scenario, sessions=tuple(sessions)) if losses else scenario, losses
