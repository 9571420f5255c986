"""The state of the platform when the table begins, as far as a request gives it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime

from planner.base.assumed import Assumed
from planner.base.commands import COMMAND_STEP_S
from planner.base.spec import spec
from planner.world.frames.time_scales import shifted_utc, utc_text
from planner.world.platforms import AngleDeg, AnyPlatform
from planner.world.rules.registry import POSITIONS, rules_of
from planner.world.scenario import BodyMotionDeg, InitialState, MotionDeg, PastLooks, Quaternion

_STEP_US = round(COMMAND_STEP_S * 1e6)


@dataclass(frozen=True, kw_only=True)
class LeadOptions:
    """How long before the first session a table begins that isn't told when."""

    enough: float = 10.0  # times the least time of the slew: more makes it no smoother
    most_s: float = 3600.0  # 18,000 rows, if the least time is no more


OPTIONS = LeadOptions()


@spec
class AskedInitialState:
    """Motion of the platform when the table begins; unless given, axes rest at zero.

    Of two axes one entry per axis, by the axis's name.

    epoch: row 0 of the table; UTC, put on the row before, a whole multiple of 0.2 s after its
    second. Unless given, early enough for the slew to the first session.
    angles_deg: of the axes; unless given all are zero, or where `after` leaves them.
    rates_deg_s: of the axes; none are zero.
    accelerations_deg_s2: of the axes; none are zero. E.g. `{"alpha": 0.0, "beta": 0.0}`.
    q_body_from_eci_xyzw: of a body, carries GCRF axes onto the body's, scalar last; unless given,
    the body begins on its idle attitude. E.g. `[0.0, 0.0, 0.0, 1.0]`.
    omega_body_deg_s: of a body against GCRF, in body axes; unless given, it rests. E.g.
    `[0.0, -0.06, 0.0]`.
    alpha_body_deg_s2: of a body, in body axes; zero unless given. E.g. `[0.0, 0.0, 0.01]`.
    past_looks: sessions of earlier plans that imaged, which `min_gap_s` and `duty_cycle` of
    `conditions` count; with `after` those of that plan and of what it came after. E.g.
    `[{"start": "2015-02-27T15:58:00Z", "stop": "2015-02-27T16:03:00Z"}]`.
    after: id of a plan that the service keeps, at whose end the table begins; the service fills in
    the rest, and what `resources` begin with. E.g. `"01a203fd-cbae-73f8-8276-319f76b8842c"`.
    """

    epoch: datetime | None = None
    angles_deg: Mapping[str, AngleDeg] | None = None
    rates_deg_s: Mapping[str, MotionDeg] = field(default_factory=dict)
    accelerations_deg_s2: Mapping[str, MotionDeg] = field(default_factory=dict)
    q_body_from_eci_xyzw: Quaternion | None = None
    omega_body_deg_s: BodyMotionDeg | None = None
    alpha_body_deg_s2: BodyMotionDeg | None = None
    past_looks: PastLooks = ()
    after: str | None = None

    def __post_init__(self) -> None:
        if self.after is not None and not any(getattr(self, name) for name in POSITIONS):
            raise ValueError(
                "after names a plan that only the service that keeps it knows: send it the "
                "request (slewtrack plan --url), or give its epoch and motion instead"
            )
        of_axes = (*self.rates_deg_s.values(), *self.accelerations_deg_s2.values())
        of_body = (*(self.omega_body_deg_s or ()), *(self.alpha_body_deg_s2 or ()))
        if self.epoch is None and any(of_axes + of_body):
            raise ValueError("epoch is required where the platform moves at the start")

    def completed(self, platform: AnyPlatform, first_start_utc: datetime) -> InitialState:
        """With what wasn't given, for a first session that starts then."""
        rules = rules_of(platform)
        given = {name: value for name, value in vars(self).items() if value is not None}
        rest = {name: value for name, value in rules.at_rest().items() if name not in given}
        state = given | rest
        after = state.pop("after", None)
        if self.epoch is None:
            lead_s = _lead_s(platform, state.get(rules.state_members[0], {}))
            epoch_utc = shifted_utc(first_start_utc, -lead_s).replace(microsecond=0)
        else:
            on_row_us = self.epoch.microsecond // _STEP_US * _STEP_US
            epoch_utc = self.epoch.replace(microsecond=on_row_us)  # the last that may be row 0
        epoch = utc_text(epoch_utc, 1)
        found: list[tuple[str, str, object]] = []
        if self.epoch is None:
            detail = f"{epoch}, early enough for the slew to the first session"
            found.append(("epoch", detail, epoch))
        elif epoch_utc != self.epoch:
            detail = f"{epoch}, the last row not after {utc_text(self.epoch, 6)}"
            found.append(("epoch", detail, epoch))
        if rest:
            where, members = rules.told(rest)
            found += [(name, f"at rest at {where}", value) for name, value in members.items()]
        assumed = tuple(
            Assumed(field=f"initial_state.{name}", detail=detail, members={name: value})
            for name, detail, value in found
        )
        if after is not None:
            where, members = rules.told(state)
            detail = f"the end of plan {after}: {where}, from {epoch} on"
            members = {"epoch": epoch} | members
            if self.past_looks:
                members["past_looks"] = [one.told for one in self.past_looks]
            assumed = (Assumed(field="initial_state.after", detail=detail, members=members),)
        return InitialState(**state | {"epoch": epoch_utc, "assumed": assumed})


def _lead_s(platform: AnyPlatform, position_deg: Mapping[str, float]) -> float:
    """Time for a gentle slew from rest to the stop farthest from a position, by name.

    By half a turn where there is no stop.

    Source: the profile that reaches every limit (Biagiotti, Melchiorri 2008, 3.4), which bounds
    the least time.
    """
    least_s = 0.0
    for name, (stops, *orders) in zip(platform.dof_names, platform.motion_bounds(), strict=True):
        travel_rad = math.pi
        if stops is not None:
            position_rad = math.radians(position_deg.get(name, 0.0))
            travel_rad = max(stops[1] - position_rad, position_rad - stops[0])
        rate, acceleration, jerk = (most for _, most in orders)
        least_s = max(least_s, travel_rad / rate + rate / acceleration + acceleration / jerk)
    return math.ceil(max(least_s, min(OPTIONS.enough * least_s, OPTIONS.most_s)))
