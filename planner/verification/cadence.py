"""Rules among sessions by the judge: gaps, and imaging in spans of time, from the request alone."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.verification.clock import elapsed_us
from planner.verification.earth import earth_orientation
from planner.verification.report import ConditionMargin, Finding
from planner.verification.session import TableSession
from planner.world.conditions import OPTIONS as CONDITION_OPTIONS
from planner.world.conditions import CadenceName, DutyCycle
from planner.world.frames.geodesy import MU_EARTH_M3_S2
from planner.world.frames.time_scales import shifted_utc
from planner.world.orbits import OrbitStates
from planner.world.scenario import Session
from planner.world.targets import BenchMotionTarget, StationTarget


@dataclass(frozen=True, kw_only=True)
class JudgedCadenceOptions:
    """The Earth's flattening in an orbit's energy, and what the judge lets pass."""

    # EGM2008: 1.5 J2 Re^2 and, for its part along the pole, the same
    flattening_m2: float = 1.5 * 1.0826359e-3 * 6_378_136.3**2
    tolerance_s: float = 1e-3  # sums of times, each to a microsecond
    period_tolerance_s: float = 0.2  # a row: an energy changes so along an orbit


OPTIONS = JudgedCadenceOptions()
_LIMITS: dict[str, CadenceName] = {"min_gap_s": "min_gap", "duty_cycle": "duty_cycle"}


def cadence_margins(flight: TableSession, states: OrbitStates) -> Iterator[ConditionMargin]:
    """Of one session after those before it, of those that image; states: of the orbit over it."""
    if not _images(flight.scenario.sessions[flight.number]):
        return
    asked, epoch_utc = flight.scenario.conditions, flight.table.epoch_utc
    sessions = filter(_images, flight.scenario.sessions[: flight.number + 1])
    spans_utc = [(one.start, one.stop) for one in flight.scenario.initial_state.past_looks]
    spans_utc += [(one.start, one.stop) for one in sessions]
    spans_s = np.array([[elapsed_us(at, epoch_utc) / 1e6 for at in ends] for ends in spans_utc])
    start_s, stop_s = spans_s[-1].tolist()
    if asked.min_gap_s > 0.0 and len(spans_s) > 1:
        gap_s = start_s - float(spans_s[:-1, 1].max())
        yield _margin(flight, "min_gap_s", asked.min_gap_s, gap_s, gap_s - asked.min_gap_s, start_s)
    if asked.duty_cycle is not None:
        length_s = _length_s(asked.duty_cycle, flight, states)
        # The sum over a span that slides turns only where an end of a session enters or leaves it.
        ends_s = np.concatenate([spans_s.ravel(), spans_s.ravel() + length_s])
        ends_s = ends_s[(ends_s >= start_s) & (ends_s <= stop_s)]
        imaged_s = [_before(at, spans_s) - _before(at - length_s, spans_s) for at in ends_s]
        worst, most_s = int(np.argmax(imaged_s)), asked.duty_cycle.imaging_max_s
        yield _margin(
            flight,
            "duty_cycle",
            most_s,
            imaged_s[worst],
            most_s - imaged_s[worst],
            float(ends_s[worst]),
        )


def _images(session: Session) -> bool:
    return not isinstance(session.target, BenchMotionTarget | StationTarget)


def cadence_findings(
    flight: TableSession, margins: tuple[ConditionMargin, ...]
) -> Iterator[Finding]:
    """One error for each rule that isn't kept."""
    duty = flight.scenario.conditions.duty_cycle
    is_period = duty is not None and duty.span_s is None
    for margin in margins:
        lets_s = OPTIONS.tolerance_s
        if margin.name == "duty_cycle" and is_period:
            lets_s = OPTIONS.period_tolerance_s
        if not margin.margin >= -lets_s:
            told = "s of imaging in a span" if margin.name == "duty_cycle" else "s from the last"
            yield Finding(
                limit=_LIMITS[margin.name],
                t_s=margin.t_s,
                at_utc=margin.at_utc,
                detail=(
                    f"session {flight.number + 1}: {margin.extreme:.6g} {told}, "
                    f"{-margin.margin:.3g} s beyond the {margin.limit:g} s of {margin.name}"
                ),
            )


def _margin(
    flight: TableSession, name: str, limit: float, extreme: float, margin: float, t_s: float
) -> ConditionMargin:
    at_utc = shifted_utc(flight.table.epoch_utc, t_s)
    return ConditionMargin(
        name=name, unit="s", limit=limit, extreme=extreme, margin=margin, t_s=t_s, at_utc=at_utc
    )


def _before(at_s: float, spans_s: Array) -> float:
    """Imaged until then."""
    return float(np.clip(at_s - spans_s[:, 0], 0.0, spans_s[:, 1] - spans_s[:, 0]).sum())


def _length_s(duty: DutyCycle, flight: TableSession, states: OrbitStates) -> float:
    """Unless given, by Kepler's third law from the energy as the session begins."""
    if duty.span_s is not None:
        return duty.span_s
    instants = flight.at.instants
    r_m, v_m_s = states.r_sat_eci_m[0], states.v_sat_eci_m_s[0]
    earth = earth_orientation(instants.epoch_utc, instants.t_s)
    polar_m = float(earth.itrf_from_eci(states.r_sat_eci_m)[0, 2])
    square_m2 = float(r_m @ r_m)
    bulge = OPTIONS.flattening_m2 / square_m2 * (polar_m**2 / square_m2 - 1.0 / 3.0)
    inverse_axis_per_m = 2.0 / math.sqrt(square_m2) * (1.0 - bulge) - v_m_s @ v_m_s / MU_EARTH_M3_S2
    if inverse_axis_per_m <= 0.0:  # no closed orbit
        return CONDITION_OPTIONS.span_max_s
    period_s = 2.0 * math.pi / math.sqrt(MU_EARTH_M3_S2 * float(inverse_axis_per_m) ** 3)
    return min(period_s, CONDITION_OPTIONS.span_max_s)
