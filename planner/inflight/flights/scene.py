"""A session of a plan as it may really be: where its target stands under given errors."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.commands import ROWS_PER_S, CommandTable
from planner.base.errors import InvalidInput
from planner.base.rotation import Rotation
from planner.inflight.flights.draws import Draw
from planner.inflight.flights.errors import SessionErrors, session_errors
from planner.inflight.flights.frames import exposures_s
from planner.planning.sessions.track_branches import RowSpan, session_rows
from planner.planning.sessions.uncertainty import CLOCK_S
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.plan import FlightPlan
from planner.world.scenario import Scenario
from planner.world.targets import VisibleTarget

NODE_S = 1.0  # between directions that are found; in between they are interpolated
POINTS = 6  # by a polynomial through so many: good to 3e-5 arcsec on a 400 km pass
LEAD_S = 10.0  # flown before a session, for the drives to be at work when it begins


class SeenTarget(NamedTuple):
    """A target as the base sees it: at n nodes by the platform's clock.

    nodes_s: (n,).  los_platform: unit vectors, (n, 3).  range_m: (n,).
    """

    nodes_s: Array
    los_platform: Array
    range_m: Array

    def directions_platform(self, at_s: Array) -> Array:
        """Unit vectors at k instants, in whatever shape they come, (k, 3)."""
        return between(self.nodes_s, self.los_platform, at_s.ravel())

    def ranges_m(self, at_s: Array) -> Array:
        """Distances at instants (k,)."""
        return np.interp(at_s, self.nodes_s, self.range_m)


@dataclass(frozen=True, kw_only=True, eq=False)
class SessionScene:
    """One session whose target can be seen.

    number: among the plan's sessions.  table: its rows and those of `LEAD_S` before it, whose
    first is `from_s` after the epoch of the plan's table, from which all times here are counted.
    at_s: (n, p), instants of each exposure, by the platform's clock.
    instants: of the nodes, uniformly spaced, by UTC.  states: of the orbit then.
    errors: how large they may be, at the nodes.
    """

    number: int
    scenario: Scenario
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

    def commanded_rad(self, at_s: Array) -> Array:
        """What the table has the axes do then, (k, 2): linear between rows."""
        rows_s = self.from_s + self.table.t_s
        return np.stack([np.interp(at_s, rows_s, column) for column in self.table.angle_rad.T], 1)

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
        q_body_from_eci = self.scenario.attitude.q_body_from_eci(
            Instants(epoch_utc, np.tile(t_s, count)), states
        )
        turned = np.concatenate([self.errors.turned_body_rad(draw) for draw in draws])
        q_platform_from_eci = (
            self.scenario.platform.q_platform_from_body
            * Rotation.from_rotvec(-turned)
            * q_body_from_eci
        )
        nodes = q_platform_from_eci.apply(seen.direction_eci).reshape(count, len(t_s), 3)
        ranges_m = seen.range_m.reshape(count, len(t_s))
        # What the platform does at a time by its own clock it does so much later by UTC.
        return [
            SeenTarget(t_s - draw.clock_score * CLOCK_S, node, range_m)
            for draw, node, range_m in zip(draws, nodes, ranges_m, strict=True)
        ]


def session_scenes(plan: FlightPlan) -> list[SessionScene]:
    """Of the sessions that look at a target; raises InvalidInput where none does."""
    scenario, table = plan.scenario, plan.table
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
    first_row = [max(rows.start - round(LEAD_S * ROWS_PER_S), 0) for *_, rows in seen]
    ephemerides = [scenario.orbit.ephemeris(at.utc(0), at.utc(-1)) for at in instants]
    states = [ephemeris.states(at) for ephemeris, at in zip(ephemerides, instants, strict=True)]
    errors = session_errors(ephemerides, scenario.attitude, instants, states)
    return [
        SessionScene(
            number=number,
            scenario=scenario,
            target=target,
            table=_rows_from(table, first_row[which], rows.stop),
            from_s=first_row[which] / ROWS_PER_S,
            at_s=exposures_s(
                scenario.platform.camera, rows.start / ROWS_PER_S, rows.stop / ROWS_PER_S
            ),
            instants=instants[which],
            ephemeris=ephemerides[which],
            states=states[which],
            errors=errors[which],
        )
        for which, (number, _, target, rows) in enumerate(seen)
    ]


def _nodes(table: CommandTable, rows: RowSpan) -> Instants:
    start_s, stop_s = rows.start / ROWS_PER_S, rows.stop / ROWS_PER_S
    count = max(int(np.ceil((stop_s - start_s) / NODE_S)) + 1, POINTS)
    return Instants(table.epoch_utc, np.linspace(start_s, stop_s, count))


def _rows_from(table: CommandTable, first: int, last: int) -> CommandTable:
    return CommandTable(
        epoch_utc=shifted_utc(table.epoch_utc, first / ROWS_PER_S),
        axis_names=table.axis_names,
        angle_rad=table.angle_rad[first : last + 1],
        rate_rad_s=table.rate_rad_s[first : last + 1],
    )


def between(nodes_s: Array, directions_platform: Array, t_s: Array) -> Array:
    """Unit vectors (n, 3) at uniform nodes (n,), by polynomials through the six nearest: (k, 3).

    A little beyond the ends the last polynomial is extrapolated.
    Source: Berrut and Trefethen 2004, Barycentric Lagrange interpolation, eq. 4.2.
    """
    step_s = (nodes_s[-1] - nodes_s[0]) / (len(nodes_s) - 1)
    at = (t_s - nodes_s[0]) / step_s
    first = np.clip(np.floor(at).astype(np.intp) - POINTS // 2 + 1, 0, len(nodes_s) - POINTS)
    apart = (at - first)[:, None] - np.arange(POINTS)
    weights = np.array([1.0, -5.0, 10.0, -10.0, 5.0, -1.0])
    on_node = apart == 0.0
    shares = weights / np.where(on_node, 1.0, apart)
    shares = np.where(on_node.any(axis=1, keepdims=True), on_node, shares)
    shares /= shares.sum(axis=1, keepdims=True)
    found = sum(shares[:, [k]] * directions_platform[first + k] for k in range(POINTS))
    return np.asarray(found / np.linalg.norm(found, axis=1, keepdims=True))
