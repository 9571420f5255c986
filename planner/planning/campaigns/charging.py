"""Sunlight over a campaign, and what a body's panels bring in it at rest, on looks and on slews."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.planning.campaigns.platforms.follower import Follower
from planner.planning.campaigns.request import CampaignRequest
from planner.planning.resources import LightAndContacts, panels_w, sun_eci
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris
from planner.world.resources import Battery


@dataclass(frozen=True, kw_only=True)
class ChargingOptions:
    """How closely what panels bring is followed over a campaign."""

    step_s: float = 10.0  # of charge by panels, linear between: the Sun's cosine errs by 2e-5
    tick_s: float = 30.0  # between looks at a level within a pass, where panels charge
    slew_parts: int = 8  # of a slew, in which the charge of panels is linear


CHARGING = ChargingOptions()


class Charging(LightAndContacts):
    """Light and contacts of a campaign, and what panels give at rest or at any attitude."""

    def __init__(self, request: CampaignRequest, ephemeris: Ephemeris) -> None:
        assert request.resources is not None
        self.epoch_utc, self.last_s = request.start, request.span_s
        self.ephemeris, self.resources = ephemeris, request.resources

    def power_w(self, t_s: Array, q_body_from_eci: Rotation) -> Array:
        """What panels would give in sunlight, (n,)."""
        return self._charge_w(*self.at(t_s), q_body_from_eci)


def most_w(battery: Battery) -> float:
    """No attitude's panels give more in sunlight: all sets of them that the Sun may shine on."""
    powers = np.array([panel.power_w * panel.normal for panel in battery.panels])
    sums = np.zeros((1, 3))
    for power in powers:
        sums = np.concatenate([sums, sums + power])
    return float(np.linalg.norm(sums, axis=1).max())


def _turning(turned_rad: Array, rate_rad_s: Array) -> Array:
    """How fast rotation vectors (n, 3) change that end in body axes with these rates."""
    angle = np.maximum(np.linalg.norm(turned_rad, axis=1, keepdims=True), 1e-6)
    across = np.cross(turned_rad, rate_rad_s)
    bent = (1.0 - 0.5 * angle / np.tan(0.5 * angle)) / angle**2
    return np.asarray(rate_rad_s + 0.5 * across + bent * np.cross(turned_rad, across))


@dataclass(kw_only=True, eq=False)
class Attitudes:
    """A body's attitudes in a campaign, and what its panels give there.

    In the axes of ways, which stand still.  rest_states: idle, with the rate, (n, 7).
    lit_s: seconds of sunlight since the start, by time.
    """

    around: Charging
    t_s: Array
    rest_states: Array
    sun_direction_still: Array
    at_rest_w: Array
    lit_s: tuple[Array, Array]

    @classmethod
    def of(cls, follower: Follower, around: Charging) -> "Attitudes | None":
        """None where no look turns panels."""
        count = max(math.ceil(around.last_s / CHARGING.step_s), 8)
        t_s = np.linspace(0.0, around.last_s, count + 1)
        instants, states = around.at(t_s)
        idle = follower.rest_motion(instants, states)
        if idle is None:
            return None
        q_eci_from_body = Rotation.from_quat(idle.position)
        # Precession and the pole move by some arcseconds in a month.
        still_from_eci = Rotation.from_matrix(
            c_itrf_from_eci(Instants(around.epoch_utc, np.zeros(1)))[0]
        )
        return cls(
            around=around,
            t_s=t_s,
            rest_states=np.concatenate(
                [(still_from_eci * q_eci_from_body).as_quat(), idle.rate_rad_s], axis=1
            ),
            sun_direction_still=still_from_eci.apply(sun_eci(instants, states)),
            at_rest_w=around.power_w(t_s, q_eci_from_body.inv()),
            lit_s=(t_s, t_s),
        )

    def idle_w(self, t_s: Array) -> Array:
        return np.interp(t_s, self.t_s, self.at_rest_w)

    def brought_ws(
        self, states: Sequence[tuple[float, Array]], start_s: float, stop_s: float
    ) -> tuple[Array, Array]:
        """What panels bring from a pass's start to its stop, by time.

        states: when, and attitude and rate, at each begin and end of a look.
        """
        known_s = np.array([start_s, *(at_s for at_s, _ in states), stop_s])
        ends = self.rest_states[self._nearest(known_s[[0, -1]])]
        known = np.concatenate([ends[:1], [state for _, state in states], ends[1:]])
        turned, long_s = Rotation.from_quat(known[:, :4]), np.diff(known_s)[:, None]
        whole = (turned[:-1].inv() * turned[1:]).as_rotvec()
        start, stop = known[:-1, 4:], _turning(whole, known[1:, 4:])
        parts = np.arange(CHARGING.slew_parts)[:, None, None] / CHARGING.slew_parts
        # The least jerk from one attitude and rate to the next: as slews are planned, nearly.
        flown = parts**3 * (10.0 - 15.0 * parts + 6.0 * parts**2) * whole
        flown = flown + (parts - 6.0 * parts**3 + 8.0 * parts**4 - 3.0 * parts**5) * long_s * start
        flown = flown - parts**3 * (4.0 - 7.0 * parts + 3.0 * parts**2) * long_s * stop
        turns = Rotation.from_rotvec(np.moveaxis(flown, 0, 1).reshape(-1, 3))
        of = np.repeat(np.arange(len(whole)), len(parts))
        q_still_from_body = Rotation.concatenate([turned[of] * turns, turned[-1:]])
        t_s = (known_s[:-1, None] + long_s * parts[:, 0, 0]).ravel()
        t_s = np.append(t_s, known_s[-1])
        sun = np.stack(
            [np.interp(t_s, self.t_s, axis) for axis in self.sun_direction_still.T], axis=1
        )
        sun_body = q_still_from_body.inv().apply(sun / np.linalg.norm(sun, axis=1, keepdims=True))
        assert self.around.resources.battery is not None
        power_w = panels_w(self.around.resources.battery, sun_body)
        lit_s = np.diff(np.interp(t_s, *self.lit_s))
        return t_s, np.append(0.0, np.cumsum(0.5 * (power_w[1:] + power_w[:-1]) * lit_s))

    def _nearest(self, t_s: Array) -> list[int]:
        step_s = float(self.t_s[1] - self.t_s[0])
        return [round(min(max(at_s / step_s, 0.0), len(self.t_s) - 1.0)) for at_s in t_s.tolist()]
