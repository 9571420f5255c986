"""An orbit from an ephemeris message (CCSDS OEM)."""

import math
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cached_property
from typing import ClassVar, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidMessage, OutsideCoverage
from planner.base.interpolation import hermite, hermite_error_m
from planner.base.spec import spec
from planner.world.frames.earth_orientation import eci_from_frame_state
from planner.world.frames.time_scales import (
    DAY_S,
    Instants,
    elapsed_s,
    shifted_utc,
    tai_us,
    utc_text,
)
from planner.world.messages.oem import Oem, OemSegment, read_oem
from planner.world.orbits.accuracy import OrbitSigma, PlannedBurn, oem_sigma
from planner.world.orbits.burns import Burn, burns_between
from planner.world.orbits.cell_defects import (
    OPTIONS as CELL_DEFECT_OPTIONS,
)
from planner.world.orbits.cell_defects import (
    CellDefects,
    cell_defects,
    odd_nodes,
    smooth_arcs,
    strongest_push,
)
from planner.world.orbits.decay import drag_in_a_day_m
from planner.world.orbits.ephemeris import (
    EDGE_S,
    CarrierName,
    Ephemeris,
    OrbitSource,
    OrbitStates,
)

NODES = 6
MARGIN = NODES // 2 + 1  # nodes beyond the asked span: half a window and one to judge it by
WARN_ERROR_M = 1.0
REFUSE_ERROR_M = 100.0


@spec
class OemOrbit(OrbitSource):
    """The text of a CCSDS OEM, KVN or XML, as published.

    content: the whole message, line breaks included.
    """

    search_horizon_s: ClassVar[float] = DAY_S
    source: Literal["oem"] = "oem"
    content: str

    def __post_init__(self) -> None:
        try:
            _ = self.message
        except InvalidMessage as refusal:
            raise ValueError(f"content: {refusal.detail}") from None

    @cached_property
    def message(self) -> Oem:
        """Read once, at construction."""
        return read_oem(self.content)

    @property
    def carrier_name(self) -> CarrierName:
        """The OBJECT_NAME of the message's first segment."""
        return CarrierName(self.message.segments[0].object_name)

    def ephemeris(self, start_utc: datetime, stop_utc: datetime) -> "OemEphemeris":
        """Raises OutsideCoverage where the message's useable times leave a gap, InvalidMessage
        where a node near the span contradicts its neighbours.
        """
        arcs: list[Arc] = []
        reach_utc = start_utc
        for segment in self.message.segments:
            first_utc, last_utc = (shifted_utc(segment.epoch_utc, t) for t in segment.useable_s)
            ahead_s = elapsed_s(last_utc, reach_utc)
            starts = elapsed_s(first_utc, reach_utc) <= 0.0
            if not starts or ahead_s < 0.0 or (arcs and ahead_s == 0.0):
                continue
            arcs += _arcs_between(segment, reach_utc, min(last_utc, stop_utc, key=tai_us))
            reach_utc = last_utc
            if elapsed_s(reach_utc, stop_utc) >= 0.0:
                break
        else:
            raise OutsideCoverage(
                f"the OEM says nothing between {utc_text(reach_utc)} and {utc_text(stop_utc)}; "
                f"it covers {_coverage_text(self.message)}",
                field="orbit.content",
            )
        burns = self._burns_before(stop_utc)
        ephemeris = OemEphemeris(
            epoch_utc=self._made_utc,
            start_utc=start_utc,
            stop_utc=stop_utc,
            warnings=tuple(dict.fromkeys(warning for arc in arcs for warning in arc.warnings)),
            drag_in_a_day_m=self._drag_in_a_day_m,
            burns=burns,
            arcs=tuple(arcs),
        )
        return replace(ephemeris, warnings=(*ephemeris.warnings, *_burn_warning(ephemeris)))

    @property
    def _made_utc(self) -> datetime:
        """What lies after it was a forecast."""
        return self.message.creation_utc or self.message.segments[0].epoch_utc

    def _burns_before(self, stop_utc: datetime) -> tuple[Burn, ...]:
        """Planned when the message was made, and begun before."""
        days = math.ceil(elapsed_s(stop_utc, self._made_utc) / DAY_S)
        if days > 0 and days not in self._burns_by_day:
            until_utc = shifted_utc(self._made_utc, days * DAY_S)
            self._burns_by_day[days] = burns_between(
                self.message.segments, self._made_utc, until_utc
            )
        burns = self._burns_by_day.get(days, ())
        return tuple(burn for burn in burns if elapsed_s(burn.ignition_utc, stop_utc) < 0.0)

    @cached_property
    def _burns_by_day(self) -> dict[int, tuple[Burn, ...]]:
        """What was searched for already, until so many days after it was made."""
        return {}

    @cached_property
    def _drag_in_a_day_m(self) -> float:
        return drag_in_a_day_m(self.message.segments)


@dataclass(frozen=True, eq=False)
class Arc:
    """A stretch without a kink: node_s from epoch_utc, positions and velocities in ECI.

    stop_utc: the next arc takes over there.
    """

    epoch_utc: datetime
    stop_utc: datetime
    node_s: Array
    r_eci_m: Array
    v_eci_m_s: Array
    nodes: int
    warnings: tuple[str, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class OemEphemeris(Ephemeris):
    """Hermite interpolation within each arc, never across a burn or a segment's end.

    drag_in_a_day_m: as `oem_sigma` takes it.  burns: planned ones before its stop.
    """

    drag_in_a_day_m: float
    burns: tuple[Burn, ...]
    arcs: tuple[Arc, ...]

    def interpolate(self, instants: Instants) -> OrbitStates:
        """Velocity is the exact derivative of position."""
        r_m, v_m_s = np.empty((len(instants), 3)), np.empty((len(instants), 3))
        todo = np.ones(len(instants), dtype=bool)
        for arc in self.arcs:
            t_s = instants.since_s(arc.epoch_utc)
            here = todo & (t_s <= elapsed_s(arc.stop_utc, arc.epoch_utc) + EDGE_S)
            if here.any():
                r_m[here], v_m_s[here] = hermite(
                    arc.node_s, arc.r_eci_m, arc.v_eci_m_s, t_s[here], arc.nodes
                )
                todo &= ~here
        return OrbitStates(r_m, v_m_s)

    def age_s(self, instants: Instants) -> Array:
        """Time since the message was made, shape (n,); zero before."""
        return np.maximum(instants.since_s(self.epoch_utc), 0.0)

    def sigma(self, instants: Instants) -> OrbitSigma:
        """Sigma by drag in the message, which its operator had to forecast, and planned burns."""
        burns = [
            PlannedBurn(np.maximum(instants.since_s(burn.ignition_utc), 0.0), burn.along_m_s)
            for burn in self.burns
        ]
        return oem_sigma(self.age_s(instants), self.drag_in_a_day_m, burns)


def _burn_warning(ephemeris: OemEphemeris) -> tuple[str, ...]:
    """That planned burns lie before the stop, and how well the orbit is known there."""
    if not ephemeris.burns:
        return ()
    first, *others = ephemeris.burns
    more = f" and {len(others)} more" if others else ""
    along_m = float(ephemeris.sigma(Instants(ephemeris.stop_utc, np.zeros(1))).along_m[0])
    return (
        f"the OEM was made {utc_text(ephemeris.epoch_utc, 0)}, before a burn it plans: "
        f"{first.gain_m_s:.2f} m/s at {utc_text(first.ignition_utc, 0)}{more}; planned burns are "
        f"moved and changed: expect an error of some {along_m / 1e3:.0f} km (1 sigma) along the "
        "track, or take an ephemeris made after it",
    )


def _arcs_between(segment: OemSegment, start_utc: datetime, stop_utc: datetime) -> list[Arc]:
    """Arcs of one segment that together cover start to stop."""
    start_s, stop_s = (elapsed_s(t, segment.epoch_utc) for t in (start_utc, stop_utc))
    last = len(segment.t_s) - 1
    low = max(int(np.searchsorted(segment.t_s, start_s, side="right")) - MARGIN, 0)
    high = min(int(np.searchsorted(segment.t_s, stop_s)) + MARGIN, last)
    near = slice(low, high + 1)
    node_s = segment.t_s[near]
    nodes_at = Instants(segment.epoch_utc, node_s)
    r_m, v_m_s = eci_from_frame_state(
        segment.frame, segment.r_m[near], segment.v_m_s[near], nodes_at
    )
    defects = cell_defects(nodes_at, r_m, v_m_s)
    odd = _odd_warning(segment, node_s, defects)
    arcs = []
    for arc in smooth_arcs(defects):
        window = slice(arc.first, arc.last + 1)
        if node_s[arc.last] < start_s - EDGE_S or node_s[arc.first] > stop_s:
            continue
        span_s = (max(start_s, node_s[arc.first]), min(stop_s, node_s[arc.last]))
        nodes = 2 if arc.thrust_m_s2 else NODES
        middle_s = _cell_middles(node_s[window], *span_s)
        error_m = hermite_error_m(node_s[window], r_m[window], v_m_s[window], middle_s, nodes)
        gap_s = float(np.max(np.diff(node_s[window])))
        # The thrust may start or stop anywhere in a cell.
        error_m += arc.thrust_m_s2 * gap_s**2 / 8.0
        arcs.append(
            Arc(
                epoch_utc=segment.epoch_utc,
                stop_utc=shifted_utc(segment.epoch_utc, float(node_s[arc.last])),
                node_s=node_s[window],
                r_eci_m=r_m[window],
                v_eci_m_s=v_m_s[window],
                nodes=nodes,
                warnings=odd + _room_warnings(segment, middle_s, error_m, gap_s, arc.thrust_m_s2),
            )
        )
    return arcs


def _cell_middles(node_s: Array, start_s: float, stop_s: float) -> Array:
    """Middles of the cells between start and stop, at least one."""
    first = min(int(np.searchsorted(node_s, start_s, side="right")) - 1, len(node_s) - 2)
    last = max(int(np.searchsorted(node_s, stop_s)), first + 1)
    return 0.5 * (node_s[first:last] + node_s[first + 1 : last + 1])


def _odd_warning(segment: OemSegment, node_s: Array, defects: CellDefects) -> tuple[str, ...]:
    """What to say of nodes that contradict each other; InvalidMessage where it is too much."""

    def at(node: int) -> datetime:
        return shifted_utc(segment.epoch_utc, float(node_s[node]))

    odd = odd_nodes(defects)
    which = f"state at {utc_text(at(odd.first))} lies"
    if odd.last > odd.first:
        which = f"states at {utc_text(at(odd.first))} and {utc_text(at(odd.last))} lie"
    sentence = (
        f"the OEM's {which} some {odd.off_m:.0f} m off what the neighbouring states lead to, and "
        "no manoeuvre explains it"
    )
    if not odd.off_m <= CELL_DEFECT_OPTIONS.refuse_m:
        raise InvalidMessage(
            f"{sentence}; was a number damaged on its way? Get the message again",
            field="orbit.content",
            at_utc=at(odd.first),
        )
    cell = strongest_push(defects)
    if cell is not None:
        raise InvalidMessage(
            f"the OEM's states from {utc_text(at(cell))} to {utc_text(at(cell + 1))} change "
            f"as if pushed by {defects.thrust_m_s2[cell]:.2g} m/s^2, which no carrier of a "
            "camera is; is REF_FRAME the frame they are in, and TIME_SYSTEM their clock?",
            field="orbit.content",
            at_utc=at(cell),
        )
    return (sentence,) if odd.off_m > CELL_DEFECT_OPTIONS.warn_m else ()


def _room_warnings(
    segment: OemSegment, middle_s: Array, error_m: Array, gap_s: float, thrust_m_s2: float
) -> tuple[str, ...]:
    """What to say of the room between nodes; OutsideCoverage where they are too far apart."""
    worst = int(np.argmax(error_m))
    at_utc = shifted_utc(segment.epoch_utc, float(middle_s[worst]))
    burn = f" during a burn of {thrust_m_s2 * 1e3:.2f} mm/s^2" if thrust_m_s2 else ""
    sentence = (
        f"the OEM's nodes near {utc_text(at_utc, 0)}, up to {gap_s:.0f} s apart{burn}, leave the "
        f"position between them uncertain by some {error_m[worst]:.1f} m"
    )
    if error_m[worst] > REFUSE_ERROR_M:
        raise OutsideCoverage(
            f"{sentence}; send the ephemeris with closer nodes "
            "(240 s do in low orbit, 10 s in burns)",
            field="orbit.content",
            at_utc=at_utc,
        )
    return (sentence,) if error_m[worst] > WARN_ERROR_M else ()


def _coverage_text(message: Oem) -> str:
    spans = [
        " to ".join(utc_text(shifted_utc(segment.epoch_utc, t)) for t in segment.useable_s)
        for segment in message.segments
    ]
    return ", ".join(spans[:3]) + (f" and {len(spans) - 3} more spans" if len(spans) > 3 else "")
