"""The rules of a spacecraft that turns as a whole: rolls, its idle attitude, no carrier."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from planner.base.arrays import Array, told_deg
from planner.base.commands import CommandTable
from planner.base.errors import figures
from planner.base.rotation import Rotation
from planner.world.attitude import Attitude
from planner.world.platforms import AnyPlatform
from planner.world.platforms.body import AzimuthRoll, BodyPlatform, LinesAcrossMotion, RollRule
from planner.world.resources import Resources
from planner.world.targets import BenchMotionTarget, EarthFixedTarget, Target, VisibleTarget

if TYPE_CHECKING:
    from planner.world.scenario import InitialState, Quaternion, Scenario, SlewOptions


def says_roll(rule: RollRule, target: Target | VisibleTarget) -> bool:
    """Whether a rule says how the camera lies on a target: no lines across a motion that it doesn't
    have, no azimuth in the sky."""
    is_on_earth = isinstance(target, EarthFixedTarget)
    if isinstance(rule, LinesAcrossMotion):
        return is_on_earth and not target.rests_on_earth
    return is_on_earth or not isinstance(rule, AzimuthRoll)


def asked_of_axes(attitude: Attitude | None, slew: "SlewOptions") -> dict[str, bool]:
    """Whether a request gives what only two axes on a carrier have, by field."""
    return {
        "attitude": attitude is not None,
        "slew.method": slew.method != "ocp",
        "slew.jerk_max_deg_s3": slew.jerk_max_deg_s3 is not None,
        "slew.keep_out": bool(slew.keep_out),
        "slew.avoid_modes": bool(slew.avoid_modes),
    }


def _require_unit(name: str, q_xyzw: "Quaternion") -> None:
    norm = math.hypot(*q_xyzw)
    if not abs(norm - 1.0) <= 1e-6:
        raise ValueError(f"{name} must have unit length, not {norm:.9g}; divide it by its norm")


def refuse_axes_only(platform: str, is_given: Mapping[str, bool]) -> None:
    """Raises ValueError for the first field that is given though this platform is a body."""
    for name, is_there in is_given.items():
        if is_there:
            raise ValueError(
                f"{name} must be left out for {platform}: only two axes on a carrier have it, and "
                "a body steers itself"
            )


def inertia_of(scenario: "Scenario") -> Array:
    """Of the body that wheels turn, (3, 3): it has one, or the request was refused."""
    assert isinstance(scenario.platform, BodyPlatform)
    return np.array(scenario.platform.inertia_kg_m2)


class BodyRules:
    """As `Rules` says."""

    state_members: ClassVar = ("q_body_from_eci_xyzw", "omega_body_deg_s", "alpha_body_deg_s2")
    scan_roll: ClassVar[RollRule | None] = LinesAcrossMotion()

    def __init__(self, platform: AnyPlatform) -> None:
        assert isinstance(platform, BodyPlatform)  # by the registry
        self.platform = platform

    def require(self, scenario: "Scenario") -> None:
        state = scenario.initial_state
        given = asked_of_axes(scenario.attitude, scenario.slew) | {
            "initial_state.angles_deg": bool(state.angles_deg),
            "initial_state.rates_deg_s": bool(state.rates_deg_s),
            "initial_state.accelerations_deg_s2": bool(state.accelerations_deg_s2),
            "final_state": scenario.final_state not in (None, "idle"),
        }
        for number, session in enumerate(scenario.sessions):
            given[f"sessions.{number}.keyhole"] = session.keyhole != "refuse"
            mode = session.target.mode
            given[f"sessions.{number}.target.mode"] = mode == BenchMotionTarget.mode
            self.require_roll(f"sessions.{number}.roll", session.roll, session.target)
        refuse_axes_only(self.platform.name, given)
        self._require_initial(state)
        self.require_wheels(scenario.resources)

    def require_wheels(self, resources: Resources | None) -> None:
        if resources is None or resources.momentum is None:
            return
        if self.platform.gyros is not None:
            raise ValueError(
                f"resources.momentum must be left out for {self.platform.name}: gyros turn it, "
                "whose momentum is planned with gyros.start_n_m_s"
            )
        if self.platform.inertia_kg_m2 is None:
            raise ValueError(
                f"resources.momentum must be left out for {self.platform.name}, or its "
                "inertia_kg_m2 be given: wheels hold what it turns with"
            )

    def require_roll(self, name: str, roll: RollRule | None, target: Target) -> None:
        if roll is None:
            return
        self.platform.require_roll(name, roll)
        if not says_roll(roll, target):
            raise ValueError(
                f"{name} must not be {roll.rule}, which says nothing of {target.label}: give "
                "another rule, such as nearest, or leave it out"
            )

    def _require_initial(self, state: "InitialState") -> None:
        asked, platform = state.body_only, self.platform
        if state.q_body_from_eci_xyzw is None:
            if asked:
                raise ValueError(
                    f"initial_state.{asked[0]} must be given together with q_body_from_eci_xyzw: "
                    "without it the body begins on its idle attitude"
                )
            return
        _require_unit("initial_state.q_body_from_eci_xyzw", state.q_body_from_eci_xyzw)
        rate_max, acceleration_max, _ = np.rad2deg(platform.envelope.by_order_rad)
        for name, given, most in (
            ("omega_body_deg_s", state.omega_body_deg_s, rate_max),
            ("alpha_body_deg_s2", state.alpha_body_deg_s2, acceleration_max),
        ):
            size = np.abs(given or (0.0,) * 3)
            if platform.envelope.limits == "magnitude":
                size = np.full(3, np.linalg.norm(size))
            worst = int(np.argmax(size / most))
            if size[worst] > most[worst] * (1.0 + 1e-9):
                raise ValueError(
                    f"initial_state.{name} reaches {figures(*(size[worst], most[worst]))}, beyond "
                    f"the {most[worst]:.6g} that agility of {platform.name} allows"
                )

    def require_attitude(self, attitude: Attitude | None) -> None:
        refuse_axes_only(self.platform.name, {"attitude": attitude is not None})

    def require_rest(
        self,
        rest_deg: Mapping[str, float] | None,
        begin_q_xyzw: "Quaternion | None",
        attitude: Attitude | None,
        slew: "SlewOptions",
    ) -> None:
        if begin_q_xyzw is not None:
            _require_unit("initial_q_body_from_eci_xyzw", begin_q_xyzw)
        given = {"rest_angles_deg": rest_deg is not None}
        refuse_axes_only(self.platform.name, given | asked_of_axes(attitude, slew))

    def at_rest(self) -> Mapping[str, Any]:
        return {}

    def told(self, state: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
        given = {name: state[name] for name in self.state_members if name in state}
        return "the body's attitude and rate", given

    def state_at_end(self, table: CommandTable) -> dict[str, Any]:
        assert table.acceleration_rad_s2 is not None  # a body's has it
        q_body_from_eci = Rotation.from_quat(table.position[-1]).inv()
        told = (
            np.round(q_body_from_eci.as_quat(), 13).tolist(),
            told_deg(table.rate_rad_s[-1]),
            told_deg(table.acceleration_rad_s2[-1]),
        )
        return dict(zip(self.state_members, told, strict=True))

    def may_wait_after(self, ended: AnyPlatform, start: "InitialState") -> bool:
        """As `Rules` says: on an attitude that is told, or on the idle law that it ended on."""
        if start.q_body_from_eci_xyzw is not None:
            return True
        return isinstance(ended, BodyPlatform) and ended.idle == self.platform.idle
