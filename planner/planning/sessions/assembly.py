"""Slews and tracks put together as one command table."""

from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from planner.base.commands import ROWS_PER_S, Channel, CommandTable
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
    session: int = 1_500  # for its budget, comparison and report


OPTIONS = AssemblyPrices()


def table_work(scenario: Scenario, rows: int) -> float:
    """What a table of so many rows takes when all is found."""
    masks = scenario.platform.masks
    corners = sum(len(mask.corners_platform) for mask in masks)
    a_row = OPTIONS.row + OPTIONS.cone_row * len(scenario.slew.keep_out)
    a_row += OPTIONS.mask_row * len(masks) + OPTIONS.corner_row * corners
    return a_row * rows + OPTIONS.session * len(scenario.sessions)


def assemble_table(
    epoch_utc: datetime, channels: tuple[Channel, ...], joins: list[Join]
) -> CommandTable:
    """Row by row: braked to rest, at rest until each slew begins, the slew, the track.

    A row shared by two of them is the later one's.  What a slew leaves as end error is
    flown as it dies away.
    """
    last = joins[-1].track.axis_states
    angle_rad, rate_rad_s = np.empty((2, joins[-1].stop_row + 1, last.shape[-1]))
    from_row = 0
    for join in joins:
        slew_t_s = np.arange(join.join_row - join.slew_row + 1) / ROWS_PER_S
        slew = slice(join.slew_row, join.join_row + 1)
        angle_rad[slew], rate_rad_s[slew], _, _ = join.slew.motion(slew_t_s)
        at_rest = slice(from_row + join.brake_rows, join.slew_row)
        angle_rad[at_rest], rate_rad_s[at_rest] = angle_rad[join.slew_row], 0.0
        if join.brake:
            brake = slice(from_row, from_row + join.brake_rows)
            brake_t_s = np.arange(join.brake_rows) / ROWS_PER_S
            angle_rad[brake], rate_rad_s[brake], _, _ = join.brake.motion(brake_t_s)
        track = slice(join.join_row, join.stop_row + 1)
        track_t_s = np.arange(join.join_row, join.stop_row + 1) / ROWS_PER_S
        angle_rad[track], rate_rad_s[track], _ = join.track.motion(track_t_s)
        if join.slew.settling_s:
            since_join_s = track_t_s[:, None] - track_t_s[0]
            left_rad = np.exp(-since_join_s / join.slew.settling_s) * join.slew.end_error_rad
            angle_rad[track] += left_rad
            rate_rad_s[track] -= left_rad / join.slew.settling_s
        from_row = join.stop_row
    return CommandTable(
        epoch_utc=epoch_utc,
        channels=channels,
        position=angle_rad,
        rate_rad_s=rate_rad_s,
    )


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
