"""A spacecraft that turns as a whole as a campaign asks of it: tracks by a roll rule, and rest."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from itertools import groupby

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import ROWS_PER_S, Motion
from planner.base.compiled import compiled
from planner.base.rotation import Rotation
from planner.base.vectors import Vector, scaled, unit, vector_at
from planner.motion.attitude.idle import idle_attitude
from planner.motion.attitude.track import agility_limits, pointed_quaternions
from planner.motion.pointing.line_of_sight import STENCIL, LineOfSight
from planner.planning.campaigns.platforms.axis_slew_time import change_s
from planner.planning.campaigns.platforms.body_slew_time import OPTIONS as BLEND
from planner.planning.campaigns.platforms.body_slew_time import BodyEnvelope
from planner.planning.campaigns.platforms.follower import FollowedLook, Following, PassEnds
from planner.planning.campaigns.platforms.slew_fits import FollowerLimits
from planner.planning.campaigns.request import CampaignRequest
from planner.planning.opportunities.carrier import Carrier, carrier_over
from planner.planning.opportunities.looks import CarrierTables, Places, look
from planner.planning.opportunities.platforms.body import BodyLookout
from planner.planning.opportunities.sights import Sight, in_sights, visible_target
from planner.planning.opportunities.tracking import (
    NEAREST,
    Tracking,
    aside_at,
    first_not_carried,
    kept_between,
    session_margin_rad,
)
from planner.planning.opportunities.tracking import OPTIONS as TRACKING
from planner.planning.sessions.platforms.body_budget import body_probabilities_at
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S, c_itrf_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.platforms import BodyPlatform
from planner.world.scenario import BoundedLead, InitialState


@dataclass(frozen=True, kw_only=True)
class TrackFollowingOptions:
    """How a body's motion along its targets is told from attitudes."""

    delta_s: float = 1.0  # rates and accelerations are differences over it, good to 3e-4 of them


OPTIONS = TrackFollowingOptions()


def slew_limits(platform: BodyPlatform) -> tuple[FollowerLimits, float]:
    """Of its slews, and the longest that one takes, s."""
    limits = agility_limits(platform)
    lengths, least = np.array(limits.lengths), limits.by_order.min(axis=0)
    envelope = BodyEnvelope(
        by_axis=np.ascontiguousarray(limits.by_order),
        is_round=np.array(limits.round_orders),
        length_limits=lengths,
        least_limits=least,
        boresight_body=platform.boresight_body,
    )
    # To rest, half a turn about any axis, and to the greatest rate again.
    stop_s = change_s(float(lengths[0]), float(least[1]), float(least[2]))
    longest_s = BLEND.switching_s + 3.0 * stop_s + max(math.pi / least[0], stop_s)
    return FollowerLimits(axes=np.empty((0, 3)), body=envelope), longest_s


def moving_state(before: Rotation, then: Rotation, after: Rotation) -> Array:
    """States, as `body_fits` takes them, of rotations from the body to axes that stand still, and
    `delta_s` before and after, (n, 11)."""
    turn_before, turn_after = ((then.inv() * other).as_rotvec() for other in (before, after))
    rate = (turn_after - turn_before) / (2.0 * OPTIONS.delta_s)
    acceleration = (turn_after + turn_before) / OPTIONS.delta_s**2
    return np.concatenate([then.as_quat(), rate, acceleration, np.zeros((len(rate), 1))], axis=1)


class BodyFollower:
    """As `Follower` says; a way is a sense of the roll rule, rest is the idle attitude.

    States are told in axes that stand still: those of ITRF, turned back by the Earth's rotation
    since the campaign's start.
    """

    held_s = 0.0
    resting = "the body needs to leave its idle attitude and to come back to it"
    unable = "the body can't follow it for {least_s:g} s within its rate, acceleration and jerk"

    def __init__(self, request: CampaignRequest) -> None:
        platform = request.platform
        if not isinstance(platform, BodyPlatform):
            raise TypeError(f"{platform.name} is no body")
        self._request, self._platform = request, platform
        self._lookout = BodyLookout(platform, None)
        self.slew_limits, self.longest_slew_s = slew_limits(platform)
        self.settle_s = platform.envelope.settle_s
        self.rest_s = math.ceil((self.longest_slew_s + self.settle_s) * ROWS_PER_S) / ROWS_PER_S
        self._seen_as: dict[int, tuple[Tracking, Sight, int]] = {}

    def carrier(self, ephemeris: Ephemeris) -> Carrier:
        return carrier_over(ephemeris, self._lookout, self._request.start, self._request.stop)

    def ways(self, sight: Sight, which: Indices, t_s: Array) -> Iterator[Following]:
        carrier = sight.carrier
        tracking = self._lookout.tracking(sight)
        most_rad = self._lookout.off_nadir_max_rad(sight)
        is_free = np.full((len(t_s), 1), float(tracking.roll == NEAREST))
        next_s = 1.001 * max(self._request.step_s, TRACKING.step_s)  # farther lies another look
        for sense in range(tracking.senses):
            before, then, after = (
                self._attitudes(tracking, sight, which, at_s, sense)
                for at_s in (t_s - OPTIONS.delta_s, t_s, t_s + OPTIONS.delta_s)
            )
            turn_before, turn_after = (
                self._turns_rad(tracking, then, other) for other in (before, after)
            )
            rate = (turn_after - turn_before) / (2.0 * OPTIONS.delta_s)
            acceleration = (turn_after + turn_before) / OPTIONS.delta_s**2
            usable, goes_on = _usable(
                tracking, carrier.tables, sight.places, which, t_s, sense, most_rad, next_s
            )
            yield Following(
                states=np.concatenate([then.as_quat(), rate, acceleration, is_free], axis=1),
                usable=usable,
                goes_on=goes_on,
            )

    def rest_state(self, carrier: Carrier, at_s: float) -> Array:
        around_s = np.asarray(at_s + OPTIONS.delta_s * (np.arange(STENCIL) - STENCIL // 2), float)
        instants = Instants(carrier.start_utc, around_s)
        idle = idle_attitude(self._platform.idle, instants, carrier.states(instants))
        q_eci_from_body = Rotation.from_quat(idle.position[STENCIL // 2])
        moving = idle.rate_rad_s[STENCIL // 2], idle.acceleration_rad_s2[STENCIL // 2]
        return _state(carrier, at_s, q_eci_from_body, np.concatenate(moving))

    def start_state(self, carrier: Carrier, at_s: float) -> Array:
        q_xyzw = self._request.initial_q_body_from_eci_xyzw
        if q_xyzw is None:
            return self.rest_state(carrier, at_s)
        return _state(carrier, at_s, Rotation.from_quat(q_xyzw).inv(), np.zeros(6))

    def first_unheld(
        self, carrier: Carrier, looks: Sequence[FollowedLook], rows: Sequence[int]
    ) -> tuple[int, float] | None:
        """Of those whose roll is the nearest to the attitude before, of a pass's first look to the
        idle one, or that in which the campaign begins."""
        before_s = max(looks[0].start_s - self.rest_s, 0.0) if looks else 0.0
        before: tuple[Vector, Vector] | None = None
        is_told = self._request.initial_q_body_from_eci_xyzw is not None
        if looks and is_told and looks[0].start_s < 2.0 * self.rest_s:
            before = self._lying(FollowedLook(None, 0.0, 0.0, self.start_state(carrier, 0.0)))
            before_s = 0.0
        seen = [None if one.row is None else self._seen(carrier, one.row, rows) for one in looks]
        place = 0
        for _, group in groupby(
            zip(looks, seen, strict=True), lambda one: id(one[1] and one[1][1])
        ):
            own, each = zip(*group, strict=True)
            alike = [one for one in each if one]
            if not alike or alike[0][0].roll != NEAREST:
                before, before_s = self._lying(own[-1]), own[-1].stop_s
                place += len(own)
                continue
            tracking, sight, _ = alike[0]
            idle = tracking.idle, tracking.idle_step_s, before_s
            held, unheld_s, before = first_not_carried(
                tracking,
                carrier.tables,
                sight.places,
                np.array([number for _, _, number in alike]),
                np.array([(look.start_s - self.settle_s, look.stop_s) for look in own]),
                before_s,
                before or (unit(vector_at(*idle, 0)), vector_at(*idle, 3)),
                self._lookout.off_nadir_max_rad(sight),
            )
            place += held
            if held < len(own):
                return place, unheld_s
            before_s = own[-1].stop_s
        return None

    def probability(self, sight: Sight, which: Indices, t_s: Array, ephemeris: Ephemeris) -> Array:
        tracking = self._lookout.tracking(sight)
        instants = Instants(sight.carrier.start_utc, t_s)
        c_itrf = c_itrf_from_eci(instants)
        before, then, after = (
            sight.sighting(which, at_s).direction_itrf
            for at_s in (t_s - OPTIONS.delta_s, t_s, t_s + OPTIONS.delta_s)
        )
        turning_rad_s = np.array([0.0, 0.0, OMEGA_EARTH_RAD_S])
        rate_itrf = (after - before) / (2.0 * OPTIONS.delta_s) + np.cross(turning_rad_s, then)
        los_eci, los_rate_eci = (
            np.einsum("nji,nj->ni", c_itrf, part) for part in (then, rate_itrf)
        )
        seen = sight.sighting(which, t_s)
        q_itrf_from_body = self._attitudes(tracking, sight, which, t_s, 0, stands_still=False)
        q_eci_from_body = Rotation.from_matrix(c_itrf).inv() * q_itrf_from_body
        los = LineOfSight(
            instants=instants,
            states=ephemeris.states(instants),
            los_base=los_eci,
            los_rate_base_per_s=los_rate_eci,
            los_acceleration_base_per_s2=np.full((len(t_s), 3), math.nan),
            range_m=seen.range_m,
            clearance_rad=seen.elevation_rad,
        )
        return body_probabilities_at(
            los, ephemeris, visible_target(sight, which), self._platform, q_eci_from_body.as_quat()
        )

    def rest_motion(self, instants: Instants, states: OrbitStates) -> Motion:
        return idle_attitude(self._platform.idle, instants, states)

    def pass_ends(self, start_utc: datetime, stop_utc: datetime, *, is_first: bool) -> PassEnds:
        """A slew onto the idle attitude takes no longer than the room that the pass has for it."""
        slew = self._request.slew
        q_xyzw = self._request.initial_q_body_from_eci_xyzw if is_first else None
        most_s = slew.lead.max_duration_s if isinstance(slew.lead, BoundedLead) else None
        lead = BoundedLead(max_duration_s=min(most_s or math.inf, self.rest_s))
        return PassEnds(
            attitude=None,
            initial_state=InitialState(epoch=start_utc, q_body_from_eci_xyzw=q_xyzw),
            rest=(),
            final_state="idle",
            final_by=stop_utc,
            slew=replace(slew, lead=lead),
        )

    def _seen(self, carrier: Carrier, row: int, rows: Sequence[int]) -> tuple[Tracking, Sight, int]:
        """How a target is looked at, with those of `rows` that are seen alike, and its number among
        them."""
        if row not in self._seen_as:
            targets = [self._request.targets[one].opportunity for one in rows]
            for found, sight, which in in_sights(np.arange(len(rows)), targets, carrier):
                tracking = self._lookout.tracking(sight)
                for n, own in zip(found.tolist(), which.tolist(), strict=True):
                    self._seen_as[rows[n]] = tracking, sight, own
        return self._seen_as[row]

    def _lying(self, look: FollowedLook) -> tuple[Vector, Vector]:
        """Boresight and +X of the camera at a look's end, ITRF."""
        back_rad = [0.0, 0.0, -OMEGA_EARTH_RAD_S * look.stop_s]
        turn = Rotation.from_rotvec(back_rad) * Rotation.from_quat(look.stop_state[:4])
        boresight, aside = turn.apply(self._platform.camera.c_payload_from_body[[2, 0]]).tolist()
        return tuple(boresight), tuple(aside)

    def _attitudes(
        self,
        tracking: Tracking,
        sight: Sight,
        which: Indices,
        t_s: Array,
        sense: int,
        *,
        stands_still: bool = True,
    ) -> Rotation:
        """n rotations from the body to the axes that stand still, or to ITRF.

        Of a roll that is free the one nearest to the idle attitude stands for all.
        """
        directions = _directions(tracking, sight.carrier.tables, sight.places, which, t_s)
        toward_body, aside_body, _ = np.array(tracking.body_from_triad)
        sign = -1.0 if sense else 1.0
        q_xyzw = pointed_quaternions(
            directions[:, :3], sign * directions[:, 3:], toward_body, aside_body
        )
        q_itrf_from_body = Rotation.from_quat(q_xyzw)
        if not stands_still:
            return q_itrf_from_body
        turned_rad = np.outer(OMEGA_EARTH_RAD_S * t_s, [0.0, 0.0, 1.0])
        return Rotation.from_rotvec(turned_rad) * q_itrf_from_body

    def _turns_rad(self, tracking: Tracking, then: Rotation, other: Rotation) -> Array:
        """Rotation vectors in body axes from `then` to the other attitudes, (n, 3).

        Of a roll that is free as the boresight goes, with no turn about it.
        """
        turn = then.inv() * other
        if tracking.roll != NEAREST:
            return np.asarray(turn.as_rotvec())
        boresight_body = self._platform.boresight_body
        across = np.cross(boresight_body, turn.apply(boresight_body))
        sine = np.linalg.norm(across, axis=1, keepdims=True)
        return np.asarray(across * (np.arcsin(np.minimum(sine, 1.0)) / np.maximum(sine, 1e-15)))


def _state(carrier: Carrier, at_s: float, q_eci_from_body: Rotation, motion_body: Array) -> Array:
    """motion_body: rate and acceleration, (6,)."""
    [c_itrf] = c_itrf_from_eci(Instants(carrier.start_utc, np.array([at_s])))
    turned = Rotation.from_rotvec([0.0, 0.0, OMEGA_EARTH_RAD_S * at_s])
    q_still_from_body = turned * Rotation.from_matrix(c_itrf) * q_eci_from_body
    return np.concatenate([q_still_from_body.as_quat(), motion_body, [0.0]])


@compiled
def _directions(b: Tracking, c: CarrierTables, p: Places, which: Indices, t_s: Array) -> Array:
    """The line of sight and what the roll rule turns the body towards, ITRF, (n, 6)."""
    directions = np.empty((len(t_s), 6))
    for row in range(len(t_s)):
        n, at_s = which[row], t_s[row]
        d, _, r_sat, v = look(c, p, n, at_s)
        aside = aside_at(b, c, p, n, at_s, d, r_sat, v)
        for k in range(3):
            directions[row, k], directions[row, 3 + k] = d[k], aside[k]
    return directions


@compiled
def _usable(
    b: Tracking,
    c: CarrierTables,
    p: Places,
    which: Indices,
    t_s: Array,
    sense: int,
    off_nadir_rad: float,
    next_s: float,
) -> tuple[Mask, Mask]:
    """Whether a session may be there by a sense of the rule, at each sample, (n,), and between one
    and the next of the same look, (n - 1,).

    next_s: no sample of the same look follows later than that.
    """
    usable, goes_on = np.empty(len(t_s), np.bool_), np.ones(max(len(t_s) - 1, 0), np.bool_)
    sign, was_rad = 1.0 - 2.0 * sense, 0.0
    for row in range(len(t_s)):
        n, at_s = which[row], t_s[row]
        d, _, r_sat, v = look(c, p, n, at_s)
        aside = scaled(sign, aside_at(b, c, p, n, at_s, d, r_sat, v))
        far_rad = session_margin_rad(b, c, p, n, at_s, sign, aside, off_nadir_rad)
        usable[row] = far_rad > 0.0
        # "nearest" is carried on from what a look comes after: see `first_unheld`.
        least_rad = min(was_rad, far_rad)
        if b.roll != NEAREST and least_rad > 0.0 and which[row - 1] == n:
            by_rule, span_s = (False, d, aside), (t_s[row - 1], at_s)
            if span_s[1] - span_s[0] < next_s:
                goes_on[row - 1] = kept_between(b, c, p, n, span_s, sign, by_rule, least_rad)
        was_rad = far_rad
    return usable, goes_on
