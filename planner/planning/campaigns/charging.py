"""Attitudes of a body at rest, on looks and on slews of a campaign, and what panels bring there."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.planning.campaigns.platforms.follower import Follower
from planner.planning.campaigns.request import CampaignRequest
from planner.planning.campaigns.smooth_turns import OPTIONS as TURNS
from planner.planning.campaigns.smooth_turns import smooth_turns
from planner.planning.resources import LightAndContacts, panels_w, sun_eci
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris
from planner.world.resources import Battery


@dataclass(frozen=True, kw_only=True)
class ChargingOptions:
    """How closely what panels bring is followed over a campaign."""

    step_s: float = 10.0  # of charge by panels, linear between: the Sun's cosine errs by 2e-5
    track_s: float = 20.0  # between states on a track: between, its motion is as smooth
    tick_s: float = 30.0  # between looks at a level within a pass, where panels charge
    known_share: float = 2e-3  # of a capacity: what panels bring is known to it (docs/campaigns.md)


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


class Flown(NamedTuple):
    """A body's attitudes at n instants, in the axes of ways, and its rates in its own, (n, 3)."""

    t_s: Array
    q_still_from_body: Rotation
    rate_rad_s: Array


@dataclass(kw_only=True, eq=False)
class Attitudes:
    """A body's attitudes in a campaign, and what its panels give there.

    In the axes of ways, which stand still.  rest_states: idle, with the rate, (n, 7).
    start_state: when the campaign begins, and in what attitude, rate and acceleration, (10,),
    unless idle.
    lit_s: seconds of sunlight since the start, by time.
    """

    around: Charging
    t_s: Array
    rest_states: Array
    start_state: tuple[float, Array] | None
    r_sat_still_m: Array
    sun_direction_still: Array
    at_rest_w: Array
    lit_s: tuple[Array, Array]

    @classmethod
    def of(
        cls, follower: Follower, around: Charging, start_state: tuple[float, Array] | None
    ) -> "Attitudes | None":
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
            start_state=start_state,
            r_sat_still_m=still_from_eci.apply(states.r_sat_eci_m),
            sun_direction_still=still_from_eci.apply(sun_eci(instants, states)),
            at_rest_w=around.power_w(t_s, q_eci_from_body.inv()),
            lit_s=(t_s, t_s),
        )

    def idle_w(self, t_s: Array) -> Array:
        return np.interp(t_s, self.t_s, self.at_rest_w)

    def rests(self, t_s: Array) -> Array:
        """Idle attitude, rate and no acceleration at n instants, (n, 10)."""
        step_s = float(self.t_s[1] - self.t_s[0])
        nearest = np.clip(np.rint(t_s / step_s), 0, len(self.t_s) - 1).astype(np.intp)
        states, since_s = self.rest_states[nearest], t_s - self.t_s[nearest]
        turned = Rotation.from_quat(states[:, :4])
        turned = turned * Rotation.from_rotvec(since_s[:, None] * states[:, 4:])
        return np.concatenate([turned.as_quat(), states[:, 4:], np.zeros((len(t_s), 3))], axis=1)

    def begin(self, start_s: float) -> Array:
        """In which a pass begins, (10,)."""
        if self.start_state is not None and start_s <= self.start_state[0]:
            return self.start_state[1]
        return np.asarray(self.rests(np.array([start_s]))[0])

    def flown(self, states: Sequence[tuple[float, Array]], start_s: float, stop_s: float) -> Flown:
        """From a pass's start to its stop, by smooth turns from each state to the next: as slews
        are planned, nearly.

        states: when, and attitude, rate and acceleration, (10,), at each begin and end of a look.
        """
        known_s = np.array([start_s, *(at_s for at_s, _ in states), stop_s])
        end = self.rests(known_s[-1:])
        known = np.concatenate([[self.begin(start_s)], [state for _, state in states], end])
        long_s = np.diff(known_s)
        turns = smooth_turns(known[:-1], known[1:], long_s)
        told = np.concatenate([turns.reshape(-1, 7), known[-1:, :7]])
        t_s = known_s[:-1, None] + long_s[:, None] * np.arange(TURNS.parts) / TURNS.parts
        return Flown(np.append(t_s, known_s[-1]), Rotation.from_quat(told[:, :4]), told[:, 4:])

    def brought_ws(
        self, states: Sequence[tuple[float, Array]], start_s: float, stop_s: float
    ) -> tuple[Array, Array]:
        """What panels bring from a pass's start to its stop, by time; as `flown`."""
        flown = self.flown(states, start_s, stop_s)
        t_s = flown.t_s
        sun = np.stack(
            [np.interp(t_s, self.t_s, axis) for axis in self.sun_direction_still.T], axis=1
        )
        sun_body = flown.q_still_from_body.inv().apply(
            sun / np.linalg.norm(sun, axis=1, keepdims=True)
        )
        assert self.around.resources.battery is not None
        power_w = panels_w(self.around.resources.battery, sun_body)
        lit_s = np.diff(np.interp(t_s, *self.lit_s))
        return t_s, np.append(0.0, np.cumsum(0.5 * (power_w[1:] + power_w[:-1]) * lit_s))
