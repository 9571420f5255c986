"""Rules among sessions: the least gap between them, and how much a span of time may have."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import CadenceBroken, figures
from planner.world.conditions import CadenceName, Conditions
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc, utc_text
from planner.world.orbits import Ephemeris
from planner.world.scenario import PastLook, Scenario, Session


@dataclass(frozen=True, kw_only=True)
class CadenceOptions:
    """How closely the rules are kept."""

    tolerance_s: float = 1e-5  # of sums of times that are known to a microsecond each


OPTIONS = CadenceOptions()


class _Broken(NamedTuple):
    """limit: the rule.  at_s: from when on a session may not be.  because: in words."""

    limit: CadenceName
    at_s: float
    because: str


class Cadence:
    """The rules of a request among its sessions that look somewhere; test motions don't count."""

    def __init__(self, scenario: Scenario, ephemeris: Ephemeris) -> None:
        self._epoch_utc = scenario.initial_state.epoch
        self._asked: Conditions = scenario.conditions
        self._sessions = scenario.sessions
        self._spans_s = [self._span_s(one) for one in scenario.sessions]
        self._past_s = [self._span_s(one) for one in scenario.initial_state.past_looks]
        duty, self._length_s = self._asked.duty_cycle, 0.0
        if duty is not None:
            first = Instants(scenario.sessions[0].start, np.zeros(1))
            self._length_s = duty.lasts_s(first, ephemeris.states(first))

    def require(self, number: int) -> None:
        """Raises CadenceBroken where a session doesn't keep the rules after those before it."""
        broken = self._broken(number, *self._spans_s[number])
        if broken is not None:
            raise CadenceBroken(
                f"session {number + 1}: {broken.because}",
                field=f"sessions.{number}.start",
                limit=broken.limit,
                at_utc=shifted_utc(self._epoch_utc, broken.at_s),
            )

    def keeps(self, number: int, start_s: float, stop_s: float) -> bool:
        """Whether it does between these times after the epoch."""
        return self._broken(number, start_s, stop_s) is None

    def soonest_s(self, number: int) -> float:
        """After the epoch, at which it may begin by the least gap."""
        before = self._before(number)
        is_bound = before and _looks(self._sessions[number])
        last_s = max((stop_s for _, stop_s in before), default=0.0)
        return last_s + self._asked.min_gap_s if is_bound else -math.inf

    def kept_until_s(self, number: int) -> float:
        """After the epoch, until when the duty cycle lets it last, begun as asked."""
        crossing = self._over(number, *self._spans_s[number])
        return math.inf if crossing is None else crossing

    def _broken(self, number: int, start_s: float, stop_s: float) -> _Broken | None:
        soonest_s, least_s = self.soonest_s(number), self._asked.min_gap_s
        if start_s < soonest_s - OPTIONS.tolerance_s:
            gap_s = start_s - (soonest_s - least_s)
            return _Broken(
                "min_gap",
                start_s,
                f"it begins {figures(gap_s, least_s)} s after the session before it ends, sooner "
                f"than the {least_s:g} s of min_gap_s",
            )
        crossing, duty = self._over(number, start_s, stop_s), self._asked.duty_cycle
        if duty is None or crossing is None:
            return None
        at, since = (
            utc_text(shifted_utc(self._epoch_utc, t_s), 1)
            for t_s in (crossing, crossing - self._length_s)
        )
        return _Broken(
            "duty_cycle",
            crossing,
            f"from {at} on, it and those since {since}, {self._length_s:.6g} s before, last longer "
            f"than the {duty.imaging_max_s:g} s of duty_cycle",
        )

    def _over(self, number: int, start_s: float, stop_s: float) -> float | None:
        """When in a session the span that ends then has more than it may."""
        duty, length_s = self._asked.duty_cycle, self._length_s
        if duty is None or not _looks(self._sessions[number]):
            return None
        spans_s = np.array([*self._before(number), (start_s, stop_s)])
        turns_s = np.concatenate([[start_s, stop_s], (spans_s + length_s).ravel()])
        at_s = np.unique(turns_s[(turns_s >= start_s) & (turns_s <= stop_s)])
        over_s = _imaged_s(spans_s, at_s - length_s, at_s) - duty.imaging_max_s
        beyond = np.flatnonzero(over_s > OPTIONS.tolerance_s)
        if not beyond.size:
            return None
        k = int(beyond[0])
        if k == 0:
            return start_s
        share = max(-over_s[k - 1], 0.0) / (over_s[k] - over_s[k - 1])
        return float(at_s[k - 1] + share * (at_s[k] - at_s[k - 1]))

    def _before(self, number: int) -> list[tuple[float, float]]:
        return self._past_s + [
            span_s
            for one, span_s in zip(self._sessions, self._spans_s[:number], strict=False)
            if _looks(one)
        ]

    def _span_s(self, session: Session | PastLook) -> tuple[float, float]:
        start_s, stop_s = (elapsed_s(at, self._epoch_utc) for at in (session.start, session.stop))
        return start_s, stop_s


def _looks(session: Session) -> bool:
    return session.target.images


def _imaged_s(spans_s: Array, from_s: Array, to_s: Array) -> Array:
    """Of sessions' spans (k, 2), how much lies between instants, (n,)."""
    within_s = np.minimum(spans_s[:, 1, None], to_s) - np.maximum(spans_s[:, 0, None], from_s)
    return np.asarray(np.maximum(within_s, 0.0).sum(axis=0))
