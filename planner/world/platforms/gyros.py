"""The gyros of a platform of kind body: their array, and the turns that they are asked for."""

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import VectorPart, Within, spec
from planner.world.frames.geodesy import MU_EARTH_M3_S2, WGS84_A_M
from planner.world.platforms.cmg_array import CmgArray

_Momentum = Annotated[float, Within(1e-6, 1e6)]
_Torque = Annotated[float, Within(1e-6, 1e6)]


@spec
class ScissoredPairs:
    """Four alike control moment gyros in two scissored pairs, whose gimbals lie along body x and y.

    type: scissored_pairs, the one array there is. Together they hold h (s3 + s4, s1 + s2,
    c1 + c2 + c3 + c4), of the sines and cosines of their gimbal angles.
    rotor_n_m_s: momentum h of each rotor. [N m s] E.g. `60.0`.
    gimbal_rate_max_deg_s: largest rate of each gimbal. E.g. `57.3`.
    """

    type: Literal["scissored_pairs"] = "scissored_pairs"
    rotor_n_m_s: _Momentum
    gimbal_rate_max_deg_s: Annotated[float, Within(1e-3, 1e4)]

    @property
    def cmg_array(self) -> CmgArray:
        """The same in radians, with its geometry."""
        return CmgArray(
            momentum_n_m_s=self.rotor_n_m_s,
            rate_max_rad_s=math.radians(self.gimbal_rate_max_deg_s),
        )


@spec
class GyroTurns:
    """The most that a planned turn asks of the gyros, and the rest after it.

    rate_max_deg_s: largest rate against GCRF about each body axis. E.g. `1.58`.
    torque_max_n_m: length of the largest torque on the body; at most half the momentum of a rotor
    times the largest gimbal rate, which the array has in every direction. E.g. `15.0`.
    torque_rate_max_n_m_s: length of the torque's largest derivative. E.g. `40.0`.
    momentum_max_n_m_s: length of the largest momentum in the gyros; at most that of one rotor,
    well away from where the array is singular. [N m s] E.g. `60.0`.
    settle_s: time on the target's track between a slew and the session, for the structure to
    calm down.
    """

    rate_max_deg_s: Annotated[float, Within(1e-4, 1e3)]
    torque_max_n_m: _Torque
    torque_rate_max_n_m_s: Annotated[float, Within(1e-6, 1e6)]
    momentum_max_n_m_s: _Momentum
    settle_s: Annotated[float, Within(0.0, 600.0)] = 0.0


@dataclass(frozen=True, kw_only=True, eq=False)
class GyroEnvelope:
    """The motion that gyros can always give: rates by body axis, the others within ellipsoids.

    by_order_rad: a row each of the largest rate about body x, y, z, and of the semi-axes along them
    of the ellipsoids that hold acceleration and jerk, rad and s, (3, 3).
    total_n_m_s: the most that body and gyros may hold together, for that to be so.
    """

    limits: ClassVar[Literal["gyros"]] = "gyros"
    by_order_rad: Array
    settle_s: float
    total_n_m_s: float


@spec
class GyroSet:
    """Control moment gyros that turn a body.

    array: the gyros and the way they lie in the body.
    turns: the most that a planned turn asks of them.
    start_n_m_s: momentum that they hold at the plan's beginning, in body axes. [N m s] E.g.
    `[0.0, 0.0, 0.0]`.
    """

    array: ScissoredPairs
    turns: GyroTurns
    start_n_m_s: tuple[VectorPart, VectorPart, VectorPart] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        array, turns = self.array.cmg_array, self.turns
        for name, asked, most in (
            ("torque_max_n_m", turns.torque_max_n_m, array.torque_n_m),
            ("momentum_max_n_m_s", turns.momentum_max_n_m_s, array.sphere_n_m_s),
        ):
            if asked > most:
                raise ValueError(
                    f"turns.{name} must be {most:.6g} or less, which array has in every "
                    f"direction, not {asked:g}"
                )

    def envelope(self, inertia_kg_m2: Array) -> GyroEnvelope:
        """What they can always give, whatever total momentum H the body and they hold together.

        H is at most what leaves the gyros within `momentum_max_n_m_s` at the largest rates about
        all three axes.  The torque is J alpha + omega x H less gravity's, its derivative J jerk +
        alpha x H - omega x (omega x H), of which the parts with H are taken at their largest, and
        gravity's torque at what it reaches on the ground.  |J x| is at most
        |D x|, where D^2 is diagonal with the sums of the sizes in the rows of J^2: of principal
        axes it is J.  inertia_kg_m2: (3, 3).
        """
        turns, d_kg_m2 = self.turns, np.sqrt(np.abs(inertia_kg_m2 @ inertia_kg_m2).sum(axis=1))
        rate_rad_s = math.radians(turns.rate_max_deg_s)
        turned_n_m_s = rate_rad_s * float(np.linalg.norm(d_kg_m2))
        total_n_m_s = turns.momentum_max_n_m_s - turned_n_m_s
        left_n_m_s = total_n_m_s - math.hypot(*self.start_n_m_s)
        if left_n_m_s < 0.0:
            raise ValueError(
                f"gyros.turns.rate_max_deg_s {turns.rate_max_deg_s:g} about all axes takes "
                f"{turned_n_m_s:.4g} N m s, {-left_n_m_s:.4g} more than "
                "gyros.turns.momentum_max_n_m_s leaves beside gyros.start_n_m_s: "
                "lower the rate, or unload the gyros first"
            )
        fastest_rad_s = math.sqrt(3.0) * rate_rad_s
        least_kg_m2, _, most_kg_m2 = np.linalg.eigvalsh(inertia_kg_m2)
        gravity_n_m = 1.5 * MU_EARTH_M3_S2 / WGS84_A_M**3 * (most_kg_m2 - least_kg_m2)
        torque_n_m = turns.torque_max_n_m - fastest_rad_s * total_n_m_s - gravity_n_m
        fastest_rad_s2 = torque_n_m / float(d_kg_m2.min())
        torque_rate_n_m_s = (
            turns.torque_rate_max_n_m_s - (fastest_rad_s2 + fastest_rad_s**2) * total_n_m_s
        )
        if not min(torque_n_m, torque_rate_n_m_s) > 0.0:
            raise ValueError(
                f"gyros.turns.rate_max_deg_s {turns.rate_max_deg_s:g} turns the momentum held so "
                "fast that no torque is left for a turn: lower it, or gyros.turns."
                "momentum_max_n_m_s, or raise gyros.turns.torque_max_n_m and torque_rate_max_n_m_s"
            )
        by_order = [np.full(3, rate_rad_s), torque_n_m / d_kg_m2, torque_rate_n_m_s / d_kg_m2]
        return GyroEnvelope(
            by_order_rad=np.stack(by_order), settle_s=turns.settle_s, total_n_m_s=total_n_m_s
        )
