"""The carrier's states and the payload's attitude, row by row of a plan."""

from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.commands import ROWS_PER_S
from planner.base.errors import OutsideCoverage
from planner.base.rotation import Rotation, continuous
from planner.world.frames.time_scales import Instants, elapsed_s
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.plan import FlightPlan

_DEGREE = 5


@dataclass(frozen=True, kw_only=True, eq=False)
class TableStates:
    """Rows of the table, (n,), from `first_row` to its end, with orbit and attitude.

    first_row: 0, or the first tracking row where orbit or attitude is not known before.
    q_body_from_eci_xyzw, q_payload_from_eci_xyzw, q_payload_from_body_xyzw: shape (n, 4),
    unit, scalar last, neighbours of like sign; they turn coordinates.
    """

    first_row: int
    row: Indices
    instants: Instants
    ephemeris: Ephemeris
    states: OrbitStates
    q_body_from_eci_xyzw: Array
    q_payload_from_body_xyzw: Array
    q_payload_from_eci_xyzw: Array


def table_states(plan: FlightPlan, row: Indices | None = None) -> TableStates:
    """Of rows by their ascending numbers, (n,); of all unless given.

    Raises OutsideCoverage when orbit or attitude is unknown while a target is tracked.
    """
    row = np.arange(len(plan.table.t_s)) if row is None else row
    try:
        return _states_from(plan, row, 0)
    except OutsideCoverage:
        first_row = _first_tracking_row(plan)
        if first_row == 0:
            raise
        return _states_from(plan, row, first_row)


def _states_from(plan: FlightPlan, row: Indices, first_row: int) -> TableStates:
    scenario, table = plan.scenario, plan.table
    row = row[row >= first_row]
    instants = Instants(table.epoch_utc, table.t_s[row])
    ephemeris = scenario.orbit.ephemeris(instants.utc(0), instants.utc(-1))
    states = ephemeris.states(instants)
    position = table.position[row]
    q_body_from_eci = scenario.q_body_from_eci(instants, states, position)
    q_payload_from_body = scenario.platform.q_payload_from_body(position)
    return TableStates(
        first_row=first_row,
        row=row,
        instants=instants,
        ephemeris=ephemeris,
        states=states,
        q_body_from_eci_xyzw=continuous(q_body_from_eci),
        q_payload_from_body_xyzw=continuous(q_payload_from_body),
        q_payload_from_eci_xyzw=continuous(q_payload_from_body * q_body_from_eci),
    )


def omega_payload_from_eci_rad_s(plan: FlightPlan, rows: TableStates) -> Array:
    """Angular velocity of the payload against ECI, payload axes, shape (n, 3), of all rows.

    That of a carrier is the derivative of a quintic through the rows.
    """
    position, rate_rad_s = plan.table.position[rows.row], plan.table.rate_rad_s[rows.row]
    on_base_rad_s = plan.scenario.platform.omega_payload_rad_s(position, rate_rad_s)
    if plan.scenario.attitude is None:  # the base is GCRF
        return on_base_rad_s
    q_payload_from_body = Rotation.from_quat(rows.q_payload_from_body_xyzw)
    omega_body_rad_s = _omega_body_rad_s(rows.instants.t_s, rows.q_body_from_eci_xyzw)
    return np.asarray(q_payload_from_body.apply(omega_body_rad_s) + on_base_rad_s)


def axes_turn(q_b_from_a_xyzw: Array) -> Array:
    """What CCSDS and STK call the quaternion from A to B: it turns A's axes into B's.

    The conjugate, scalar last too: [0, 0, sin(theta/2), cos(theta/2)] for a body B turned by
    +theta about Z.
    """
    return np.asarray(q_b_from_a_xyzw * np.array([-1.0, -1.0, -1.0, 1.0]))


def _omega_body_rad_s(t_s: Array, q_body_from_eci_xyzw: Array) -> Array:
    """Angular velocity of the body against ECI, body axes: 2 conj(p) o p' of p = conj(q)."""
    from scipy.interpolate import make_interp_spline

    q_dot_s = make_interp_spline(
        t_s, q_body_from_eci_xyzw, k=min(_DEGREE, len(t_s) - 1)
    ).derivative()(t_s)
    vector, scalar = q_body_from_eci_xyzw[:, :3], q_body_from_eci_xyzw[:, 3:]
    vector_dot, scalar_dot = q_dot_s[:, :3], q_dot_s[:, 3:]
    return np.asarray(
        2.0 * (scalar_dot * vector - scalar * vector_dot - np.cross(vector, vector_dot))
    )


def _first_tracking_row(plan: FlightPlan) -> int:
    start_s = min(
        elapsed_s(segment.start_utc, plan.table.epoch_utc)
        for segment in plan.segments
        if segment.kind == "track"
    )
    return round(start_s * ROWS_PER_S)
