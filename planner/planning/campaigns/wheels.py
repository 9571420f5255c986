"""Momentum of a body's wheels over a campaign, simulated from its first instant to its last."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.rotation import Rotation
from planner.planning.campaigns.charging import Attitudes
from planner.planning.campaigns.request import CampaignRequest
from planner.world.platforms import BodyPlatform
from planner.world.platforms.gravity_gradient import gradient_torque_body_n_m
from planner.world.platforms.wheels import wheel_momentum
from planner.world.resources import MOMENTA, Momentum, ResourceName


@dataclass(frozen=True, kw_only=True)
class WheelOptions:
    """How closely a momentum is followed, and what is kept free of it for slews as planned."""

    step_s: float = 30.0  # at rest: of gravity's torque the trapezoid errs by 4e-4
    # of a capacity: a planned slew reaches a few percent more than the one of least jerk
    spare_share: float = 0.02
    rounding: float = 1e-9  # of a capacity


OPTIONS = WheelOptions()


class Turned(NamedTuple):
    """A pass, or rest, at n instants: the body's attitude, (n, 3, 3), what it turns with in its own
    axes, (n, 3), and the torque from outside, (n, 3), both in axes that stand still."""

    t_s: Array
    c_body_from_still: Array
    turning_body_n_m_s: Array
    torque_still_n_m: Array


class Beyond(NamedTuple):
    """The first momentum that passes its limit, when, and by how much in the end."""

    name: ResourceName
    limit_n_m_s: float
    at_s: float
    short_n_m_s: float


class Wheels:
    """Of one carrier, which unloads at rest between passes, as a plan does while it waits."""

    def __init__(self, request: CampaignRequest, momentum: Momentum, attitudes: Attitudes) -> None:
        platform = request.platform
        assert isinstance(platform, BodyPlatform)  # the only ones whose requests may have wheels
        assert platform.inertia_kg_m2 is not None
        self._inertia_kg_m2 = np.array(platform.inertia_kg_m2)
        self._momentum, self._attitudes = momentum, attitudes
        count = max(round(request.span_s / OPTIONS.step_s), 8)
        t_s = np.linspace(0.0, request.span_s, count + 1)
        states = attitudes.rests(t_s)
        if attitudes.start_state is not None:
            states[0] = attitudes.start_state[1]
        self._rest = self._at(t_s, Rotation.from_quat(states[:, :4]), states[:, 4:7])

    def turned(
        self, states: Sequence[tuple[float, Array]], start_s: float, stop_s: float
    ) -> Turned:
        """Of a pass, as `Attitudes.flown`."""
        return self._at(*self._attitudes.flown(states, start_s, stop_s))

    def _at(self, t_s: Array, q_still_from_body: Rotation, rate_rad_s: Array) -> Turned:
        attitudes = self._attitudes
        r_m = [np.interp(t_s, attitudes.t_s, axis_m) for axis_m in attitudes.r_sat_still_m.T]
        q_body_from_still = q_still_from_body.inv()
        torque_n_m = gradient_torque_body_n_m(
            q_body_from_still, np.stack(r_m, axis=1), self._inertia_kg_m2
        )
        torque_n_m = torque_n_m + self._momentum.torque_body_n_m
        return Turned(
            t_s,
            q_body_from_still.as_matrix(),
            rate_rad_s @ self._inertia_kg_m2,
            q_still_from_body.apply(torque_n_m),
        )

    def at_ends(self, flown: Sequence[Turned]) -> Array:
        """What the wheels hold as each pass starts and as it stops, (n, 2, 3)."""
        t_s, held = self.held(flown)
        rows = np.searchsorted(t_s, [[one.t_s[0], one.t_s[-1]] for one in flown])
        most = np.array(self._momentum.capacity_n_m_s)
        return np.asarray(np.clip(held[rows], -most, most))

    def at_last(self, flown: Sequence[Turned]) -> Array:
        """What they hold at first and at last, (1, 2, 3)."""
        most = np.array(self._momentum.capacity_n_m_s)
        return np.asarray(np.clip(self.held(flown)[1][None, [0, -1]], -most, most))

    def stayed(
        self, start_s: float, stop_s: float, held_n_m_s: Sequence[Sequence[float]]
    ) -> Turned:
        """A pass that is known by what the wheels held at its ends, which all torques in it made of
        each other."""
        t_s = np.array([start_s, stop_s])
        states = self._attitudes.rests(t_s)
        states[0] = self._attitudes.begin(start_s)
        ends = self._at(t_s, Rotation.from_quat(states[:, :4]), states[:, 4:7])
        total = np.einsum(
            "nji,nj->ni", ends.c_body_from_still, np.array(held_n_m_s) + ends.turning_body_n_m_s
        )
        rows = np.array([0, 0, 1, 1])
        torque_n_m = ends.torque_still_n_m[rows]
        torque_n_m[1:3] = (total[1] - total[0]) / (stop_s - start_s)
        t_s = np.maximum(t_s, 0.0)  # of a pass that began before, the rest
        return Turned(
            t_s[rows], ends.c_body_from_still[rows], ends.turning_body_n_m_s[rows], torque_n_m
        )

    def beyond(self, passes: Sequence[Turned]) -> Beyond | None:
        """The first that passes its limit, in passes what is spared of it; passes in order of
        time."""
        t_s, held = self.held(passes)
        moves = np.zeros(len(t_s), np.bool_)
        for one in passes:
            moves |= (t_s >= one.t_s[0]) & (t_s <= one.t_s[-1])
        most = np.array(self._momentum.capacity_n_m_s)
        limit = most * (1.0 - OPTIONS.spare_share * moves[:, None])
        over = np.abs(held) - limit
        rows, axes = np.nonzero(over > OPTIONS.rounding * most)
        if not len(rows):
            return None
        row, axis = int(rows[0]), int(axes[0])
        return Beyond(
            MOMENTA[axis], float(limit[row, axis]), float(t_s[row]), float(over[:, axis].max())
        )

    def held(self, passes: Sequence[Turned]) -> tuple[Array, Array]:
        """By the wheels about the body's axes, by time, (n, 3)."""
        rest, parts, idle = self._rest, [], [np.zeros(0, np.bool_)]
        row = 0
        for one in passes:
            begin = max(int(np.searchsorted(rest.t_s, one.t_s[0])), row)
            parts += [_rows(rest, row, begin), one]
            idle += [np.ones(begin - row, np.bool_), _moving(len(one.t_s))]
            row = max(int(np.searchsorted(rest.t_s, one.t_s[-1], side="right")), row)
        parts.append(_rows(rest, row, len(rest.t_s)))
        idle.append(np.ones(len(rest.t_s) - row, np.bool_))
        whole = Turned(*(np.concatenate(column) for column in zip(*parts, strict=True)))
        step_s, torque = np.diff(whole.t_s), whole.torque_still_n_m
        rests = np.concatenate(idle)[: len(step_s)]
        return whole.t_s, wheel_momentum(
            np.ascontiguousarray(whole.c_body_from_still),
            whole.turning_body_n_m_s,
            0.5 * step_s[:, None] * (torque[1:] + torque[:-1]),
            self._momentum.unload_n_m * step_s * rests,
            np.array(self._momentum.start_n_m_s),
        )


def _rows(rest: Turned, start: int, stop: int) -> Turned:
    return Turned(*(column[start:stop] for column in rest))


def _moving(rows: int) -> Mask:
    """Steps from each row to the next: at rest from the last one on."""
    return np.asarray(np.arange(rows) == rows - 1)
