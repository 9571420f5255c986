"""An orbit from one position and velocity."""

import math
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from typing import Annotated, ClassVar, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import OutsideCoverage, figures
from planner.base.spec import Within, spec
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S, eci_from_frame_state
from planner.world.frames.time_scales import (
    Instants,
    elapsed_s,
    require_known,
    shifted_utc,
    utc_text,
)
from planner.world.orbits.accuracy import OrbitSigma, state_sigma
from planner.world.orbits.atmosphere import HEIGHT_MIN_M
from planner.world.orbits.collocation import (
    OPTIONS as COLLOCATION_OPTIONS,
)
from planner.world.orbits.collocation import (
    CollocationSegment,
    node_times_s,
    propagate_segment,
)
from planner.world.orbits.ephemeris import CarrierName, Ephemeris, OrbitSource, OrbitStates
from planner.world.orbits.forces import forces_at
from planner.world.orbits.gravity import GM_M3_S2, RADIUS_M
from planner.world.orbits.paper_model import PaperEphemeris, paper_ephemeris

WARN_AGE_S = {"full": 6.0 * 3600.0, "j2j4": 900.0}
REFUSE_AGE_S = 3.0 * 86400.0
_PERIGEE_MIN_M = RADIUS_M - 22e3 + HEIGHT_MIN_M  # 22 km: the Earth's flattening

_PositionKm = Annotated[float, Within(-1e7, 1e7)]  # wider than any orbit,
_VelocityKmS = Annotated[float, Within(-1e7, 1e7)]  # so that metres are told as such
BALLISTIC_MAX_M2_KG = 1.0  # the ISS has 0.007; only sails and balloons have more
_SHORTEST_S = 1.0  # so that a plan at the epoch has a polynomial too


@spec
class StateVectorOrbit(OrbitSource):
    """Position and velocity at an epoch, from the Earth's centre.

    frame: of both. GCRF and EME2000 differ by 0.02 arcsec.
    epoch: time of the state; UTC.
    position_km: x, y, z.
    velocity_km_s: x, y, z; in ITRF relative to the rotating Earth.
    force_model: `full` is the 36x36 field, Sun, Moon and drag (0.2 m after 900 s); `j2j4` the
    paper's (56 m).
    mass_kg: of the carrier, for drag; the ISS's unless given, about the mean of its published
    ephemeris headers.
    drag_area_m2: of the carrier's front; the ISS's unless given.
    drag_coefficient: of the carrier; the ISS's unless given.
    """

    search_horizon_s: ClassVar[float] = 6000.0  # a numerical propagation of a day takes seconds
    source: Literal["state"] = "state"
    frame: Literal["ITRF", "EME2000", "GCRF"]
    epoch: datetime
    position_km: tuple[_PositionKm, _PositionKm, _PositionKm]
    velocity_km_s: tuple[_VelocityKmS, _VelocityKmS, _VelocityKmS]
    force_model: Literal["full", "j2j4"] = "full"
    mass_kg: Annotated[float, Within(1e-3, 1e9)] = 450e3
    drag_area_m2: Annotated[float, Within(0.0, 1e6)] = 1500.0
    drag_coefficient: Annotated[float, Within(0.0, 100.0)] = 2.0

    def __post_init__(self) -> None:
        try:
            require_known(self.epoch)
        except ValueError as error:
            raise ValueError(f"epoch {error}") from None
        if not self.ballistic_m2_kg <= BALLISTIC_MAX_M2_KG:
            raise ValueError(
                f"mass_kg {self.mass_kg:g} has {self.ballistic_m2_kg:.3g} m2/kg of drag "
                f"(drag_area_m2 times drag_coefficient), more than the {BALLISTIC_MAX_M2_KG:g} of "
                "a sail; is it in kg?"
            )
        _check_orbit(self)

    @property
    def carrier_name(self) -> CarrierName:
        """None: a bare state has no name."""
        return CarrierName("")

    @property
    def ballistic_m2_kg(self) -> float:
        """Drag coefficient times area over mass."""
        return self.drag_coefficient * self.drag_area_m2 / self.mass_kg

    def ephemeris(
        self, start_utc: datetime, stop_utc: datetime
    ) -> "PropagatedEphemeris | PaperEphemeris":
        """Propagates from the epoch, forward and backward as far as the span asks.

        Raises OutsideCoverage beyond 3 days from the epoch, or when the satellite falls.
        """
        start_s, stop_s = (elapsed_s(t, self.epoch) for t in (start_utc, stop_utc))
        age_s = max(abs(start_s), abs(stop_s))
        sentence = (
            f"the state's epoch {utc_text(self.epoch, 0)} is "
            f"{figures(age_s / 3600.0, REFUSE_AGE_S / 3600.0)} h from the plan"
        )
        if age_s > REFUSE_AGE_S:
            raise OutsideCoverage(
                f"{sentence}; beyond {REFUSE_AGE_S / 3600.0:.0f} h drag is not known well enough; "
                "send a newer state",
                field="orbit.epoch",
            )
        warnings: tuple[str, ...] = ()
        if age_s > WARN_AGE_S[self.force_model]:
            sigma = state_sigma(np.array(age_s), paper_model=self.force_model == "j2j4")
            warnings = (
                f"{sentence}: expect an error of some {float(sigma.along_m):.0f} m (1 sigma)",
            )
        if self.force_model == "j2j4":
            r_eci_m, v_eci_m_s = _state_eci(self)
            return paper_ephemeris(self.epoch, r_eci_m, v_eci_m_s, start_utc, stop_utc, warnings)
        segments = [
            segment
            for span_s in (min(start_s, 0.0), max(stop_s, _SHORTEST_S))
            for segment in self._segments_to(span_s)
        ]
        return PropagatedEphemeris(
            epoch_utc=self.epoch,
            start_utc=start_utc,
            stop_utc=stop_utc,
            warnings=warnings,
            segments=tuple(sorted(segments, key=lambda s: min(s.start_s, s.stop_s))),
        )

    def _segments_to(self, span_s: float) -> list[CollocationSegment]:
        """Segments from the epoch to span_s, either way, in its order; none for span 0."""
        whole = self._whole_segments[span_s > 0.0]
        step_s = math.copysign(COLLOCATION_OPTIONS.segment_s, span_s)
        count = math.floor(abs(span_s) / COLLOCATION_OPTIONS.segment_s)
        while len(whole) < count:
            whole.append(_propagate_on(self, whole, len(whole) * step_s, (len(whole) + 1) * step_s))
        segments = whole[:count]
        if abs(span_s) > count * COLLOCATION_OPTIONS.segment_s:
            segments.append(_propagate_on(self, segments, count * step_s, span_s))
        return segments

    @cached_property
    def _whole_segments(self) -> dict[bool, list[CollocationSegment]]:
        """What is propagated already, backward and forward: days take seconds, and one plan asks
        for several spans.
        """
        return {False: [], True: []}


@dataclass(frozen=True, eq=False, kw_only=True)
class PropagatedEphemeris(Ephemeris):
    """segments: in time's order, without gaps, seconds from epoch_utc."""

    segments: tuple[CollocationSegment, ...]

    def interpolate(self, instants: Instants) -> OrbitStates:
        """Velocity is the exact derivative of position."""
        t_s = instants.since_s(self.epoch_utc)
        ends_s = [max(segment.start_s, segment.stop_s) for segment in self.segments[:-1]]
        which = np.searchsorted(ends_s, t_s)
        r_m, v_m_s = np.empty((len(t_s), 3)), np.empty((len(t_s), 3))
        for k in np.unique(which):
            here = which == k
            r_m[here], v_m_s[here] = self.segments[k].at(t_s[here])
        return OrbitStates(r_m, v_m_s)

    def sigma(self, instants: Instants) -> OrbitSigma:
        """Errors of the state at its epoch, grown, and of the full force model."""
        return state_sigma(self.age_s(instants), paper_model=False)


def _check_orbit(orbit: StateVectorOrbit) -> None:
    """A wrong unit or frame almost always gives an orbit through the Earth or to infinity."""
    r_m = np.array(orbit.position_km) * 1e3
    v_m_s = np.array(orbit.velocity_km_s) * 1e3
    if orbit.frame == "ITRF":
        v_m_s = v_m_s + np.cross([0.0, 0.0, OMEGA_EARTH_RAD_S], r_m)
    radius_m = float(np.linalg.norm(r_m))
    if radius_m < _PERIGEE_MIN_M:
        raise ValueError(
            f"position_km is {figures(radius_m / 1e3, _PERIGEE_MIN_M / 1e3)} km from the Earth's "
            "centre, too low to orbit; is it in km?"
        )
    energy = 0.5 * float(v_m_s @ v_m_s) - GM_M3_S2 / radius_m
    if energy >= 0.0:
        raise ValueError(
            f"velocity_km_s {orbit.velocity_km_s} is so much that the satellite leaves the Earth; "
            "is it in km/s and of the stated frame?"
        )
    momentum = float(np.linalg.norm(np.cross(r_m, v_m_s)))
    axis_m = -GM_M3_S2 / (2.0 * energy)
    eccentricity = math.sqrt(max(0.0, 1.0 - momentum**2 / (GM_M3_S2 * axis_m)))
    perigee_m = axis_m * (1.0 - eccentricity)
    if perigee_m < _PERIGEE_MIN_M:
        raise ValueError(
            f"velocity_km_s {orbit.velocity_km_s} makes an orbit whose perigee is "
            f"{figures(perigee_m / 1e3, _PERIGEE_MIN_M / 1e3)} km from the Earth's centre, below "
            f"{HEIGHT_MIN_M / 1e3:.0f} km height; is it in km/s and of the stated frame?"
        )


def _state_eci(orbit: StateVectorOrbit) -> tuple[Array, Array]:
    """Position and velocity at the epoch, shape (3,), ECI."""
    r_m = np.array(orbit.position_km) * 1e3
    v_m_s = np.array(orbit.velocity_km_s) * 1e3
    at_epoch = Instants(orbit.epoch, np.zeros(1))
    [r_eci_m], [v_eci_m_s] = eci_from_frame_state(orbit.frame, r_m[None], v_m_s[None], at_epoch)
    return r_eci_m, v_eci_m_s


def _propagate_on(
    orbit: StateVectorOrbit, before: list[CollocationSegment], start_s: float, stop_s: float
) -> CollocationSegment:
    """Propagate from where the segments `before` it end, or from the epoch, either way."""
    r_m, v_m_s = _state_eci(orbit)
    if before:
        r_m, v_m_s = (end[0] for end in before[-1].at(np.array([start_s])))
    nodes = Instants(orbit.epoch, node_times_s(start_s, stop_s))
    forces = forces_at(nodes, orbit.ballistic_m2_kg)
    segment = propagate_segment(r_m, v_m_s, start_s, stop_s, forces.acceleration_eci_m_s2)
    if segment is not None:
        (r_m,), _ = segment.at(np.array([stop_s]))
    if segment is None or np.linalg.norm(r_m) < _PERIGEE_MIN_M:
        at_utc = shifted_utc(orbit.epoch, start_s)
        raise OutsideCoverage(
            f"the satellite falls below {HEIGHT_MIN_M / 1e3:.0f} km soon after "
            f"{utc_text(at_utc, 0)}; end the plan before, or check orbit.mass_kg and "
            "orbit.drag_area_m2",
            field="orbit",
            at_utc=at_utc,
        )
    return segment
