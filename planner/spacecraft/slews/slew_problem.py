"""A slew from one moving attitude to another within limits of rate, torque and momentum."""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.mrp import BodyMotion, MrpCurve, MrpMotion, MrpState, body_motion, mrp_state
from planner.base.rotation import Rotation
from planner.spacecraft.vehicle.definition import SlewLimits

Method = Literal["ocp", "eigenaxis"]
LIMIT_TOLERANCE = 1e-3  # relative: how far a limit may be exceeded between collocation points


@dataclass(frozen=True, kw_only=True)
class EndState:
    """Attitude and body rates (3,) at one end of a slew."""

    q_body_from_eci: Rotation
    omega_body_rad_s: Array
    alpha_body_rad_s2: Array

    @classmethod
    def at_rest(cls, q_body_from_eci: Rotation) -> "EndState":
        """Not turning."""
        return cls(
            q_body_from_eci=q_body_from_eci,
            omega_body_rad_s=np.zeros(3),
            alpha_body_rad_s2=np.zeros(3),
        )


@dataclass(frozen=True, kw_only=True)
class AttitudeSlewProblem:
    """start -> end; end holds at arrival, whenever that is.

    momentum_eci_n_m_s: total angular momentum of body and gyros, (3,), constant over the slew
    (gravity gradient: under 0.03 N m s in 30 s).  inertia_kg_m2: (3,), principal.
    """

    start: EndState
    end: EndState
    momentum_eci_n_m_s: Array
    inertia_kg_m2: Array
    limits: SlewLimits

    @property
    def q_start_from_end(self) -> Rotation:
        """The rotation of the whole slew, from body axes at its end."""
        return self.start.q_body_from_eci * self.end.q_body_from_eci.inv()

    @property
    def q_middle_from_eci(self) -> Rotation:
        """The attitude halfway about the Euler axis: sigma is counted from it."""
        half_rad = 0.5 * self.q_start_from_end.as_rotvec()
        return Rotation.from_rotvec(-half_rad) * self.start.q_body_from_eci

    def ends_mrp(self) -> tuple[MrpState, MrpState]:
        """sigma and its two time derivatives at start and end, (3,) each."""
        q_middle_from_eci = self.q_middle_from_eci

        def at(end: EndState) -> MrpState:
            mrp = np.asarray((q_middle_from_eci * end.q_body_from_eci.inv()).as_mrp())
            return mrp_state(mrp, end.omega_body_rad_s, end.alpha_body_rad_s2)

        return at(self.start), at(self.end)

    def from_rest_to_rest(self) -> "AttitudeSlewProblem":
        """The slew between ends that stand still."""
        start, end = self.start.q_body_from_eci, self.end.q_body_from_eci
        return replace(self, start=EndState.at_rest(start), end=EndState.at_rest(end))

    def ends_momentum_n_m_s(self) -> float:
        """The most the gyros hold at start and end."""
        held_n_m_s = [
            end.q_body_from_eci.apply(self.momentum_eci_n_m_s)
            - self.inertia_kg_m2 * end.omega_body_rad_s
            for end in (self.start, self.end)
        ]
        return float(np.max(np.linalg.norm(held_n_m_s, axis=1)))

    def angle_rad(self) -> float:
        """Angle of the rotation start -> end."""
        return float(self.q_start_from_end.magnitude())


@dataclass(frozen=True, kw_only=True)
class Loads:
    """Largest magnitudes along a slew: rate, rate per axis (3,), control torque and its rate,
    momentum of the gyros."""

    rate_rad_s: float
    rate_axis_rad_s: Array
    torque_n_m: float
    torque_rate_n_m_s: float
    momentum_n_m_s: float

    def share_of(self, limits: SlewLimits, *, torque_rate: bool = True) -> float:
        """The most used limit, 1 = fully used; with or without that of the torque rate."""
        return max(
            self.rate_rad_s / limits.rate_rad_s,
            float(np.max(self.rate_axis_rad_s)) / limits.rate_axis_rad_s,
            self.torque_n_m / limits.torque_n_m,
            self.torque_rate_n_m_s / limits.torque_rate_n_m_s if torque_rate else 0.0,
            self.momentum_n_m_s / limits.momentum_sphere_n_m_s,
        )


@dataclass(frozen=True, kw_only=True)
class AttitudeSlew:
    """A planned slew; sigma from `q_middle_from_eci`, t from 0 to duration_s.

    method: what made it (an OCP that can't beat the eigenaxis falls back to it).  time_from: what
    found the quickest slew, whose time its duration was taken from, None where that was given.
    """

    q_middle_from_eci: Rotation
    mrp_at: MrpCurve
    duration_s: float
    method: Method
    status: str
    solve_s: float
    loads: Loads
    time_from: Method | None = None

    def attitude_at(self, t_s: Array) -> tuple[Rotation, BodyMotion]:
        """q_body_from_eci and body rates at instants (m,)."""
        return _attitude_motion(self.q_middle_from_eci, self.mrp_at(np.asarray(t_s)))


def _attitude_motion(q_middle_from_eci: Rotation, motion: MrpMotion) -> tuple[Rotation, BodyMotion]:
    return Rotation.from_mrp(motion.mrp).inv() * q_middle_from_eci, body_motion(motion)


def loads(
    problem: AttitudeSlewProblem, mrp_at: MrpCurve, duration_s: float, samples: int = 400
) -> Loads:
    """Largest loads over a dense sampling of the slew.

    Control torque is J alpha + omega x (total momentum in body axes): what the gyros give.
    """
    motion = mrp_at(np.linspace(0.0, duration_s, samples))
    q_body_from_eci, (omega, alpha, jerk) = _attitude_motion(problem.q_middle_from_eci, motion)
    j = problem.inertia_kg_m2
    total_n_m_s = q_body_from_eci.apply(problem.momentum_eci_n_m_s)
    precession_n_m = np.cross(omega, total_n_m_s)
    torque_n_m = j * alpha + precession_n_m
    torque_rate_n_m_s = j * jerk + np.cross(alpha, total_n_m_s) - np.cross(omega, precession_n_m)
    return Loads(
        rate_rad_s=_largest_norm(omega),
        rate_axis_rad_s=np.max(np.abs(omega), axis=0),
        torque_n_m=_largest_norm(torque_n_m),
        torque_rate_n_m_s=_largest_norm(torque_rate_n_m_s),
        momentum_n_m_s=_largest_norm(total_n_m_s - j * omega),
    )


def _largest_norm(v: Array) -> float:
    return float(np.max(np.linalg.norm(v, axis=1)))
