"""Alternatives to a refused session, nearest first, each tried by planning it.

Another time, another session, less momentum in the gyros.  An alternative that is named has been
planned and verified.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import chain, product
from typing import NamedTuple

import numpy as np

from planner.base.commands import COMMAND_STEP_S
from planner.base.errors import InfeasibleSlew, OutsideCoverage, Refusal, Unreachable
from planner.spacecraft.imaging.candidates import candidates
from planner.spacecraft.imaging.choice import LooksTooClose
from planner.spacecraft.imaging.session import make_session
from planner.spacecraft.requests import (
    SESSION_MAX_S,
    ImagingPlanRequest,
    Request,
    StereoRequest,
)
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text


@dataclass(frozen=True, kw_only=True)
class AlternativeOptions:
    """What is changed of a request that can't be met, in the order tried."""

    tried_max: int = 4  # of the other times at which one request can be met
    before_s: float = 90.0  # to slew onto the first look
    after_s: float = 60.0  # and back after the last
    # tried before and after the session: up to an orbit
    longer_s: tuple[float, float, float] = (0.0, 600.0, 6000.0)
    much_share: float = 0.6  # of the sphere: then it is the momentum that makes slews slow
    # of what is stored at the start
    momentum_shares: tuple[float, ...] = (0.9, 0.75, 0.5, 0.25, 0.0)
    # a wider gap makes the slew longer
    gap_more_s: tuple[float, ...] = (0.0, 2.0, 4.0, 8.0, 16.0, 32.0)


OPTIONS = AlternativeOptions()


class Alternative(NamedTuple):
    """A request worth trying, and how to say so.  start_utc, stop_utc: of its imaging."""

    request: ImagingPlanRequest
    text: str
    start_utc: datetime | None = None
    stop_utc: datetime | None = None


def refusal_with_alternative(
    request: ImagingPlanRequest, why: Refusal, works: Callable[[ImagingPlanRequest], bool]
) -> Refusal:
    """The refusal with the nearest alternative that works; as it is when none of those tried
    does."""
    last = (why.field or "").rpartition(".")[2]
    number = int(last) if last.isdigit() else 0  # the first where it is about all of them
    stored_n_m_s = float(np.linalg.norm(request.settings.momentum_n_m_s))
    sphere_n_m_s = request.definition().gyros.turns.momentum_max_n_m_s
    is_much = stored_n_m_s > OPTIONS.much_share * sphere_n_m_s
    if why.limit == "momentum" or (isinstance(why, InfeasibleSlew) and is_much):
        alternatives = _less_momentum(request, stored_n_m_s, sphere_n_m_s)
    elif isinstance(why, LooksTooClose):
        alternatives = _wider_gaps(request, number, why.gap_s)
    else:
        alternatives = _of_one_request(request, number)
    for one in alternatives:
        if works(replace(one.request, simulation_runs=0)):
            kind = Unreachable if isinstance(why, Unreachable) else InfeasibleSlew
            return kind(
                f"{why.detail}; nearest that was tried and works: {one.text}",
                field=why.field,
                limit=why.limit,
                at_utc=why.at_utc,
                earliest_feasible_start_utc=one.start_utc,
                feasible_stop_utc=one.stop_utc,
            )
    return why


def _less_momentum(
    request: ImagingPlanRequest, stored_n_m_s: float, sphere_n_m_s: float
) -> Iterator[Alternative]:
    for left_n_m_s in (share * sphere_n_m_s for share in OPTIONS.momentum_shares):
        if left_n_m_s < stored_n_m_s:
            left = np.array(request.settings.momentum_n_m_s) * (left_n_m_s / stored_n_m_s)
            x, y, z = left.tolist()
            changed = replace(request, settings=replace(request.settings, momentum_n_m_s=(x, y, z)))
            yield Alternative(changed, f"{left_n_m_s:.0f} N m s in the same direction")


def _wider_gaps(request: ImagingPlanRequest, number: int, gap_s: float) -> Iterator[Alternative]:
    """The number-th request, a stereo pair, by itself with its looks further apart."""
    asked = request.requests[number]
    assert isinstance(asked, StereoRequest)
    for more_s in OPTIONS.gap_more_s:
        pair = replace(asked, look_angle_deg=None, gap_s=math.ceil(gap_s) + more_s)
        changed = replace(request, requests=(pair,))
        yield Alternative(changed, f"{pair.name!r} with a gap_s of {pair.gap_s:g}")


def _of_one_request(request: ImagingPlanRequest, number: int) -> Iterator[Alternative]:
    """The number-th request by itself, at the times nearest to those asked for, each a window that
    holds nothing else."""
    bound = request.requests[number]
    free = replace(bound, start=None, window_start=None, window_stop=None)
    for longer_s in OPTIONS.longer_s:
        spans = sorted(
            _spans(request, free, longer_s), key=lambda span: _shift_s(request, bound, *span)
        )
        if spans:
            yield from (_at_time(request, free, *span) for span in spans[: OPTIONS.tried_max])
            return


def _spans(
    request: ImagingPlanRequest, free: Request, longer_s: float
) -> Iterator[tuple[datetime, datetime]]:
    """When it can be imaged in the session with so much more before and behind it: in pieces no
    longer than allowed, a stereo pair from look to look."""
    begin_s, end_s = -longer_s, elapsed_s(request.stop, request.start) + longer_s
    count = int(np.ceil((end_s - begin_s) / SESSION_MAX_S))
    piece_s = np.floor((end_s - begin_s) / count)
    for k in range(count):
        start = shifted_utc(request.start, begin_s + k * piece_s)
        piece = replace(request, start=start, stop=shifted_utc(start, piece_s))
        with suppress(Unreachable, InfeasibleSlew, OutsideCoverage):
            options = candidates(free, 0, make_session(piece))
            first, last = options[0], options[-1]
            spans_s = [*chain(*(zip(one.starts_s, one.stops_s, strict=True) for one in options))]
            if isinstance(free, StereoRequest):
                pairs_s = product(first.stops_s, last.starts_s)
                spans_s = [(a - first.arc.scan_s, b + last.arc.scan_s) for a, b in pairs_s if a < b]
            elif last.arc.look > 0:
                spans_s = [(min(spans_s)[0], max(stop_s for _, stop_s in spans_s))]
            for start_s, stop_s in spans_s:
                yield shifted_utc(start, start_s), shifted_utc(start, stop_s)


def _shift_s(request: ImagingPlanRequest, bound: Request, start: datetime, stop: datetime) -> float:
    """How much what was asked would have to give: its start, or its window or session."""
    if bound.start is not None:
        return abs(elapsed_s(start, bound.start))
    first = bound.window_start or shifted_utc(request.start, OPTIONS.before_s)
    last = bound.window_stop or shifted_utc(request.stop, -OPTIONS.after_s)
    return max(elapsed_s(first, start), 0.0) + max(elapsed_s(stop, last), 0.0)


def _at_time(
    request: ImagingPlanRequest, free: Request, start: datetime, stop: datetime
) -> Alternative:
    """A window from start to stop, in a session that leaves time to slew there and back."""
    early_s = max(0.0, OPTIONS.before_s - elapsed_s(start, request.start))
    late_s = max(0.0, OPTIONS.after_s - elapsed_s(request.stop, stop))
    session_start = shifted_utc(request.start, -COMMAND_STEP_S * np.ceil(early_s / COMMAND_STEP_S))
    session_stop = shifted_utc(request.stop, late_s)
    if elapsed_s(session_stop, session_start) > SESSION_MAX_S:
        session_start = shifted_utc(start, -OPTIONS.before_s)
        session_stop = shifted_utc(stop, OPTIONS.after_s)
    text = (
        f"{free.name!r} in a window from {utc_text(start, 1)} to {utc_text(stop, 1)} "
        f"({elapsed_s(stop, start):.1f} s)"
    )
    if (session_start, session_stop) != (request.start, request.stop):
        text += f" in a session from {utc_text(session_start, 1)} to {utc_text(session_stop, 1)}"
    asked = (replace(free, window_start=start, window_stop=stop),)
    changed = replace(request, start=session_start, stop=session_stop, requests=asked)
    return Alternative(changed, text, start, stop)
