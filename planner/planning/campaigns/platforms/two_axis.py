"""Two axes on a carrier as a campaign asks of them: branches that follow targets, and rest."""

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.motion.pointing.angles import axis_angles, axis_motion, singular_margin_rad
from planner.motion.pointing.line_of_sight import LineOfSight
from planner.planning.campaigns.platforms.follower import FollowedLook, Following, PassEnds
from planner.planning.campaigns.platforms.slew_fits import FollowerLimits
from planner.planning.campaigns.request import CampaignRequest
from planner.planning.opportunities.carrier import Carrier, carrier_over
from planner.planning.opportunities.platforms.registry import lookout_of
from planner.planning.opportunities.sights import Sight, visible_target
from planner.planning.sessions.platforms.two_axis.budget import probabilities_at
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import Ephemeris, OrbitStates
from planner.world.platforms import AxisLimits, TwoAxisPlatform
from planner.world.scenario import InitialState, Session
from planner.world.targets import BenchMotionTarget
from planner.world.targets.axis_signals import ConstantRate


@dataclass(frozen=True, kw_only=True)
class BranchFollowingOptions:
    """How closely a track's limits are looked at before it is planned."""

    delta_s: float = 1.0  # rates and accelerations are differences over it
    within: float = 0.98  # of each limit: what lies between the steps keeps it too
    singular_rad: float = 1e-3  # nearer to the outer axis, angles turn too fast to be followed
    rest_rows: int = 5 * ROWS_PER_S  # how long the axes are held at rest at the end of a pass


OPTIONS = BranchFollowingOptions()

TURN_RAD = 2.0 * math.pi


class TwoAxisFollower:
    """As `Follower` says; a way is a branch of `axis_angles`, with whole turns added."""

    settle_s = 0.0
    held_s = OPTIONS.rest_rows / ROWS_PER_S
    resting = "the axes need to leave their rest and to come back to it"
    unable = (
        "the axes can't follow it for {least_s:g} s within their stops, rates and accelerations"
    )

    def __init__(self, request: CampaignRequest) -> None:
        if not isinstance(request.platform, TwoAxisPlatform):
            raise TypeError(f"{request.platform.name} has no two axes")
        self._request = request
        limits = request.platform.limits_with_jerk(request.slew.jerk_max_deg_s3)
        self._platform = request.platform.with_limits(limits)
        rates = [[a.rate_max_rad_s, a.acceleration_max_rad_s2, a.jerk_max_rad_s3] for a in limits]
        self.slew_limits = FollowerLimits(np.array(rates))
        # Stop to stop, both rates in the way.
        self.longest_slew_s = max(
            _longest_s(axis, axis.angle_max_rad - axis.angle_min_rad, 2) for axis in limits
        )
        rest_rad = np.deg2rad([request.rest_deg[name] for name in self._platform.axis_names])
        longest_rest_s = max(
            _longest_s(axis, max(axis.angle_max_rad - rest, rest - axis.angle_min_rad), 1)
            for axis, rest in zip(limits, rest_rad.tolist(), strict=True)
        )
        self.rest_s = (math.ceil(longest_rest_s * ROWS_PER_S) + OPTIONS.rest_rows) / ROWS_PER_S

    def carrier(self, ephemeris: Ephemeris) -> Carrier:
        request = self._request
        base = lookout_of(self._platform, request.attitude)
        return carrier_over(ephemeris, base, request.start, request.stop)

    def ways(self, sight: Sight, which: Indices, t_s: Array) -> Iterator[Following]:
        platform = self._platform
        before, los, after = self._los(sight, which, t_s)
        los_rate_s = (after - before) / (2.0 * OPTIONS.delta_s)
        los_acceleration_s2 = (after - 2.0 * los + before) / OPTIONS.delta_s**2
        for angle_rad in axis_angles(platform, los).angle_rad:
            motion = axis_motion(platform, angle_rad, los, los_rate_s, los_acceleration_s2)
            off_keyhole = singular_margin_rad(platform, angle_rad, los) > OPTIONS.singular_rad
            for turned_rad in self._whole_turns(angle_rad):
                axis_states = np.stack([turned_rad, *motion], axis=1)
                yield Following(
                    states=axis_states.reshape(len(t_s), -1),
                    usable=off_keyhole & _keep_limits(axis_states, platform.axis_limits),
                    # Without a turn over.
                    goes_on=np.all(np.abs(np.diff(turned_rad, axis=0)) < math.pi, axis=1),
                )

    def rest_state(self, carrier: Carrier, at_s: float) -> Array:
        rest_deg = self._request.rest_deg
        state = np.zeros((3, len(rest_deg)))
        state[0] = np.deg2rad([rest_deg[name] for name in self._platform.axis_names])
        return state.ravel()

    def start_state(self, carrier: Carrier, at_s: float) -> Array:
        return self.rest_state(carrier, at_s)

    def first_unheld(
        self, carrier: Carrier, looks: Sequence[FollowedLook], rows: Sequence[int]
    ) -> tuple[int, float] | None:
        """None: a branch is followed alike, whatever came before."""
        return None

    def probability(self, sight: Sight, which: Indices, t_s: Array, ephemeris: Ephemeris) -> Array:
        before, los, after = self._los(sight, which, t_s)
        angle_rad = axis_angles(self._platform, los).angle_rad[0]
        rows = np.flatnonzero(np.isfinite(angle_rad).all(axis=1))
        probability = np.zeros(len(t_s))
        if not len(rows):
            return probability
        seen = sight.sighting(which[rows], t_s[rows])
        instants = Instants(sight.carrier.start_utc, t_s[rows])
        line_of_sight = LineOfSight(
            instants=instants,
            states=ephemeris.states(instants),
            los_base=los[rows],
            los_rate_base_per_s=(after - before)[rows] / (2.0 * OPTIONS.delta_s),
            los_acceleration_base_per_s2=np.full((len(rows), 3), math.nan),
            range_m=seen.range_m,
            clearance_rad=seen.elevation_rad,
        )
        probability[rows] = probabilities_at(
            line_of_sight,
            ephemeris,
            self._request.opportunities().law,
            visible_target(sight, which[rows]),
            self._platform,
            angle_rad[rows],
        )
        return probability

    def rest_motion(self, instants: Instants, states: OrbitStates) -> None:
        return None

    def pass_ends(self, start_utc: datetime, stop_utc: datetime, *, is_first: bool) -> PassEnds:
        rest_deg = self._request.rest_deg
        rest = BenchMotionTarget(
            axes={name: ConstantRate(angle_deg=angle_deg, rate_deg_s=0.0)
                  for name, angle_deg in rest_deg.items()}
        )  # fmt: skip
        rest_utc = shifted_utc(stop_utc, -OPTIONS.rest_rows * COMMAND_STEP_S)
        return PassEnds(
            attitude=self._request.opportunities().law,
            initial_state=InitialState(epoch=start_utc, angles_deg=rest_deg),
            rest=(Session(target=rest, start=rest_utc, stop=stop_utc),),
            final_state=None,
            slew=self._request.slew,
            final_by=None,
        )

    def _los(self, sight: Sight, which: Indices, t_s: Array) -> tuple[Array, Array, Array]:
        """Where targets are seen in the platform's frame before, then and after, (n, 3) each."""
        before, los, after = (
            sight.sighting(which, at_s).los_base
            for at_s in (t_s - OPTIONS.delta_s, t_s, t_s + OPTIONS.delta_s)
        )
        return before, los, after

    def _whole_turns(self, angle_rad: Array) -> Iterator[Array]:
        """The angles (n, 2) whole turns away, as far as the stops can let them be."""
        choices = [
            range(
                math.floor((limits.angle_min_rad + math.pi) / TURN_RAD),
                math.ceil((limits.angle_max_rad - math.pi) / TURN_RAD) + 1,
            )
            for limits in self._platform.axis_limits
        ]
        for turns in itertools.product(*choices):
            yield angle_rad + TURN_RAD * np.array(turns)


def _longest_s(axis: AxisLimits, travel_rad: float, tracks: int) -> float:
    """Two changes between rest and the greatest rate, and as many at each track it joins."""
    rate, acceleration = axis.rate_max_rad_s, axis.acceleration_max_rad_s2
    changes_s = 2.0 * (rate / acceleration + acceleration / axis.jerk_max_rad_s3)
    return travel_rad / rate + 2.0 * tracks * rate / acceleration + changes_s


def _keep_limits(axis_states: Array, limits: tuple[AxisLimits, ...]) -> Mask:
    """Which states (n, 3, 2) keep every limit; NaN keeps none."""
    margin_rad = np.array([(1.0 - OPTIONS.within) * axis.rate_max_rad_s for axis in limits])
    low = np.array([axis.angle_min_rad for axis in limits]) + margin_rad
    high = np.array([axis.angle_max_rad for axis in limits]) - margin_rad
    rate = OPTIONS.within * np.array([axis.rate_max_rad_s for axis in limits])
    acceleration = OPTIONS.within * np.array([axis.acceleration_max_rad_s2 for axis in limits])
    angle_rad, rate_rad_s, acceleration_rad_s2 = np.moveaxis(axis_states, 1, 0)
    kept = (angle_rad >= low) & (angle_rad <= high) & (np.abs(rate_rad_s) <= rate)
    return np.asarray((kept & (np.abs(acceleration_rad_s2) <= acceleration)).all(axis=1))
