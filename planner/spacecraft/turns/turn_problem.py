"""What is a turn?  From one moving attitude to another, within limits of rate, torque, momentum."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.spatial.transform import Rotation

from planner.arrays import Array
from planner.spacecraft.mrp import BodyMotion, body_motion, mrp_rates, relative_mrp
from planner.spacecraft.vehicle.definition import SlewLimits

Method = Literal["ocp", "eigenaxis"]
LIMIT_TOLERANCE = 1e-3  # relative: how far a limit may be exceeded between collocation points


@dataclass(frozen=True, kw_only=True)
class EndState:
    """Attitude (eci_from_body) and body rates (3,) at one end of a turn."""

    attitude: Rotation
    omega_body_rad_s: Array
    alpha_body_rad_s2: Array


@dataclass(frozen=True, kw_only=True)
class TurnProblem:
    """start -> end; end holds at arrival, whenever that is.

    momentum_eci_n_m_s: total angular momentum of body and gyros, (3,), constant over the turn
    (gravity gradient: under 0.03 N m s in 30 s).  inertia: (3,), principal, kg m^2.
    """

    start: EndState
    end: EndState
    momentum_eci_n_m_s: Array
    inertia_kg_m2: Array
    limits: SlewLimits

    def middle(self) -> Rotation:
        """The attitude halfway about the Euler axis: sigma is counted from it."""
        across = (self.start.attitude.inv() * self.end.attitude).as_rotvec()
        return self.start.attitude * Rotation.from_rotvec(0.5 * across)

    def ends_mrp(self) -> tuple[Array, ...]:
        """sigma and its two time derivatives at start and end, six arrays (3,)."""
        middle = self.middle()
        result: list[Array] = []
        for end in (self.start, self.end):
            sigma = relative_mrp(middle, end.attitude)
            result += [sigma, *mrp_rates(sigma, end.omega_body_rad_s, end.alpha_body_rad_s2)]
        return tuple(result)

    def from_rest_to_rest(self) -> "TurnProblem":
        """The same turn between ends that stand still."""
        still = np.zeros(3)
        start, end = (
            EndState(attitude=e.attitude, omega_body_rad_s=still, alpha_body_rad_s2=still)
            for e in (self.start, self.end)
        )
        return replace(self, start=start, end=end)

    def ends_momentum_n_m_s(self) -> float:
        """The most the gyros hold at start and end."""
        held = [
            end.attitude.inv().apply(self.momentum_eci_n_m_s)
            - self.inertia_kg_m2 * end.omega_body_rad_s
            for end in (self.start, self.end)
        ]
        return float(np.max(np.linalg.norm(held, axis=1)))

    def angle_rad(self) -> float:
        """Angle of the rotation start -> end."""
        return float((self.start.attitude.inv() * self.end.attitude).magnitude())


@dataclass(frozen=True, kw_only=True)
class Loads:
    """Largest magnitudes along a turn: rate, rate per axis (3,), control torque and its rate,
    momentum of the gyros; SI."""

    rate_rad_s: float
    rate_axis_rad_s: Array
    torque_n_m: float
    torque_rate_n_m_s: float
    momentum_n_m_s: float

    def share_of(self, limits: SlewLimits) -> float:
        """The most used limit, 1 = fully used."""
        return max(
            self.rate_rad_s / limits.rate_rad_s,
            float(np.max(self.rate_axis_rad_s)) / limits.rate_axis_rad_s,
            self.torque_n_m / limits.torque_n_m,
            self.torque_rate_n_m_s / limits.torque_rate_n_m_s,
            self.momentum_n_m_s / limits.momentum_sphere_n_m_s,
        )


@dataclass(frozen=True, kw_only=True)
class Turn:
    """A planned turn; sigma(t) with three time derivatives from `middle`, t from 0 to duration_s.

    method: what made it (an OCP that can't beat the eigenaxis falls back to it).
    """

    middle: Rotation
    sigma: Callable[[Array], tuple[Array, Array, Array, Array]]
    duration_s: float
    method: Method
    status: str
    solve_s: float
    loads: Loads

    def at(self, t_s: Array) -> tuple[Rotation, BodyMotion]:
        """eci_from_body and body rates at instants (m,)."""
        curve = self.sigma(np.asarray(t_s))
        return self.middle * Rotation.from_mrp(curve[0]), body_motion(*curve)


def loads(
    problem: TurnProblem,
    sigma: Callable[[Array], tuple[Array, Array, Array, Array]],
    duration_s: float,
    samples: int = 400,
) -> Loads:
    """Largest loads over a dense sampling of the turn.

    Control torque is J alpha + omega x (total momentum in body axes): what the gyros give.
    """
    curve = sigma(np.linspace(0.0, duration_s, samples))
    motion = body_motion(*curve)
    j = problem.inertia_kg_m2
    omega, alpha = motion.omega_body_rad_s, motion.alpha_body_rad_s2
    total = (problem.middle() * Rotation.from_mrp(curve[0])).inv().apply(problem.momentum_eci_n_m_s)
    torque = j * alpha + np.cross(omega, total)
    torque_rate = (
        j * motion.jerk_body_rad_s3
        + np.cross(alpha, total)
        - np.cross(omega, np.cross(omega, total))
    )

    def largest(v: Array) -> float:
        return float(np.max(np.linalg.norm(v, axis=1)))

    return Loads(
        rate_rad_s=largest(omega),
        rate_axis_rad_s=np.max(np.abs(omega), axis=0),
        torque_n_m=largest(torque),
        torque_rate_n_m_s=largest(torque_rate),
        momentum_n_m_s=largest(total - j * omega),
    )
