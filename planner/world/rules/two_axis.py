"""The rules of two axes: their names, stops and limits in a request, and what it asks of them."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from planner.base.arrays import Array, told_deg
from planner.base.commands import COMMAND_STEP_S, CommandTable
from planner.base.errors import figures
from planner.world.attitude import Attitude
from planner.world.platforms import AnyPlatform, AxisLimits, FinalAngles, RollRule, TwoAxisPlatform
from planner.world.resources import Resources
from planner.world.targets import Target

if TYPE_CHECKING:
    from planner.world.scenario import InitialState, Quaternion, Scenario, SlewOptions


def axes_of(scenario: "Scenario") -> TwoAxisPlatform:
    """The platform, for what knows two axes only; raises NotForPlatform."""
    if not isinstance(scenario.platform, TwoAxisPlatform):
        raise scenario.not_for_platform()
    return scenario.platform


def limits_of(scenario: "Scenario") -> tuple[AxisLimits, ...]:
    """The platform's limits with the jerk limit asked for, in the order of its axes."""
    return axes_of(scenario).limits_with_jerk(scenario.slew.jerk_max_deg_s3)


def initial_motion(scenario: "Scenario", axis: str) -> Array:
    """Angle, rate and acceleration of one axis at the epoch, rad, rad/s, rad/s2."""
    state = scenario.initial_state
    return np.deg2rad(
        [
            state.angles_deg[axis],
            state.rates_deg_s.get(axis, 0.0),
            state.accelerations_deg_s2.get(axis, 0.0),
        ]
    )


def final_angle_rad(scenario: "Scenario") -> tuple[float, ...] | None:
    """Where the axes are to rest in the end, in their order; None: anywhere, or unasked."""
    final, platform = scenario.final_state, axes_of(scenario)
    if not isinstance(final, FinalAngles):
        return None
    if final.angles_deg is not None:
        return tuple(math.radians(final.angles_deg[axis]) for axis in platform.axis_names)
    return next(
        position.angle_rad for position in platform.park_positions if position.name == final.park
    )


class TwoAxisRules:
    """As `Rules` says."""

    state_members: ClassVar = ("angles_deg", "rates_deg_s", "accelerations_deg_s2")
    scan_roll: ClassVar[RollRule | None] = None

    def __init__(self, platform: AnyPlatform) -> None:
        assert isinstance(platform, TwoAxisPlatform)  # by the registry
        self.platform = platform

    def require(self, scenario: "Scenario") -> None:
        for number, session in enumerate(scenario.sessions):
            self.require_roll(f"sessions.{number}.roll", session.roll, session.target)
        if scenario.attitude is None:
            raise ValueError(f"attitude is required: {self.platform.name} stands on a carrier")
        self._require_initial(scenario)
        self.require_wheels(scenario.resources)
        if scenario.final_state == "idle":
            raise ValueError('final_state must be "rest" or angles: two axes have no idle attitude')
        if isinstance(scenario.final_state, FinalAngles):
            self._require_final(scenario.final_state)

    def require_wheels(self, resources: Resources | None) -> None:
        if resources is not None and resources.momentum is not None:
            raise ValueError(
                f"resources.momentum must be left out for {self.platform.name}: only a body that "
                "turns as a whole has wheels"
            )

    def require_roll(self, name: str, roll: RollRule | None, target: Target) -> None:
        if roll is not None:
            raise ValueError(
                f"{name} must be left out for {self.platform.name}: only a body can lie any way "
                "about the line of sight"
            )

    def _require_initial(self, scenario: "Scenario") -> None:
        state = scenario.initial_state
        if of_body := state.body_only:
            raise ValueError(
                f"initial_state.{of_body[0]} must be left out for {self.platform.name}: only a "
                "body has it; give angles_deg of the axes"
            )
        for what in self.state_members:
            given = getattr(state, what)
            if given or what == self.state_members[0]:
                self._require_names(f"initial_state.{what}", given)
        for axis, limits in zip(self.platform.axis_names, self.platform.axis_limits, strict=True):
            motion_rad = initial_motion(scenario, axis)
            for what, value, (low, high) in zip(
                self.state_members, motion_rad, limits.bounds, strict=False
            ):
                if not low <= value <= high:
                    raise ValueError(
                        f"initial_state.{what}.{axis} is "
                        f"{figures(*np.rad2deg([value, low, high]).tolist())}, outside its limits "
                        f"{math.degrees(low):.6g}..{math.degrees(high):.6g}"
                    )

    def _require_final(self, final: FinalAngles) -> None:
        if final.park is not None:
            known = [position.name for position in self.platform.park_positions]
            if final.park not in known:
                raise ValueError(
                    f"final_state.park must be a position of {self.platform.name} "
                    f"({', '.join(known) or 'it has none'}), not {final.park!r}; or give angles_deg"
                )
            return
        angles_deg = final.angles_deg or {}
        self._require_names("final_state.angles_deg", angles_deg)
        for axis, limits in zip(self.platform.axis_names, self.platform.axis_limits, strict=True):
            low_deg = math.degrees(limits.angle_min_rad)
            high_deg = math.degrees(limits.angle_max_rad)
            if not limits.angle_min_rad <= math.radians(angles_deg[axis]) <= limits.angle_max_rad:
                raise ValueError(
                    f"final_state.angles_deg.{axis} is "
                    f"{figures(angles_deg[axis], low_deg, high_deg)}, outside its limits "
                    f"{low_deg:.6g}..{high_deg:.6g}"
                )

    def _require_names(self, field: str, given: Mapping[str, float]) -> None:
        names = self.platform.axis_names
        if set(given) != set(names):
            raise ValueError(
                f"{field} must name the axes {', '.join(names)} of {self.platform.name}, "
                f"not {', '.join(given) or 'none'}"
            )

    def require_attitude(self, attitude: Attitude | None) -> None:
        pass

    def require_rest(
        self,
        rest_deg: Mapping[str, float] | None,
        begin_q_xyzw: "Quaternion | None",
        attitude: Attitude | None,
        slew: "SlewOptions",
    ) -> None:
        if begin_q_xyzw is not None:
            raise ValueError(
                f"initial_q_body_from_eci_xyzw must be left out for {self.platform.name}, whose "
                "axes begin at rest_angles_deg"
            )
        names = self.platform.axis_names
        rest_deg = dict.fromkeys(names, 0.0) if rest_deg is None else rest_deg
        self._require_names("rest_angles_deg", rest_deg)
        for name, limits in zip(names, self.platform.axis_limits, strict=True):
            low_deg = math.degrees(limits.angle_min_rad)
            high_deg = math.degrees(limits.angle_max_rad)
            if not low_deg <= rest_deg[name] <= high_deg:
                raise ValueError(
                    f"rest_angles_deg.{name} must lie within its stops {low_deg:g}..{high_deg:g}, "
                    f"not {rest_deg[name]:g}"
                )

    def at_rest(self) -> Mapping[str, Any]:
        return {"angles_deg": dict.fromkeys(self.platform.axis_names, 0.0)}

    def told(self, state: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
        angles_deg = dict(state["angles_deg"])
        angles = ", ".join(f"{axis} {angle:g}" for axis, angle in angles_deg.items())
        return f"{angles} deg", {"angles_deg": angles_deg}

    def state_at_end(self, table: CommandTable) -> dict[str, Any]:
        """As `Rules` says; the acceleration is that of the cubic flown between the last rows."""
        before_rad, angle_rad = table.position[-2:]
        rate_rad_s = table.rate_rad_s[-1]
        acceleration_rad_s2 = (
            6.0 * (before_rad - angle_rad) / COMMAND_STEP_S
            + 2.0 * table.rate_rad_s[-2]
            + 4.0 * rate_rad_s
        ) / COMMAND_STEP_S
        return {
            member: dict(zip(self.platform.axis_names, told_deg(values), strict=True))
            for member, values in zip(
                self.state_members, (angle_rad, rate_rad_s, acceleration_rad_s2), strict=True
            )
        }

    def may_wait_after(self, ended: AnyPlatform, start: "InitialState") -> bool:
        return ended.kind == self.platform.kind
