"""The carrier, its platform, the Sun and the Moon at any instant of some days.

One evaluation of the orbit and of the attitude law on a uniform grid serves all targets.
Everything is in ITRF axes, in which targets on the ground stand still.
"""

import math
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from typing import Protocol

import numpy as np

from planner.base.arrays import Array
from planner.base.interpolation import NODES, UniformTable
from planner.base.rotation import Rotation
from planner.planning.opportunities.looks import CarrierTables
from planner.planning.opportunities.sweep import OPTIONS as SWEEP
from planner.planning.opportunities.sweep import LeapRows
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import MU_EARTH_M3_S2
from planner.world.frames.local_orbital import c_lvlh_from_eci
from planner.world.frames.solar_system import earth_bary_state
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.targets import BodyTarget
from planner.world.targets.apparent import aberrate


@dataclass(frozen=True, kw_only=True)
class CarrierTableOptions:
    """How densely the carrier is tabulated."""

    step_turn_rad: float = 0.066  # of the carrier about the Earth between rows: 60 s in low orbit
    step_max_s: float = 900.0  # high orbits turn slowly, but their targets don't
    body_step_s: float = 900.0  # of the Sun and the Moon: 0.1 mas of the Earth's turn below them
    body_eci_step_s: float = 10_800.0  # of their own motion: the Moon's by 0.004 mas
    between_rows: float = 1.05  # times what it is on rows, a motion may be
    attitude_step_min_s: float = 1.0  # telemetry has a row a second
    attitude_error_rad: float = 5e-7  # 0.1 arcsec: less than what drives and orbit leave


OPTIONS = CarrierTableOptions()


class Base(Protocol):
    """What the angles that windows tell are counted in: a platform's mounting plate, say."""

    @property
    def rests_in_orbit(self) -> bool:
        """Whether it never turns in the local orbital frame."""
        ...

    def q_base_from_eci(self, instants: Instants, states: OrbitStates) -> Rotation:
        """n rotations, `states` being the orbit at the same n instants."""
        ...


@dataclass(frozen=True, eq=False)
class Carrier:
    """Tables over `span_s` seconds from `start_utc`, which all t_s count from.

    orbit: position, m, and inertial velocity, m/s, in ITRF axes, 6 columns.
    platform: its first two axes, unit vectors, ITRF axes, 6 columns.  platform_turn_max_rad_s: how
    fast it turns in ITRF at most.
    The rows smooth a manoeuvre over: by 0.2 m, or 0.03 ms of the motion, in an ISS reboost.
    """

    start_utc: datetime
    span_s: float
    orbit: UniformTable
    platform: UniformTable
    platform_turn_max_rad_s: float

    @cached_property
    def tables(self) -> CarrierTables:
        """The same for compiled code."""
        bodies = _bodies_table(self.start_utc, self.span_s)
        return self.tables_but_bodies._replace(body_step_s=bodies.step_s, bodies=bodies.powers)

    @cached_property
    def tables_but_bodies(self) -> CarrierTables:
        """Without the Sun and the Moon, which would take a tenth of a search for few targets: their
        places are NaN."""
        orbit, step_s = self.orbit.powers, self.orbit.step_s
        r_m, v_m_s = orbit[:, 0, :3], orbit[:, 1, :3] / step_s
        r2, rv, v2 = (
            np.einsum("ni,ni->n", a, b) for a, b in ((r_m, r_m), (r_m, v_m_s), (v_m_s, v_m_s))
        )
        acceleration_m_s2 = 2.0 / step_s**2 * float(np.linalg.norm(orbit[:, 2, :3], axis=1).max())
        passing_rad_s = math.sqrt(float(np.max(v2 / r2 - (rv / r2) ** 2)))
        return CarrierTables(
            span_s=self.span_s,
            step_s=step_s,
            orbit=orbit,
            body_step_s=math.inf,
            bodies=np.full((1, NODES, 6), math.nan),
            platform_step_s=self.platform.step_s,
            platform=self.platform.powers,
            turn_rad_s=self.platform_turn_max_rad_s,
            farthest_m=OPTIONS.between_rows * math.sqrt(float(r2.max())),
            speed_m_s=OPTIONS.between_rows * math.sqrt(float(v2.max())),
            acceleration_m_s2=OPTIONS.between_rows * acceleration_m_s2,
            passing_rad_s=OPTIONS.between_rows * passing_rad_s,
        )

    @cached_property
    def rows(self) -> LeapRows:
        """What tells how many rows of the orbit can be leapt over."""
        powers, last_s = self.orbit.powers, np.array([self.span_s])
        r_m = np.concatenate([powers[:, 0, :3], self.orbit.at(last_s)[:, :3]])
        v_m_s = np.concatenate(
            [powers[:, 1, :3] / self.orbit.step_s, self.orbit.rate_at(last_s)[:, :3]]
        )
        cosine = np.minimum((np.arange(2 * SWEEP.leaps + 2) + 1.0) / SWEEP.leaps - 1.0, 1.0)
        per_row_rad = self.tables_but_bodies.passing_rad_s * self.orbit.step_s
        nearness = 1.0 / np.linalg.norm(r_m, axis=1, keepdims=True)
        return LeapRows(
            np.concatenate([r_m, v_m_s, nearness], axis=1), np.arccos(cosine) / per_row_rad
        )

    def states(self, instants: Instants) -> OrbitStates:
        """Of the tables, at instants that count from the same start."""
        c_itrf = c_itrf_from_eci(instants)
        columns = self.orbit.at(instants.t_s).reshape(-1, 2, 3)
        r_m, v_m_s = np.einsum("nji,nmj->mni", c_itrf, columns)
        return OrbitStates(r_m, v_m_s)


def carrier_over(
    ephemeris: Ephemeris,
    base: Base,
    start_utc: datetime,
    stop_utc: datetime,
) -> Carrier:
    """Tabulate; raises OutsideCoverage where orbit, attitude or Sun and Moon are not known."""
    span_s = elapsed_s(stop_utc, start_utc)
    first_state = ephemeris.states(Instants(start_utc, np.zeros(1)))
    step_s = min(OPTIONS.step_turn_rad / _perigee_rate_rad_s(first_state), OPTIONS.step_max_s)
    cells = 2 * max(math.ceil(span_s / step_s / 2.0), NODES - 1)
    instants = Instants(start_utc, np.linspace(0.0, span_s, cells + 1))
    orbit_itrf = ephemeris.states_in_itrf_axes(instants)
    if base.rests_in_orbit:
        first = Instants(start_utc, np.zeros(1))
        c_lvlh = c_lvlh_from_eci(first_state.r_sat_eci_m, first_state.v_sat_eci_m_s)
        c_platform = base.q_base_from_eci(first, first_state).as_matrix() @ c_lvlh.swapaxes(1, 2)
        axes_itrf = c_platform @ c_lvlh_from_eci(*orbit_itrf)
    else:
        axes_itrf = _platform_axes(instants, ephemeris, base)
    step_s = span_s / (len(axes_itrf) - 1)
    turn_rad_s = np.linalg.norm(np.diff(axes_itrf, axis=0), axis=(1, 2)).max() / step_s
    return Carrier(
        start_utc=start_utc,
        span_s=span_s,
        orbit=UniformTable(span_s / cells, np.concatenate(orbit_itrf, axis=1)),
        platform=UniformTable(step_s, axes_itrf[:, :2].reshape(-1, 6)),
        platform_turn_max_rad_s=float(turn_rad_s) / math.sqrt(2.0),
    )


def _platform_axes(instants: Instants, ephemeris: Ephemeris, base: Base) -> Array:
    """In ITRF on rows as fine as needed: every other row must predict the rest, (n, 3, 3)."""
    while True:
        c_base = base.q_base_from_eci(instants, ephemeris.states(instants)).as_matrix()
        axes_itrf = c_base @ c_itrf_from_eci(instants).swapaxes(1, 2)
        step_s, rows = float(instants.t_s[1]), axes_itrf.reshape(-1, 9)
        off_rad = np.linalg.norm(
            UniformTable(2.0 * step_s, rows[::2]).at(instants.t_s) - rows, axis=1
        )
        if np.max(off_rad) <= OPTIONS.attitude_error_rad or step_s <= OPTIONS.attitude_step_min_s:
            return axes_itrf
        t_s = np.linspace(0.0, instants.t_s[-1], 2 * len(instants) - 1)
        instants = Instants(instants.epoch_utc, t_s)


def _perigee_rate_rad_s(states: OrbitStates) -> float:
    """Rate of the geocentric direction at the perigee of the osculating orbit."""
    r_m, v_m_s = states.r_sat_eci_m[0], states.v_sat_eci_m_s[0]
    h_m2_s = np.cross(r_m, v_m_s)
    eccentricity = np.cross(v_m_s, h_m2_s) / MU_EARTH_M3_S2 - r_m / np.linalg.norm(r_m)
    perigee_m = (h_m2_s @ h_m2_s) / MU_EARTH_M3_S2 / (1.0 + np.linalg.norm(eccentricity))
    return float(np.linalg.norm(h_m2_s) / perigee_m**2)


def _bodies_table(start_utc: datetime, span_s: float) -> UniformTable:
    """The Sun and the Moon from the geocentre, m, light time and annual aberration included, ITRF
    axes, 6 columns."""
    motion, turned = (
        _evenly(start_utc, span_s, step_s)
        for step_s in (OPTIONS.body_eci_step_s, OPTIONS.body_step_s)
    )
    r_eci_m = np.concatenate(
        [apparent_geocentric_m(body, motion) for body in ("sun", "moon")], axis=1
    )
    r_eci_m = _table_of(motion, r_eci_m).at(turned.t_s).reshape(-1, 2, 3)
    r_itrf_m = np.einsum("nij,nmj->nmi", c_itrf_from_eci(turned), r_eci_m)
    return _table_of(turned, r_itrf_m.reshape(-1, 6))


def _evenly(start_utc: datetime, span_s: float, step_s: float) -> Instants:
    """Over all of the span, by steps of at most so long."""
    cells = max(math.ceil(span_s / step_s), NODES - 1)
    return Instants(start_utc, np.linspace(0.0, span_s, cells + 1))


def _table_of(instants: Instants, value_by_row: Array) -> UniformTable:
    return UniformTable(float(instants.t_s[-1]) / (len(instants) - 1), value_by_row)


def apparent_geocentric_m(body: str, instants: Instants) -> Array:
    """Where the Earth's centre sees the Sun's or Moon's, GCRF axes, shape (n, 3)."""
    r_earth_bary_m, v_earth_bary_m_s = earth_bary_state(instants)
    direction, range_m = BodyTarget(name=body).seen_from(instants, r_earth_bary_m)
    return aberrate(direction, v_earth_bary_m_s) * range_m[:, None]
