"""A session of a plan as it may really be: where its target stands under given errors."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, cross
from planner.base.commands import ROWS_PER_S, CommandTable
from planner.base.errors import InvalidInput
from planner.base.interpolation import NODES, UniformTable
from planner.base.table_motion import motion_at
from planner.inflight.flights.draws import Draw
from planner.inflight.flights.frames import exposures_s
from planner.inflight.simulation.platforms.flyer import FlownTable, Flyer
from planner.inflight.simulation.platforms.registry import flyer_of
from planner.planning.sessions.platforms.mover import RowSpan
from planner.planning.sessions.track_branches import session_rows
from planner.planning.sessions.uncertainty import OPTIONS as BUDGET_OPTIONS
from planner.planning.sessions.uncertainty import ut1_sigma_s
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.orbits.accuracy import NormalMixture
from planner.world.plan import FlightPlan
from planner.world.scenario import Scenario
from planner.world.targets import GroundPathTarget, VisibleTarget

# Errors of a plan's sessions: the causes of its pointing budget and their sizes.

ATTITUDE_INSTANTS = (3, 11)  # of a session: as the budget, fewer where there are many sessions
_INSTANTS = 330  # of all of them: the attitude's joint covariance takes their number cubed


@dataclass(frozen=True, kw_only=True, eq=False)
class SessionErrors:
    """1-sigma errors over one session, at n instants.

    orbit_m: (n, 3), radial, along and across the track, the second times scores of `along`.
    attitude_body_rad: (m, n, 3), independent turns.  swing_body_rad: (3,), rms; its phase grows by
    swing_phase_rad (n,), from the plan's first session on.  ut1_s: of the Earth's turning.
    """

    orbit_m: Array
    along: NormalMixture
    attitude_body_rad: Array
    swing_body_rad: Array
    swing_phase_rad: Array
    ut1_s: float

    def moved(self, states: OrbitStates, draw: Draw) -> OrbitStates:
        """The orbit as flown: raised, turned ahead about its normal, and shifted across."""
        scores = draw.orbit_scores.copy()
        scores[1] = self.along.scores(scores[1])
        radial_m, along_m, cross_m = (self.orbit_m * scores).T
        r, v = states.r_sat_eci_m, states.v_sat_eci_m_s
        radius = np.linalg.norm(r, axis=1)
        normal = cross(r, v)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        turn = along_m / radius
        c, s = np.cos(turn)[:, None], np.sin(turn)[:, None]
        # Both square to the normal, so that the turn needs no third term.
        r_ahead, v_ahead = c * r + s * cross(normal, r), c * v + s * cross(normal, v)
        raised = (1.0 + radial_m / radius)[:, None]
        return OrbitStates(r_ahead * raised + cross_m[:, None] * normal, v_ahead)

    def turned_body_rad(self, draw: Draw) -> Array:
        """Rotation vectors from the planned body to the flown one, (n, 3)."""
        steady = np.einsum("m,mna->na", draw.attitude_scores, self.attitude_body_rad)
        swing = np.cos(self.swing_phase_rad[:, None] - draw.phase_rad)
        return np.asarray(steady + np.sqrt(2.0) * draw.swing_share * self.swing_body_rad * swing)


def session_errors(
    ephemerides: Sequence[Ephemeris],
    flyer: Flyer,
    instants: Sequence[Instants],
    states: Sequence[OrbitStates],
) -> list[SessionErrors]:
    """Of a plan's sessions together: a run's attitude is off in one as it is in the others.

    instants, states: of each session, on one epoch.
    """
    count = int(np.clip(_INSTANTS // len(instants), *ATTITUDE_INSTANTS))
    few_s = [np.linspace(at.t_s[0], at.t_s[-1], count) for at in instants]
    told = flyer.base_errors(Instants(instants[0].epoch_utc, np.concatenate(few_s)))
    modes = told.modes_body_rad
    if not len(modes):
        sigma = np.broadcast_to(told.sigma_body_rad, (len(few_s) * count, 3))
        modes = sigma * np.eye(3)[:, None, :]
    begin_s = float(instants[0].t_s[0])
    found = []
    for number, (ephemeris, at, flown) in enumerate(
        zip(ephemerides, instants, states, strict=True)
    ):
        mine = slice(number * count, (number + 1) * count)
        sigma_m = ephemeris.sigma(at)
        r_m, v_m_s = flown.r_sat_eci_m, flown.v_sat_eci_m_s
        rate_rad_s = np.linalg.norm(cross(r_m, v_m_s), axis=1) / np.sum(r_m**2, axis=1)
        found.append(
            SessionErrors(
                orbit_m=np.stack([sigma_m.radial_m, sigma_m.along_m, sigma_m.cross_m], axis=1),
                along=sigma_m.along,
                attitude_body_rad=_between(at.t_s, few_s[number], modes[:, mine]),
                swing_body_rad=told.swing_rms_body_rad,
                swing_phase_rad=rate_rad_s * (at.t_s - begin_s),
                ut1_s=ut1_sigma_s(at),
            )
        )
    return found


def _between(t_s: Array, few_s: Array, modes_rad: Array) -> Array:
    """Linear between a few instants: (m, k, 3) to (m, n, 3)."""
    by_mode = [
        np.stack([np.interp(t_s, few_s, mode_rad[:, axis]) for axis in range(3)], axis=1)
        for mode_rad in modes_rad
    ]
    return np.array(by_mode).reshape(-1, len(t_s), 3)


NODE_S = 1.0  # between directions that are found: interpolated to 3e-5 arcsec on a 400 km pass


class SeenTarget(NamedTuple):
    """A target as the base sees it: at n nodes by the platform's clock.

    nodes_s: (n,).  directions_base: unit vectors, (n, 3).  range_m: (n,).
    """

    nodes_s: Array
    directions_base: Array
    range_m: Array

    def directions_at(self, at_s: Array) -> Array:
        """Unit vectors at k instants, in whatever shape they come, (k, 3)."""
        step_s = float(self.nodes_s[-1] - self.nodes_s[0]) / (len(self.nodes_s) - 1)
        found = UniformTable(step_s, self.directions_base).at(at_s.ravel() - self.nodes_s[0])
        return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))

    def ranges_m(self, at_s: Array) -> Array:
        """Distances at instants (k,)."""
        return np.interp(at_s, self.nodes_s, self.range_m)


@dataclass(frozen=True, kw_only=True, eq=False)
class SessionScene:
    """One session whose target can be seen.

    number: among the plan's sessions.  flyer: of the scenario's platform.  table: the session's
    rows and those of the flyer's `lead_s` before it, whose first is `from_s` after the epoch of the
    plan's table, from which all times here are counted.
    at_s: (n, p), instants of each exposure, by the platform's clock.
    instants: of the nodes, uniformly spaced, by UTC.  states: of the orbit then.
    errors: how large they may be, at the nodes.
    """

    number: int
    scenario: Scenario
    flyer: Flyer
    target: VisibleTarget
    table: CommandTable
    from_s: float
    at_s: Array
    instants: Instants
    ephemeris: Ephemeris
    states: OrbitStates
    errors: SessionErrors

    @property
    def modes(self) -> int:
        """Of the attitude, as `draw_run` wants to know."""
        return len(self.errors.attitude_body_rad)

    def commanded(self, at_s: Array) -> Array:
        """The table's position then, (k, c): linear between rows."""
        rows_s = self.from_s + self.table.t_s
        return np.stack([np.interp(at_s, rows_s, column) for column in self.table.position.T], 1)

    def steadiness(self, motion: FlownTable) -> Array:
        """Of gyros in the session, as `worst_of` reads them, (k,)."""
        start_s, stop_s = (float(t_s) - self.from_s for t_s in self.instants.t_s[[0, -1]])
        return motion.steadiness(start_s, stop_s)

    def seen(self, draws: Sequence[Draw]) -> list[SeenTarget]:
        """Where the target stands under each of them, all at once: few cost what many do."""
        count = len(draws)
        epoch_utc, t_s = self.instants.epoch_utc, self.instants.t_s
        moved = [self.errors.moved(self.states, draw) for draw in draws]
        states = OrbitStates(
            np.concatenate([orbit.r_sat_eci_m for orbit in moved]),
            np.concatenate([orbit.v_sat_eci_m_s for orbit in moved]),
        )
        late_s = [draw.earth_score * self.errors.ut1_s for draw in draws]
        # The Earth turned on by so much is the Earth so much later.
        seen = self.target.apparent(Instants(epoch_utc, np.add.outer(late_s, t_s).ravel()), states)
        turned = np.concatenate([self.errors.turned_body_rad(draw) for draw in draws])
        at = Instants(epoch_utc, np.tile(t_s, count))
        q_base_from_eci = self.flyer.q_base_from_eci(at, states, turned)
        nodes = q_base_from_eci.apply(seen.direction_eci).reshape(count, len(t_s), 3)
        ranges_m = seen.range_m.reshape(count, len(t_s))
        # What the platform does at a time by its own clock it does so much later by UTC.
        return [
            SeenTarget(t_s - draw.clock_score * BUDGET_OPTIONS.clock_s, node, range_m)
            for draw, node, range_m in zip(draws, nodes, ranges_m, strict=True)
        ]


def session_scenes(plan: FlightPlan) -> list[SessionScene]:
    """Of the sessions that look at a target; raises InvalidInput where none does."""
    scenario, table, flyer = plan.scenario, plan.table, flyer_of(plan.scenario)
    seen = [
        (number, session, session.target, session_rows(session, table.epoch_utc))
        for number, session in enumerate(scenario.sessions)
        if isinstance(session.target, VisibleTarget)
    ]
    if not seen:
        raise InvalidInput(
            "the plan looks at no target that a frame could hold: its sessions are test motions; "
            "fly a plan of a target",
            field="sessions",
        )
    instants = [_nodes(table, rows) for *_, rows in seen]
    first_row = [max(rows.start - round(flyer.lead_s * ROWS_PER_S), 0) for *_, rows in seen]
    ephemerides = [scenario.orbit.ephemeris(at.utc(0), at.utc(-1)) for at in instants]
    states = [ephemeris.states(at) for ephemeris, at in zip(ephemerides, instants, strict=True)]
    errors = session_errors(ephemerides, flyer, instants, states)
    return [
        SessionScene(
            number=number,
            scenario=scenario,
            flyer=flyer,
            target=target,
            table=_rows_from(table, first_row[which], rows.stop),
            from_s=first_row[which] / ROWS_PER_S,
            at_s=exposures_s(
                scenario.platform.camera,
                rows.start / ROWS_PER_S,
                rows.stop / ROWS_PER_S,
                partial(_image_rad_s, scenario, flyer, table, ephemerides[which], target),
            ),
            instants=instants[which],
            ephemeris=ephemerides[which],
            states=states[which],
            errors=errors[which],
        )
        for which, (number, _, target, rows) in enumerate(seen)
    ]


def _image_rad_s(
    scenario: Scenario,
    flyer: Flyer,
    table: CommandTable,
    ephemeris: Ephemeris,
    target: VisibleTarget,
    t_s: Array,
) -> Array:
    """Rate of the ground's image along the payload's +X at n instants of the table, (n,).

    Of a path, which runs over the ground; 0 of all else, which the camera holds in one place.
    """
    if not isinstance(target, GroundPathTarget):
        return np.zeros_like(t_s)
    instants = Instants(table.epoch_utc, t_s)
    states = ephemeris.states(instants)
    before_m, after_m = (
        target.r_target_itrf_m(Instants(table.epoch_utc, t_s + off_s)) for off_s in (-0.05, 0.05)
    )
    v_itrf_m_s = (after_m - before_m) / 0.1
    v_eci_m_s = np.einsum("nji,nj->ni", c_itrf_from_eci(instants), v_itrf_m_s)
    v_base_m_s = flyer.q_base_from_eci(instants, states).apply(v_eci_m_s)
    q_payload_from_base = scenario.platform.q_payload_from_base(motion_at(table, t_s).position)
    along_m_s = q_payload_from_base.apply(v_base_m_s)[:, 0]
    return np.abs(along_m_s) / target.apparent(instants, states).range_m


def _nodes(table: CommandTable, rows: RowSpan) -> Instants:
    start_s, stop_s = rows.start / ROWS_PER_S, rows.stop / ROWS_PER_S
    count = max(int(np.ceil((stop_s - start_s) / NODE_S)) + 1, NODES)
    return Instants(table.epoch_utc, np.linspace(start_s, stop_s, count))


def _rows_from(table: CommandTable, first: int, last: int) -> CommandTable:
    return CommandTable(
        epoch_utc=shifted_utc(table.epoch_utc, first / ROWS_PER_S),
        channels=table.channels,
        position=table.position[first : last + 1],
        rate_rad_s=table.rate_rad_s[first : last + 1],
        acceleration_rad_s2=None
        if table.acceleration_rad_s2 is None
        else table.acceleration_rad_s2[first : last + 1],
        extra_rad=None if table.extra_rad is None else table.extra_rad[first : last + 1],
    )
