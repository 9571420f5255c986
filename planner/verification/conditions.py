"""Conditions of light and view by the judge: its own Earth, Sun, Moon and formulas."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.verification.directions import apart_rad
from planner.verification.earth import earth_orientation
from planner.verification.earth_fixed import EarthFixedSight
from planner.verification.report import ConditionMargin, Finding
from planner.verification.session import TableSession
from planner.verification.sky import SkySight, sky_sight
from planner.verification.surroundings import Surroundings
from planner.world.conditions import ConditionBound, ConditionName
from planner.world.orbits import OrbitStates
from planner.world.targets import BodyTarget
from planner.world.targets.body import HIDDEN_RAD


@dataclass(frozen=True, kw_only=True)
class JudgedConditionOptions:
    """What the judge lets pass, and the Earth's turn, by which a place on the ground moves."""

    tolerance: float = 1e-4  # deg or m: between two rows the fastest bends by a tenth of it
    earth_turn_rad_s: float = 7.292115e-5  # GRS 80


OPTIONS = JudgedConditionOptions()


def condition_margins(
    flight: TableSession, states: OrbitStates, sight: EarthFixedSight | SkySight
) -> tuple[ConditionMargin, ...]:
    """The least margin of each condition of the request over a session, at its n instants."""
    scenario = flight.scenario
    target = scenario.sessions[flight.number].target
    view = _View(flight, states, sight)
    return tuple(
        _least(flight, bound, *(view.kept(bound) if bound.kept else view.value(bound.name)))
        for bound in scenario.conditions.bounds
        if bound.applies_to(target)
    )


def condition_findings(
    flight: TableSession, margins: tuple[ConditionMargin, ...]
) -> Iterator[Finding]:
    """One error for each condition that isn't met."""
    bounds = {bound.field: bound for bound in flight.scenario.conditions.bounds}
    for margin in margins:
        if not margin.margin >= -OPTIONS.tolerance:
            bound = bounds[margin.name]
            yield Finding(
                limit=bound.name,
                t_s=margin.t_s,
                at_utc=margin.at_utc,
                detail=f"session {flight.number + 1}: {bound.unmet_because(margin.extreme)}",
            )


def _least(
    flight: TableSession, bound: ConditionBound, value: Array, anyway_margin: Array
) -> ConditionMargin:
    """value: (n,), in deg or m.  anyway_margin: (n,), the margin that it has whatever its value."""
    margin = np.maximum(bound.margin(value), anyway_margin)
    worst = int(np.argmin(margin))
    return ConditionMargin(
        name=bound.field,
        unit="m" if bound.unit == "m" else "deg",
        limit=bound.limit,
        extreme=float(value[worst]),
        margin=float(margin[worst]),
        t_s=float(flight.t_s[worst]),
        at_utc=flight.utc(worst),
    )


class _View:
    """What the carrier, and the target, see of the sky over one session."""

    def __init__(
        self, flight: TableSession, states: OrbitStates, sight: EarthFixedSight | SkySight
    ) -> None:
        self._instants, self._states, self._sight = flight.at.instants, states, sight
        self._pixel_rad = flight.scenario.platform.camera.pixel_rad
        self._flight = flight

    def kept(self, bound: ConditionBound) -> tuple[Array, Array]:
        """As `value`, of a direction of the body or the carrier, or of the boresight, as flown."""
        kept, at, judge = bound.kept, self._flight.at, self._flight.judge
        assert kept is not None  # who asks has one
        if kept.direction_body is None:
            direction_eci = judge.boresight_eci(at, self._states)
        else:
            platform, unit = self._flight.scenario.platform, np.asarray(kept.direction_body)
            on_base = platform.q_base_from_carrier.apply(unit / np.linalg.norm(unit))
            direction_eci = judge.direction_eci(on_base, at, self._states)
        around = Surroundings(self._instants, self._states)
        margin = np.rad2deg(around.margin_rad(kept, direction_eci))
        is_there = np.isfinite(margin)
        value = bound.limit + np.where(is_there, margin if bound.is_least else -margin, 0.0)
        return value, np.where(is_there, -math.inf, 180.0)  # nothing to keep away from

    def value(self, name: ConditionName) -> tuple[Array, Array]:
        """In deg or m, and the margin that it has anyway, (n,) each."""
        lowest_margin = np.full(len(self._instants.t_s), -math.inf)
        if name in ("sun_keep_out", "moon_keep_out"):
            body = self._body("sun" if name == "sun_keep_out" else "moon", self._states)
            away_rad = apart_rad(self._sight.apparent_eci, body.apparent_eci)
            return np.rad2deg(away_rad), np.rad2deg(-HIDDEN_RAD - body.clearance_rad)
        if name == "carrier_light":
            return np.rad2deg(self._body("sun", self._states).clearance_rad), lowest_margin
        if name == "off_nadir":
            r_m = self._states.r_sat_eci_m
            nadir_eci = -r_m / np.linalg.norm(r_m, axis=1, keepdims=True)
            return np.rad2deg(apart_rad(self._sight.apparent_eci, nadir_eci)), lowest_margin
        if isinstance(self._sight, SkySight):
            return np.rad2deg(self._sight.clearance_rad), lowest_margin
        if name == "elevation":
            return np.rad2deg(self._sight.elevation_rad), lowest_margin
        if name == "ground_sample":
            sine = np.sin(np.maximum(self._sight.elevation_rad, 1e-9))
            return self._sight.range_m * self._pixel_rad / sine, lowest_margin
        return self._sunlight(name, self._sight, lowest_margin)

    def _sunlight(
        self, name: ConditionName, sight: EarthFixedSight, lowest_margin: Array
    ) -> tuple[Array, Array]:
        """At the target: of the Sun's elevation, or of its mirror image from the carrier's place.

        Source of the latter's: Cox and Munk 1954, as MODIS has it, by zenith distances and the
        azimuth between Sun and carrier.
        """
        to_sat_m = sight.to_sat_eci_m
        r_m = self._states.r_sat_eci_m - to_sat_m
        earth = earth_orientation(self._instants.epoch_utc, self._instants.t_s)
        pole = earth.eci_from_itrf(np.broadcast_to([0.0, 0.0, 1.0], r_m.shape))
        v_m_s = OPTIONS.earth_turn_rad_s * np.cross(pole, r_m)
        sun = self._body("sun", OrbitStates(r_m, v_m_s)).apparent_eci
        up = sight.up_eci
        sun_zenith_rad = apart_rad(sun, up)
        sun_deg = 90.0 - np.rad2deg(sun_zenith_rad)
        if name == "sun_elevation":
            return sun_deg, lowest_margin
        to_sat = to_sat_m / np.linalg.norm(to_sat_m, axis=1, keepdims=True)
        zenith_rad = apart_rad(to_sat, up)
        level = [one - np.sum(one * up, axis=1, keepdims=True) * up for one in (sun, to_sat)]
        along = np.sum(level[0] * level[1], axis=1)  # the sines' product times the azimuth's cosine
        cosine = np.cos(sun_zenith_rad) * np.cos(zenith_rad) - along
        return np.rad2deg(np.arccos(np.clip(cosine, -1.0, 1.0))), -sun_deg

    def _body(self, name: str, states: OrbitStates) -> SkySight:
        target = BodyTarget(name=name, grazing_altitude_km=0.0)
        return sky_sight(target, self._instants, states)
