"""How does a scenario become a verified plan?  The whole story on one screen."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from planner.assembly import Piece, assembled
from planner.commands import ROWS_PER_S
from planner.errors import (
    InfeasibleSlew,
    InvalidInput,
    NotVisible,
    TrackBreaksLimit,
    Unreachable,
    VerificationFailed,
)
from planner.frames.earth_orientation import earth_orientation_warning
from planner.frames.time_scales import Instants, shifted_utc
from planner.joining import Join, covering, joined, session_rows
from planner.nearest_start import refused_with_nearest_start
from planner.orbits import Ephemeris
from planner.plan import Plan, Segment, SegmentKind, SlewRun
from planner.scenario import Scenario
from planner.slew import BACKENDS, AxisState, compared, track_states
from planner.verification import VerificationReport, verify


def make_plan(scenario: Scenario) -> Plan:
    """Plan every session in order of time and have the table judged.

    Raises a `Refusal` when a session can't be flown; it says which limit, when, and, where
    there is one, the earliest session start that can.
    """
    if scenario.slew.method not in BACKENDS:
        raise InvalidInput(
            f"slew.method {scenario.slew.method!r} is not known; choose {' or '.join(BACKENDS)}",
            field="slew.method",
        )
    clock = _StageClock()
    epoch_utc = scenario.initial_state.epoch
    rows = [session_rows(session, epoch_utc) for session in scenario.sessions]
    with clock.stage("orbit"):
        ephemeris = covering(scenario, rows)

    pieces: list[Piece] = []
    segments: list[Segment] = []
    runs: list[SlewRun] = []
    row, state = 0, initial_state(scenario)
    for number, session in enumerate(scenario.sessions):
        try:
            with clock.stage("slew and track"):
                join = joined(scenario, ephemeris, number, session, row, state)
        except (NotVisible, Unreachable, TrackBreaksLimit, InfeasibleSlew) as refusal:
            raise refused_with_nearest_start(scenario, number, row, state, refusal) from None
        with clock.stage("comparison"):
            runs.append(_slew_run(scenario, number, join))
        pieces += _pieces(join, row)
        segments += _segments(scenario, number, join, row)
        row, state = join.stop_row, track_states(join.track, join.stop_row / ROWS_PER_S)

    table = assembled(epoch_utc, scenario.platform.axis_names, pieces)
    with clock.stage("verification"):
        report = verify(table, scenario)
    if not report.passed and BACKENDS[scenario.slew.method].keeps_limits:
        raise _rejected(report)
    return Plan(
        scenario=scenario,
        segments=tuple(segments),
        table=table,
        verification=report,
        slews=tuple(runs),
        warnings=_warnings(ephemeris, Instants(epoch_utc, table.t_s), report),
        stage_wall_s=clock.wall_s,
    )


def initial_state(scenario: Scenario) -> tuple[AxisState, ...]:
    """The platform at row 0, axis by axis."""
    motions = (scenario.initial_motion(axis) for axis in scenario.platform.axis_names)
    return tuple(
        AxisState(angle_rad=float(q), rate_rad_s=float(v), acceleration_rad_s2=float(a))
        for q, v, a in motions
    )


def _pieces(join: Join, from_row: int) -> list[Piece]:
    """The wait if there is one, the slew, the track; a shared row is the later piece's."""
    slew_row = join.slew_row
    waited = np.zeros((slew_row - from_row, len(join.slew.profiles)))
    slew_t_s = np.arange(join.join_row - slew_row + 1) / ROWS_PER_S
    slew_angle_rad, slew_rate_rad_s, _, _ = join.slew.motion(slew_t_s)
    track_t_s = np.arange(join.join_row, join.stop_row + 1) / ROWS_PER_S
    track_angle_rad, track_rate_rad_s, _ = join.track.motion(track_t_s)
    return [
        Piece(first_row=from_row, angle_rad=waited + slew_angle_rad[0], rate_rad_s=waited),
        Piece(first_row=slew_row, angle_rad=slew_angle_rad, rate_rad_s=slew_rate_rad_s),
        Piece(first_row=join.join_row, angle_rad=track_angle_rad, rate_rad_s=track_rate_rad_s),
    ]


def _segments(scenario: Scenario, number: int, join: Join, from_row: int) -> list[Segment]:
    epoch_utc = scenario.initial_state.epoch
    ends_utc = [
        shifted_utc(epoch_utc, row / ROWS_PER_S)
        for row in (from_row, join.slew_row, join.join_row, join.stop_row)
    ]
    kinds: tuple[SegmentKind, ...] = ("wait", "slew", "track")
    return [
        Segment(kind=kind, session=number, start_utc=start_utc, stop_utc=stop_utc)
        for kind, start_utc, stop_utc in zip(kinds, ends_utc, ends_utc[1:], strict=False)
        if stop_utc > start_utc
    ]


def _slew_run(scenario: Scenario, number: int, join: Join) -> SlewRun:
    compare = BACKENDS[scenario.slew.method].keeps_limits
    return SlewRun(
        session=number,
        solution=join.slew,
        comparison=compared(join.slew, scenario.slew) if compare else None,
    )


def _warnings(
    ephemeris: Ephemeris, instants: Instants, report: VerificationReport
) -> tuple[str, ...]:
    earth = earth_orientation_warning(instants)
    return (
        *ephemeris.warnings,
        *([earth] if earth else []),
        *(finding.detail for finding in report.findings),
    )


def _rejected(report: VerificationReport) -> VerificationFailed:
    worst = next(finding for finding in report.findings if finding.severity == "error")
    return VerificationFailed(
        f"the independent judge rejects the table: {worst.detail}",
        axis=worst.axis,
        limit=worst.limit,
        at_utc=worst.at_utc,
    )


class _StageClock:
    """Wall time per stage of the pipeline, summed over the sessions."""

    def __init__(self) -> None:
        self.wall_s: dict[str, float] = {}

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        began_s = time.perf_counter()
        yield
        self.wall_s[name] = self.wall_s.get(name, 0.0) + time.perf_counter() - began_s
