"""The carrier, its boresight and the Sun and Moon at the rows of a view."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from planner.base.arrays import Array, Indices, angle_rad
from planner.base.interpolation import NODES, UniformTable
from planner.base.rotation import Rotation
from planner.output.export.ground import BORESIGHT_PAYLOAD, Sights, frame_corner_rays, sights
from planner.output.export.table_states import TableStates, table_states
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.plan import FlightPlan
from planner.world.rules.keep_out import KeepOut
from planner.world.targets.apparent import aberrate

Body = Literal["sun", "moon"]
BODY_STEP_S = 600.0


@dataclass(frozen=True, kw_only=True, eq=False)
class CarrierScene:
    """A carrier at n instants, with the Sun and the Moon."""

    instants: Instants
    states: OrbitStates

    @cached_property
    def c_itrf_from_eci(self) -> Array:
        """Shape (n, 3, 3)."""
        return c_itrf_from_eci(self.instants)

    @cached_property
    def r_sat_itrf_m(self) -> Array:
        """Shape (n, 3)."""
        return self.in_itrf(self.states.r_sat_eci_m)

    @cached_property
    def r_sun_eci_m(self) -> Array:
        """From the geocentre, light time and annual aberration included, (n, 3)."""
        return self._apparent_geocentric_m("sun")

    @cached_property
    def r_moon_eci_m(self) -> Array:
        """From the geocentre, light time and annual aberration included, (n, 3)."""
        return self._apparent_geocentric_m("moon")

    def r_body_eci_m(self, body: Body) -> Array:
        """From the geocentre, as seen there, (n, 3)."""
        return self.r_sun_eci_m if body == "sun" else self.r_moon_eci_m

    def separation_rad(self, direction_eci: Array, body: Body) -> Array:
        """Angle at the carrier between unit vectors (n, 3) and a body's centre, (n,)."""
        to_body_m = self.r_body_eci_m(body) - self.states.r_sat_eci_m
        direction = to_body_m / np.linalg.norm(to_body_m, axis=1, keepdims=True)
        return angle_rad(direction_eci, aberrate(direction, self.states.v_sat_eci_m_s))

    def off_nadir_rad(self, direction_eci: Array) -> Array:
        """Angle of unit vectors (n, 3) from the geocentre's direction, (n,)."""
        return angle_rad(direction_eci, -self.states.r_sat_eci_m)

    def in_itrf(self, vector_eci: Array) -> Array:
        """Vectors (n, 3) in ITRF axes."""
        return np.asarray(np.einsum("nij,nj->ni", self.c_itrf_from_eci, vector_eci))

    def _apparent_geocentric_m(self, body: Body) -> Array:
        """Interpolated between instants, to a few millimetres."""
        t_s = self.instants.t_s
        count = max(NODES, math.ceil((t_s[-1] - t_s[0]) / BODY_STEP_S) + 1)
        node_s, step_s = np.linspace(t_s[0], t_s[-1], count, retstep=True)
        from planner.planning.opportunities.carrier import apparent_geocentric_m  # loads kernels

        at_nodes_m = apparent_geocentric_m(body, Instants(self.instants.epoch_utc, node_s))
        return UniformTable(float(step_s) or 1.0, at_nodes_m).at(t_s - t_s[0])


@dataclass(frozen=True, kw_only=True, eq=False)
class PlanScene(CarrierScene):
    """n rows of a plan at which orbit and attitude are known."""

    plan: FlightPlan
    rows: TableStates

    @cached_property
    def sights(self) -> Sights:
        """Of the boresight, then of the frame's four corners."""
        corners = frame_corner_rays(self.plan.scenario.platform)
        return sights(self.rows, np.concatenate([BORESIGHT_PAYLOAD, corners]))

    @cached_property
    def boresight_eci(self) -> Array:
        """Where the payload looks, aberration included, unit vectors (n, 3)."""
        turn = Rotation.from_quat(self.rows.q_payload_from_eci_xyzw).inv()
        return np.asarray(turn.apply([0.0, 0.0, 1.0]))

    def keep_out_axis(self, cone: KeepOut) -> tuple[Array, Array]:
        """Of a cone in the base's axes, and by how much it counts; as `KeepOut.axis_base`."""
        return cone.axis_base(self.instants, self.states, self.q_base_from_eci)

    @cached_property
    def q_base_from_eci(self) -> Rotation:
        """Of what stands on a carrier, n rotations."""
        q_body_from_eci = Rotation.from_quat(self.rows.q_body_from_eci_xyzw)
        return self.plan.scenario.platform.q_base_from_carrier * q_body_from_eci


def scene_of(plan: FlightPlan, row: Indices) -> PlanScene:
    """At those of these rows, (n,), at which orbit and attitude are known."""
    rows = table_states(plan, row)
    return PlanScene(instants=rows.instants, states=rows.states, plan=plan, rows=rows)
