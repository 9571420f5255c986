"""Plans that take more than there is: which resource, when, and the nearest plan that works."""

import math
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from typing import NamedTuple

import numpy as np

from planner.base import effort
from planner.base.arrays import Array
from planner.base.commands import ROWS_PER_S
from planner.base.effort import at_most
from planner.base.errors import Refusal, ResourceRunsOut, figures
from planner.planning.resources import (
    Along,
    LightAndContacts,
    ResourceCurve,
    Span,
    Uses,
    attitude_along,
    resource_curves,
    uses_of,
)
from planner.planning.sessions.assembly import assemble, table_work
from planner.planning.sessions.platforms.mover import Mover
from planner.planning.sessions.platforms.registry import mover_of
from planner.planning.sessions.sequence import SessionRefused, sequence_whole
from planner.planning.sessions.track_branches import may_look, session_rows
from planner.verification import verify
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.world.plan import FlightPlan
from planner.world.resources import Memory, Resources, eased, started
from planner.world.scenario import BoundedLead, Lead, Scenario, Session
from planner.world.targets import BenchMotionTarget, StationTarget


@dataclass(frozen=True, kw_only=True)
class RunningOutOptions:
    """How hard a plan that works is sought."""

    step_s: float = 10.0  # between starts tried, and between instants of the level foretold
    tries: int = 5  # plans of each way out: what is foretold errs by the attitude on slews
    share: float = 0.8  # of the work that is left; at most what a plan may take
    shorter_share: float = 0.5  # of that to the shorter session, which is foretold more nearly
    spare: float = 1e-3  # of the capacity, beyond what the last try lacked
    gentler_share: float = 0.6  # of it to gentler slews, first of all where momentum runs out
    gentler: float = 2.0  # times the longest slew allowed
    apart_s: float = 40.0  # of starts tried then: slews to nearer ones take as much
    growth: float = 4.0  # of that from try to try
    foretold_row: float = 0.008  # of `effort`: to foretell all levels at one instant
    begin_share: float = 1e-4  # of the way to a full battery or an empty memory, to be told
    decimals: int = 6  # of what resources would have to begin with: Wh, Gbit, N m s
    downlink_share: float = 0.4  # of it to a downlink before, where memory is full
    gaps_s: tuple[float, ...] = (60.0, 300.0)  # beside a downlink, for the slews to it and from it
    downlink_least_s: float = 10.0  # shorter ones are hardly worth a slew
    table_share: float = 0.25  # of a table's work: waits are known
    judged_share: float = 0.45  # of it, where it keeps all limits
    stride: int = 5  # rows between looks at the level of a shorter session: a second
    farthest_s: float = 21_600.0  # a battery is full after an orbit, a station passed in some


OPTIONS = RunningOutOptions()


def require_resources(plan: FlightPlan, mover: Mover) -> None:
    """Raises ResourceRunsOut, with the nearest plan that works, where a limit is passed.

    mover: of the plan's scenario; what is tried shares the slews that it learns of.
    """
    if plan.scenario.resources is None:
        return
    levels = _levels_of(plan)
    beyond = [curve for curve in levels.curves if curve.first_beyond_s is not None]
    if not beyond:
        return
    curve = min(beyond, key=lambda one: one.first_beyond_s or 0.0)
    at_utc = shifted_utc(plan.table.epoch_utc, curve.first_beyond_s or 0.0)
    short = figures(-float(curve.room.min()))
    detail = (
        f"the {curve.told} passes its limit of {curve.limit:g} {curve.unit} at "
        f"{utc_text(at_utc, 1)}, in the end by {short} {curve.unit}"
    )
    if _runs_out_idle(levels, curve):
        raise ResourceRunsOut(
            f"{detail}, and would without any session; {_begin_with(levels, curve)}, or "
            f"{_IDLE_WAYS[curve.resource]}",
            field=f"resources.{curve.resource}",
            limit=curve.resource,
            at_utc=at_utc,
        )
    sessions = plan.scenario.sessions
    number = max(n for n, one in enumerate(sessions) if n == 0 or one.start <= at_utc)
    if curve.resource == "momentum" and sessions[number].stop < at_utc:  # on the slew to the next
        number = min(number + 1, len(sessions) - 1)
    advice = _Advice("", None, ())
    with at_most(min(OPTIONS.share * effort.remaining(), effort.PLAN)):
        advice = _advice(levels, mover, number, curve, at_utc)
    raise ResourceRunsOut(
        f"session {number + 1}: {detail}; {advice.words or _no_way(levels, mover, number, curve)}",
        field=f"sessions.{number}.start",
        limit=curve.resource,
        at_utc=at_utc,
        earliest_feasible_start_utc=advice.session.start if advice.session else None,
        feasible_stop_utc=advice.session.stop if advice.session else None,
        costs_sessions=advice.costs,
    )


class _PlanLevels(NamedTuple):
    """A plan that has resources: light and contacts, what its attitude gives, and its levels."""

    plan: FlightPlan
    around: LightAndContacts
    along: Along
    uses: Uses
    curves: tuple[ResourceCurve, ...]


def _levels_of(plan: FlightPlan) -> _PlanLevels:
    (around, along), uses = attitude_along(plan), uses_of(plan)
    return _PlanLevels(plan, around, along, uses, around.curves(plan.table.t_s, along, uses))


class _Advice(NamedTuple):
    """words: the ways out.  session: the nearer of them.  costs: sessions to leave out for it."""

    words: str
    session: Session | None
    costs: tuple[int, ...]


_IDLE_WAYS = {
    "battery": "take less while idle",
    "memory": "leave more time to send it",
    "momentum": "unload more, or choose another idle attitude",
}


def _no_way(levels: _PlanLevels, mover: Mover, number: int, curve: ResourceCurve) -> str:
    """In words, that none was found, since when there is none, and what else would do."""
    search = _Search(levels, mover, number, ())
    passed_s, around = search.passes_without_s(curve), search.farther
    epoch_utc = levels.plan.table.epoch_utc
    until = "" if around is None else f" by {utc_text(shifted_utc(epoch_utc, around.last_s), 0)}"
    because = leave_out = ""
    if passed_s is not None:
        at = utc_text(shifted_utc(epoch_utc, passed_s), 1)
        because = f" (without it and those after it the limit is passed at {at})"
    with at_most(effort.remaining()):
        leave_out = ", or leave this session out" if search.works_without() else ""
    return (
        f"neither a later start{until} nor a shorter session was found with which the limit is "
        f"kept{because}; {_begin_with(levels, curve)}{leave_out}"
    )


def _begin_with(levels: _PlanLevels, curve: ResourceCurve) -> str:
    """In words, the nearest level at row 0 with which the plan can be flown as it is, or that there
    is none."""
    resources, name = levels.around.resources, curve.resource
    best = eased(resources, name, 1.0, OPTIONS.decimals)

    def keeps(instead: Resources) -> bool:
        around = copy(levels.around)
        around.resources = instead
        along, t_s = levels.along, levels.plan.table.t_s
        curves = around.curves(t_s, along, levels.uses, with_wheels=name == "momentum")
        kept = [one for one in curves if one.resource == name]
        return all(one.first_beyond_s is None for one in kept)

    if not keeps(best):
        return f"it is passed with resources.{started(best, name)}, too: take less of it"
    low, high = 0.0, 1.0
    while high - low > OPTIONS.begin_share:
        middle = 0.5 * (low + high)
        if keeps(eased(resources, name, middle, OPTIONS.decimals)):
            high = middle
        else:
            low = middle
    nearest = started(eased(resources, name, high, OPTIONS.decimals), name)
    return f"begin with resources.{nearest}"


def _runs_out_idle(levels: _PlanLevels, curve: ResourceCurve) -> bool:
    """Whether it would with nothing of the plan: but for momentum, not without its attitude."""
    t_s, around, along = levels.plan.table.t_s, levels.around, levels.along
    if curve.resource == "momentum":
        along = _idle_along(around, t_s)
    nothing = Uses(sessions=(), targets=(), idle=((0.0, float(t_s[-1])),))
    return any(
        one.first_beyond_s is not None
        for one in around.curves(t_s, along, nothing)
        if one.name == curve.name
    )


def _idle_along(around: LightAndContacts, t_s: Array) -> Along:
    """What the idle attitude gives, at 7 or more even instants."""
    return around.along(t_s, mover_of(around.scenario).idle_motion(*around.at(t_s)))


def _advice(
    levels: _PlanLevels, mover: Mover, number: int, curve: ResourceCurve, at_utc: datetime
) -> _Advice:
    """With all other sessions, else with those before only."""
    sessions = levels.plan.scenario.sessions
    asked, after = sessions[number], tuple(range(number + 1, len(sessions)))
    for costs in dict.fromkeys(((), after)):
        search = _Search(levels, mover, number, costs)
        ways, shorter, later, gentler, downlink = [], None, None, "", ""
        if curve.resource == "momentum":
            with at_most(OPTIONS.gentler_share * effort.remaining()):
                gentler = search.gentler()
        if curve.resource == "memory":
            with at_most(OPTIONS.downlink_share * effort.remaining()):
                downlink = search.downlink_before()
        with at_most(OPTIONS.shorter_share * effort.remaining()):
            shorter = search.shorter()
        with at_most(effort.remaining()):
            later = search.later(curve.resource)
        if later is not None:
            start, stop = utc_text(later.start, 1), utc_text(later.stop, 1)
            before = search.relief_before(curve.resource, later, at_utc)
            ways.append(f"earliest feasible start {start}{before}, with the stop moved to {stop}")
        if shorter is not None:
            stop = utc_text(shorter.stop, 1)
            ways.append(f"from the start asked for it can be flown until {stop}")
        if gentler:
            ways.append(f"with {gentler}, which turns more slowly, it can be flown as asked")
        if downlink:
            ways.append(f"with {downlink} it can be flown as asked")
        if not ways:
            continue
        left_out = f", with session {number + 2} and any after it left out" if costs else ""
        half_s = 0.5 * elapsed_s(asked.stop, asked.start)
        keeps_half = shorter is not None and elapsed_s(shorter.stop, asked.start) >= half_s
        nearer = shorter if keeps_half or later is None else later
        return _Advice(", or ".join(ways) + left_out, nearer, costs)
    return _Advice("", None, ())


class _Search:
    """For another start or stop of one session, each tried by planning all sessions with it."""

    def __init__(
        self, levels: _PlanLevels, mover: Mover, number: int, without: tuple[int, ...]
    ) -> None:
        """without: sessions that are left out, the last ones."""
        plan, uses = levels.plan, levels.uses
        sessions = plan.scenario.sessions[: len(plan.scenario.sessions) - len(without)]
        self.levels, self.mover, self.number = levels, mover, number
        self.scenario = replace(plan.scenario, sessions=sessions)
        self.session = sessions[number]
        self.uses = replace(
            uses,
            sessions=uses.sessions[: len(sessions)],
            targets=uses.targets[: len(sessions)],
        )
        self.curves = levels.curves
        self.epoch_utc, self.leaves_out = plan.table.epoch_utc, bool(without)

    def shorter(self) -> Session | None:
        """With the same start and the latest stop that was found."""
        start_s, stop_s = self.uses.sessions[self.number]
        around, along, table = self.levels.around, self.levels.along, self.levels.plan.table
        rows = np.append(np.arange(0, len(table.t_s) - 1, OPTIONS.stride), len(table.t_s) - 1)
        charge = along._replace(charge_w=along.charge_w[rows])
        wheels = tuple(one for one in self.curves if one.resource == "momentum")
        is_last = self.number + 1 == len(self.scenario.sessions)
        final = self.scenario.final_state is not None and not self.leaves_out
        waits = not is_last and self.scenario.slew.lead != "all"

        def lacks(until_s: float) -> Array:
            """Of each capacity, by the plan's own attitude: it waits for the next session's slew,
            or moves on at once to the final state."""
            spans = list(self.uses.sessions)
            spans[self.number] = start_s, until_s
            idle = (*self.uses.idle, (until_s, stop_s)) if waits else self.uses.idle
            uses = replace(self.uses, sessions=tuple(spans), idle=idle)
            curves = around.curves(table.t_s[rows], charge, uses, with_wheels=False)
            ends_s = float(table.t_s[-1]) - (stop_s - until_s) if final else until_s
            return _lacks(curves + wheels, ends_s if is_last else math.inf)

        spare: Array | float = 0.0
        for _ in range(OPTIONS.tries):
            low_row, high_row = math.ceil(start_s * ROWS_PER_S), math.floor(stop_s * ROWS_PER_S)
            if np.any(lacks(low_row / ROWS_PER_S) > -spare):
                return None
            while high_row - low_row > 1:
                middle = (low_row + high_row) // 2
                if np.any(lacks(middle / ROWS_PER_S) > -spare):
                    high_row = middle
                else:
                    low_row = middle
            found, lacked = self._try(start_s, low_row / ROWS_PER_S)
            if found is not None:
                return found
            spare = spare + np.maximum(lacked, 0.0) + OPTIONS.spare
        return None

    def gentler(self) -> str:
        """In words, longer slews with which all can be flown; empty: they weren't found."""
        slew = self.scenario.slew
        for lead in self._gentler_leads():
            instead = replace(slew, lead=lead, objective="smooth")
            scenario = replace(self.scenario, slew=instead)
            try:
                if not self._works(_flown(scenario, mover_of(scenario)))[0]:
                    continue
            except (SessionRefused, Refusal):
                continue
            how = "" if slew.objective == "smooth" else 'slew.objective "smooth" and '
            if isinstance(lead, BoundedLead):
                return f"{how}slew.lead.max_duration_s {lead.max_duration_s:g}"
            return f'{how}slew.lead "all"'
        return ""

    def _gentler_leads(self) -> Iterator[Lead]:
        """Twice as long as slews may last now, or do; and as long as there is time."""
        lead = self.scenario.slew.lead
        if not isinstance(lead, BoundedLead):
            return
        slews = [one for one in self.levels.plan.segments if one.kind == "slew"]
        longest_s = max((elapsed_s(one.stop_utc, one.start_utc) for one in slews), default=0.0)
        most_s = math.ceil(OPTIONS.gentler * (lead.max_duration_s or longest_s))
        yield BoundedLead(max_duration_s=min(max(most_s, 2.0), 86_400.0))
        yield "all"

    def downlink_before(self) -> str:
        """In words, a session at a station before this one, with which all can be flown; empty:
        none was found."""
        memory = self.scenario.resources.memory if self.scenario.resources else None
        if memory is None or not memory.pointed_gbit_s:
            return ""
        tries = 0
        for gap_s in OPTIONS.gaps_s:
            for place, name, target, span in self._downlinks(memory, gap_s):
                if np.any(self._lacks_with(place, target, span) > 0.0):
                    continue
                start, stop = map(self._utc, span)
                sessions = list(self.scenario.sessions)
                sessions.insert(place, Session(target=target, start=start, stop=stop))
                try:
                    plan = _flown(replace(self.scenario, sessions=tuple(sessions)), self.mover)
                    if self._works(plan)[0]:
                        return (
                            f"a downlink before, a session at {name} (latitude_deg "
                            f"{target.latitude_deg:.10g}, longitude_deg "
                            f"{target.longitude_deg:.10g}, height_m {target.height_m:g}, "
                            f"min_elevation_deg {target.min_elevation_deg:g}) from "
                            f"{utc_text(start, 1)} to {utc_text(stop, 1)},"
                        )
                except (SessionRefused, Refusal):
                    pass  # another contact, or more time beside it
                tries += 1
                if tries >= OPTIONS.tries:
                    return ""
        return ""

    def _downlinks(
        self, memory: Memory, gap_s: float
    ) -> Iterator[tuple[int, str, StationTarget, Span]]:
        """Contacts with the request's stations between sessions, the last ones first: before which
        session, the station's name, its target, and when on rows."""
        named = {
            (one.latitude_deg, one.longitude_deg): (one.label, one)
            for one in self.uses.targets
            if isinstance(one, StationTarget)
        }
        for one in memory.stations:
            target = StationTarget(
                latitude_deg=one.latitude_deg,
                longitude_deg=one.longitude_deg,
                height_m=one.height_m,
                min_elevation_deg=one.min_elevation_deg,
            )
            named[one.latitude_deg, one.longitude_deg] = f"station {one.id}", target
        found = []
        for name, target in named.values():
            for rise_s, set_s in self.levels.around.contacts_with(target):
                for place in range(self.number + 1):
                    before_s = self.uses.sessions[place - 1][1] if place else 0.0
                    start_s = max(rise_s, before_s + gap_s)
                    stop_s = min(set_s, self.uses.sessions[place][0] - gap_s)
                    span = (
                        math.ceil(start_s * ROWS_PER_S) / ROWS_PER_S,
                        math.floor(stop_s * ROWS_PER_S) / ROWS_PER_S,
                    )
                    if span[1] - span[0] >= OPTIONS.downlink_least_s:
                        found.append((span, place, name, target))
        for span, place, name, target in sorted(found, key=lambda one: one[0], reverse=True):
            yield place, name, target, span

    def _lacks_with(self, place: int, target: StationTarget, span: Span) -> Array:
        """Of battery and memory, with a session so inserted, by the plan's own attitude."""
        spans, targets = list(self.uses.sessions), list(self.uses.targets)
        spans.insert(place, span)
        targets.insert(place, target)
        uses = replace(self.uses, sessions=tuple(spans), targets=tuple(targets))
        table, around, along = self.levels.plan.table, self.levels.around, self.levels.along
        last_s = spans[-1][1] if self.leaves_out else math.inf
        return _lacks(around.curves(table.t_s, along, uses, with_wheels=False), last_s)

    def later(self, resource: str) -> Session | None:
        """As long as asked, with the earliest later start that was found."""
        start_s, stop_s = self.uses.sessions[self.number]
        long_s = stop_s - start_s
        around = self.farther
        if around is None:
            return None
        next_s = [one[0] for one in self.uses.sessions[self.number + 1 :]]
        until_s = next_s[0] if next_s else around.last_s
        starts = self._starts(around, long_s, until_s)
        if resource == "momentum":
            return self._emptier(around, starts, long_s)
        t_s = np.linspace(0.0, around.last_s, math.ceil(around.last_s / OPTIONS.step_s) + 1)
        along = _idle_along(around, t_s)
        lacked_now = _lacks(self.curves, stop_s)
        spare = lacked_now - self._foretold(around, t_s, along, start_s, long_s)
        tries = 0
        for moved_s in starts:
            if np.any(self._foretold(around, t_s, along, moved_s, long_s) > -spare):
                continue
            found, lacked = self._try(moved_s, moved_s + long_s)
            if found is not None:
                return found
            tries += 1
            if tries >= OPTIONS.tries:
                return None
            spare += np.maximum(lacked, 0.0) + OPTIONS.spare
        return None

    def _emptier(
        self, around: LightAndContacts, starts_s: list[float], long_s: float
    ) -> Session | None:
        """By what wheels hold at each start in the idle attitude, and what slews took beyond that
        in the last try: the soonest with which nothing lacks, or else that with which least does.
        """
        wheels = [one for one in self._idle_curves(around) if one.resource == "momentum"]
        idle = np.stack(
            [-np.interp(starts_s, one.t_s, one.room) / one.capacity for one in wheels], axis=1
        )
        more = np.zeros(len(wheels))
        left = np.ones(len(starts_s), dtype=bool)
        for number in range(OPTIONS.tries):
            beyond = np.where(left, (idle + more).max(axis=1, initial=-math.inf), math.inf)
            if not left.any():
                return None
            place = int(np.argmax(beyond <= max(float(beyond.min()), 0.0)))
            found, lacked = self._try(starts_s[place], starts_s[place] + long_s)
            if found is not None:
                return found
            if isinstance(lacked, np.ndarray):
                more = lacked[-len(wheels) :] - idle[place] + OPTIONS.spare
            apart_s = OPTIONS.apart_s * OPTIONS.growth**number
            left &= np.abs(np.array(starts_s) - starts_s[place]) >= apart_s
        return None

    def _idle_curves(self, around: LightAndContacts) -> tuple[ResourceCurve, ...]:
        """Without this session and those after it, by the idle attitude throughout."""
        t_s = np.linspace(0.0, around.last_s, math.ceil(around.last_s / OPTIONS.step_s) + 1)
        spans = self.uses.sessions[: self.number]
        uses = Uses(
            sessions=spans,
            targets=self.uses.targets[: self.number],
            idle=(*self.uses.idle, (spans[-1][1] if spans else 0.0, around.last_s)),
        )
        return around.curves(t_s, _idle_along(around, t_s), uses)

    def relief_before(self, resource: str, moved: Session, since_utc: datetime) -> str:
        """In words, unloading before that start, or the last contact since an instant, if any."""
        start_s = elapsed_s(moved.start, self.epoch_utc)
        momentum = self.scenario.resources.momentum if self.scenario.resources else None
        if resource == "momentum" and momentum and momentum.unload_n_m:
            return ", after unloading"
        if resource != "memory":
            return ""
        contacts = [
            (span[0], name)
            for name, span in LightAndContacts(self.scenario, start_s).contacts
            if span[1] > elapsed_s(since_utc, self.epoch_utc)
        ]
        return f", after the contact with {max(contacts)[1]}" if contacts else ""

    @cached_property
    def farther(self) -> LightAndContacts | None:
        """As far beyond the session as the orbit is known; None: not at all."""
        stop_s = self.uses.sessions[self.number][1]
        horizon_s = min(self.scenario.orbit.search_horizon_s, OPTIONS.farthest_s)
        for beyond_s in (horizon_s, horizon_s / 16.0):
            try:
                return LightAndContacts(
                    self.scenario, max(stop_s, self.uses.sessions[-1][1]) + beyond_s
                )
            except Refusal:
                continue
        return None

    def _starts(self, around: LightAndContacts, long_s: float, until_s: float) -> list[float]:
        """Later starts, on rows, from which the target stays in sight."""
        start_s = self.uses.sessions[self.number][0]
        row = math.ceil(start_s * ROWS_PER_S) + np.arange(
            1, max(int((until_s - long_s - start_s) / OPTIONS.step_s), 0) + 1
        ) * round(OPTIONS.step_s * ROWS_PER_S)
        starts_s = row / ROWS_PER_S
        starts_s = starts_s[starts_s + long_s <= until_s]
        target = self.session.target
        if starts_s.size and not isinstance(target, BenchMotionTarget):
            target = target.unbound(self.session.start)
            is_seen = [
                may_look(self.scenario, target, *around.at(at_s))
                for at_s in (starts_s, starts_s + long_s)
            ]
            starts_s = starts_s[is_seen[0] & is_seen[1]]
        return [float(one) for one in starts_s]

    def _foretold(
        self, around: LightAndContacts, t_s: Array, along: Along, start_s: float, long_s: float
    ) -> Array:
        """What lacks, in shares of each capacity, with the session moved there, idle between."""
        spans, idle = list(self.uses.sessions), list(self.uses.idle)
        before_s = spans[self.number - 1][1] if self.number else 0.0
        slewed_s = spans[self.number][0] - max(
            (stop for _, stop in idle if stop <= spans[self.number][0]), default=before_s
        )
        spans[self.number] = start_s, start_s + long_s
        idle = [one for one in idle if not before_s <= one[0] < start_s]
        if (waits_until_s := start_s - max(slewed_s, 0.0)) > before_s:
            idle.append((before_s, waits_until_s))
        is_last = self.number + 1 == len(spans)
        table_s = float(self.levels.plan.table.t_s[-1])
        last_s = spans[-1][1] if is_last else min(table_s, around.last_s)
        uses = replace(self.uses, sessions=tuple(spans), idle=tuple(idle))
        effort.charge(OPTIONS.foretold_row * len(t_s))
        return _lacks(around.curves(t_s, along, uses), last_s)

    def works_without(self) -> bool:
        """Whether the others can be flown with this session left out."""
        sessions = list(self.scenario.sessions)
        del sessions[self.number]
        if not sessions:
            return False
        try:
            plan = _flown(replace(self.scenario, sessions=tuple(sessions)), self.mover)
            return self._works(plan)[0]
        except (SessionRefused, Refusal):
            return False

    def passes_without_s(self, curve: ResourceCurve) -> float | None:
        """When the level passes its limit without this session and those after it, if it does."""
        around = self.farther
        if around is None:
            return None
        curves = self._idle_curves(around)
        [found] = [one.first_beyond_s for one in curves if one.name == curve.name]
        return found

    def _try(self, start_s: float, stop_s: float) -> tuple[Session | None, Array | float]:
        """The session so moved, if all sessions are planned and judged good with it; else what
        lacked, in shares of each capacity."""
        start_utc, stop_utc = self.session.start, self._utc(stop_s)
        if start_s != self.uses.sessions[self.number][0]:
            start_utc = self._utc(start_s)
        try:
            target = self.session.target
            if start_utc != self.session.start:
                target = target.unbound(self.session.start)
            moved = replace(self.session, target=target, start=start_utc, stop=stop_utc)
            sessions = list(self.scenario.sessions)
            sessions[self.number] = moved
            plan = _flown(replace(self.scenario, sessions=tuple(sessions)), self.mover)
        except (SessionRefused, Refusal, ValueError):
            return None, 0.0
        works, lacked = self._works(plan)
        return (moved if works else None), lacked

    def _works(self, plan: FlightPlan) -> tuple[bool, Array]:
        """Whether a plan keeps its limits and is judged good; what lacks, in shares."""
        lacked = _lacks(resource_curves(plan))
        if lacked.max() <= 0.0:
            effort.count(OPTIONS.judged_share * table_work(plan.scenario, len(plan.table.t_s)))
            if verify(plan.table, plan.scenario, plan.waits).passed:
                return True, lacked
        return False, lacked

    def _utc(self, t_s: float) -> datetime:
        return shifted_utc(self.epoch_utc, round(t_s * ROWS_PER_S) / ROWS_PER_S)


def _lacks(curves: tuple[ResourceCurve, ...], last_s: float = math.inf) -> Array:
    """By how much each passes its limit up to an instant, in shares of its capacity."""
    return np.array([-one.room[one.t_s <= last_s].min() / one.capacity for one in curves])


def _flown(scenario: Scenario, known: Mover) -> FlightPlan:
    """As the pipeline plans it, with the slews that are known; raises SessionRefused, refusals."""
    last = session_rows(scenario.sessions[-1], scenario.initial_state.epoch)
    effort.charge(OPTIONS.table_share * table_work(scenario, last.stop))
    mover = known.planning(scenario)
    plan, _ = assemble(scenario, mover, sequence_whole(scenario, mover))
    return plan
