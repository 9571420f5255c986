"""A table put together: the work that it takes, and the sessions and segments that are left."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from planner.base.commands import ROWS_PER_S
from planner.planning.sessions.platforms.mover import Join, Mover
from planner.world.frames.time_scales import elapsed_s, shifted_utc, tai_us
from planner.world.plan import FlightPlan, Segment, SegmentKind
from planner.world.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class AssemblyPrices:
    """Costs in `effort` of putting a table together and of reporting it."""

    row: float = 0.3  # to assemble, judge and write down a row
    cone_row: float = 0.13  # more, for each cone
    mask_row: float = 0.03  # for each mask
    corner_row: float = 0.012  # and for each of its corners
    exclusion_row: float = 0.2  # for each exclusion of a body that always counts
    resource_row: float = 0.25  # where resources are planned and judged
    wheels_row: float = 0.2  # more, with a momentum of wheels
    session: int = 1_500  # for its budget, comparison and report


OPTIONS = AssemblyPrices()


def table_work(scenario: Scenario, rows: int) -> float:
    """What a table of so many rows takes when all is found."""
    masks = scenario.platform.masks
    corners = sum(len(mask.corners_platform) for mask in masks)
    a_row = OPTIONS.row + OPTIONS.cone_row * len(scenario.slew.keep_out)
    a_row += OPTIONS.mask_row * len(masks) + OPTIONS.corner_row * corners
    a_row += OPTIONS.exclusion_row * len(scenario.platform.always_excluded)
    if (resources := scenario.resources) is not None:
        a_row += OPTIONS.resource_row + OPTIONS.wheels_row * (resources.momentum is not None)
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


def assemble(scenario: Scenario, mover: Mover, joins: list[Join]) -> tuple[FlightPlan, list[str]]:
    """The table, with the sessions as they are left in it, and what each of them lost."""
    final, losses = sessions_after_conflicts(scenario, joins[: len(scenario.sessions)])
    table = mover.table(scenario.initial_state.epoch, joins)
    return FlightPlan(scenario=final, segments=segments_of(scenario, joins), table=table), losses


def pair_joins(scenario: Scenario, joins: list[Join]) -> Iterator[tuple[int | None, Join]]:
    """Each with the session whose track it leads to; None for the final state's."""
    count = len(scenario.sessions)
    return ((number if number < count else None, join) for number, join in enumerate(joins))


def segments_of(scenario: Scenario, joins: list[Join]) -> tuple[Segment, ...]:
    """What the table does from row to row, in order of time."""
    epoch_utc = scenario.initial_state.epoch
    segments = []
    from_row = 0
    for number, join in pair_joins(scenario, joins):
        held: SegmentKind = "wait" if number is None else "track"  # it idles after the last slew
        kinds: tuple[SegmentKind, ...] = ("brake", "wait", "slew", held)
        ends = [
            shifted_utc(epoch_utc, row / ROWS_PER_S)
            for row in (
                from_row,
                from_row + join.brake_rows,
                join.slew_row,
                join.join_row,
                join.stop_row,
            )
        ]
        segments += [
            Segment(kind=kind, session=number, start_utc=start_utc, stop_utc=stop_utc)
            for kind, start_utc, stop_utc in zip(kinds, ends, ends[1:], strict=False)
            if elapsed_s(stop_utc, start_utc) > 0.0
        ]
        from_row = join.stop_row
    return tuple(segments)
