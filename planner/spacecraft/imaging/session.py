"""The session that all requests share: orbit, clock, spacecraft, attitudes that scan, slews.

A ground arc P0 -> P1 is scanned in a given time, in every imaging mode.  The optical axis points at
the moving point, X lies along its motion over the Earth's surface as seen across the line of
sight, so that the image runs along the detector's columns: yaw steering against Earth rotation
and any azimuth follow by themselves.
"""

import math
from dataclasses import dataclass
from datetime import datetime, timedelta
from functools import cached_property

import numpy as np

from planner.base.arrays import Array, Indices, Mask
from planner.base.commands import COMMAND_STEP_S, ROWS_PER_S
from planner.base.compiled import compiled
from planner.base.rotation import Rotation
from planner.motion.attitude.track import pointed_quaternions
from planner.planning.campaigns.platforms.body import OPTIONS as FOLLOWING
from planner.planning.campaigns.platforms.body import moving_state, slew_limits
from planner.planning.campaigns.platforms.slew_fits import SUFFICIENT, FollowerLimits, slew_fits
from planner.planning.opportunities.carrier import Carrier, carrier_over
from planner.planning.opportunities.platforms.lookout import Lookout
from planner.planning.opportunities.platforms.registry import lookout_of
from planner.planning.opportunities.sights import scan_sight
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.vehicle import AgileSpacecraft
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants, elapsed_s, shifted_utc
from planner.world.orbits import Ephemeris
from planner.world.platforms import BodyPlatform
from planner.world.targets.ground_path import GroundPathTarget
from planner.world.targets.imaging import ScanWindow

_ORBIT_MARGIN = timedelta(seconds=200)  # scans are continued beyond the session


@dataclass(frozen=True, kw_only=True)
class GroundArc:
    """An arc over the ground, scanned from `start_s` on: a strip, look or leg of a request, by its
    number.

    path: of the line plane.  start_s: seconds since the session's epoch when its first point is
    under the slit.  backwards: the detector runs in its other sense (X against the motion).
    """

    path: GroundPathTarget
    request: int = 0
    look: int = 0
    start_s: float = 0.0
    backwards: bool = False

    @property
    def duration_s(self) -> float:
        return self.path.duration_s

    def point_itrf(self, share: Array) -> tuple[Array, Array]:
        """As of `PlaneArc`."""
        assert self.path.plane_arc is not None
        return self.path.plane_arc.point_itrf(share)

    @property
    def scan_s(self) -> float:
        """Of whole rows that cover its scan."""
        return math.ceil(self.duration_s * ROWS_PER_S - 1e-6) / ROWS_PER_S

    @property
    def stop_s(self) -> float:
        return self.start_s + self.scan_s

    @property
    def first_row(self) -> int:
        """Of the table, the camera on; and so until `last_row`."""
        return round(self.start_s * ROWS_PER_S)

    @property
    def last_row(self) -> int:
        return round(self.stop_s * ROWS_PER_S)


@dataclass(frozen=True, kw_only=True)
class Slews:
    """Of a body.  more_s: added to what suffices, so that slews are gentler.

    Ends are states as `body_fits` takes them, (n, 11): a scan's entry that in which its line is
    joined, settle_s before it begins.
    """

    platform: BodyPlatform
    more_s: float = 0.0

    @cached_property
    def limits(self) -> tuple[FollowerLimits, float]:
        return slew_limits(self.platform)

    @property
    def settle_s(self) -> float:
        """On a line before its scan begins."""
        return self.platform.envelope.settle_s

    @property
    def widest_ticks(self) -> int:
        """The most from any scan's end to another's begin."""
        return math.ceil((self.limits[1] + self.settle_s + self.more_s) / COMMAND_STEP_S)

    def ticks(self, exit_states: Array, entry_states: Array) -> Indices:
        """Whole ticks that suffice from each of n scans' ends to its counterpart's begin."""
        too_few = np.zeros(len(exit_states), np.intp)
        enough = np.full_like(too_few, self.widest_ticks)
        while (enough - too_few).max(initial=0) > 1:
            middle = (too_few + enough) // 2
            left_s = middle * COMMAND_STEP_S - self.settle_s - self.more_s + 1e-9
            fits = _fit(exit_states, entry_states, self.limits[0], np.asarray(left_s, np.float64))
            too_few, enough = np.where(fits, too_few, middle), np.where(fits, middle, enough)
        return enough


@compiled
def _fit(exit_states: Array, entry_states: Array, limits: FollowerLimits, left_s: Array) -> Mask:
    fits = np.empty(len(left_s), np.bool_)
    for k, most_s in enumerate(left_s):
        start, end = exit_states[k], entry_states[k]
        fits[k] = most_s > 0.0 and slew_fits(start, end, limits, SUFFICIENT, most_s)
    return fits


@dataclass(frozen=True, kw_only=True)
class ImagingSession:
    """Times are seconds since the session's start; duration_s: a whole number of ticks.

    slews: of the spacecraft as the pipeline of a body turns it.
    """

    request: ImagingPlanRequest
    ephemeris: Ephemeris
    duration_s: float
    spacecraft: AgileSpacecraft
    slews: Slews

    @property
    def epoch_utc(self) -> datetime:
        return self.request.start

    @property
    def priorities(self) -> list[float]:
        """Of its requests."""
        return [one.priority for one in self.request.requests]

    @property
    def platform(self) -> BodyPlatform:
        return self.slews.platform

    def q_eci_from_body(self, arc: GroundArc | None, begins_s: Array, t_s: Array) -> Rotation:
        """n attitudes on an arc whose scans begin then, or in orbital orientation.

        Geometric: light time and aberration shift the image by 16 m along the track, alike for
        every point, and refraction by less than 5 m at 45 deg; both are left out.
        """
        instants = Instants(self.epoch_utc, t_s)
        states = self.ephemeris.states(instants)
        toward_eci, along_eci = -states.r_sat_eci_m, states.v_sat_eci_m_s
        if arc is not None:
            c_itrf = c_itrf_from_eci(instants)
            r_point_eci_m, motion_eci = (
                np.einsum("nji,nj->ni", c_itrf, of)
                for of in arc.point_itrf((t_s - begins_s) / arc.duration_s)
            )
            toward_eci = toward_eci + r_point_eci_m
            along_eci = -motion_eci if arc.backwards else motion_eci
        toward_eci = toward_eci / np.linalg.norm(toward_eci, axis=1, keepdims=True)
        along_body = np.array([1.0, 0.0, 0.0])
        return Rotation.from_quat(
            pointed_quaternions(toward_eci, along_eci, self.platform.boresight_body, along_body)
        )

    def ends(self, arc: GroundArc | None, begins_s: Array, after_s: float | Array) -> Array:
        """States as of `Slews`, so long after the scans of an arc begin, (n, 11); None: in orbital
        orientation."""
        t_s = begins_s + after_s
        around_s = t_s - FOLLOWING.delta_s, t_s, t_s + FOLLOWING.delta_s
        return moving_state(*(self.q_eci_from_body(arc, begins_s, at_s) for at_s in around_s))

    @property
    def initial_state(self) -> Array | None:
        """At rest in the request's initial attitude, if it has one, (1, 11)."""
        q_xyzw = self.request.initial_q_body_from_eci_xyzw
        return None if q_xyzw is None else moving_state(*[Rotation.from_quat([q_xyzw]).inv()] * 3)

    def entries(self, arc: GroundArc, begins_s: Array) -> Array:
        """In which lines are joined whose scans begin then."""
        return self.ends(arc, begins_s, -self.slews.settle_s)

    @cached_property
    def _lookout(self) -> Lookout:
        return lookout_of(self.platform, None)

    @cached_property
    def _carrier(self) -> Carrier:
        return carrier_over(self.ephemeris, self._lookout, self.epoch_utc, self.window.stop_utc)

    def holds(self, arc: GroundArc, begins_s: Array) -> Mask:
        """Whether the body can follow an arc whose scans begin then, settled before, (n,)."""
        around_s = self.slews.settle_s + COMMAND_STEP_S
        sight = scan_sight(self._carrier, arc.path, None, begins_s, around_s)
        return self._lookout.held_scans(sight, begins_s, arc.scan_s).as_session

    @cached_property
    def window(self) -> ScanWindow:
        """Of all scans."""
        return ScanWindow(
            orbit=self.request.orbit,
            scanning=self.platform.scanning,
            start_utc=self.epoch_utc,
            stop_utc=shifted_utc(self.epoch_utc, self.duration_s),
        )


def make_session(request: ImagingPlanRequest) -> ImagingSession:
    """The orbit and the spacecraft of a request, made ready.

    Raises InfeasibleSlew where the gyros are too full to turn.
    """
    ephemeris = request.orbit.ephemeris(request.start - _ORBIT_MARGIN, request.stop + _ORBIT_MARGIN)
    spacecraft = request.definition()
    ticks = int(elapsed_s(request.stop, request.start) / COMMAND_STEP_S + 1e-6)
    return ImagingSession(
        request=request,
        ephemeris=ephemeris,
        duration_s=ticks * COMMAND_STEP_S,
        spacecraft=spacecraft,
        slews=Slews(platform=spacecraft.platform(request.settings.momentum_n_m_s)),
    )
