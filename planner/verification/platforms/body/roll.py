"""The angle between a camera and its roll rule, by the judge's own Earth, Sun and differences."""

import numpy as np

from planner.base.arrays import Array, cross
from planner.verification.earth import EARTH_ROTATION_RAD_S, earth_orientation
from planner.verification.earth_fixed import vertical
from planner.verification.platforms.body.options import OPTIONS
from planner.verification.platforms.body.quintic import FlownMotion, turned
from planner.verification.sky import sky_sight
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms.body import (
    AzimuthRoll,
    BodyPlatform,
    LinesAcrossMotion,
    LinesAcrossTrack,
    NearestRoll,
    PushbroomCamera,
    RollRule,
    SunSide,
)
from planner.world.scenario import Session
from planner.world.targets import BodyTarget, EarthFixedTarget


def roll_off_rad(
    platform: BodyPlatform,
    session: Session,
    instants: Instants,
    states: OrbitStates,
    flown: FlownMotion,
) -> Array:
    """Angles about the boresight between camera and rule, (n,), times the sine of the angle between
    boresight and what the rule follows, which says nothing where they meet.

    flown: at the n instants of a session.  Of a rule `nearest`, by how much the camera has turned
    about its boresight since the first: which attitude came before isn't in the table.
    """
    rule, camera = _rule_of(platform, session), platform.camera
    boresight_body = np.asarray(camera.boresight_body) / np.linalg.norm(camera.boresight_body)
    if isinstance(rule, NearestRoll):
        rate_rad_s = flown.omega_body_rad_s @ boresight_body
        turns_rad = 0.5 * (rate_rad_s[1:] + rate_rad_s[:-1]) * np.diff(instants.t_s)
        return np.asarray(np.abs(np.append(0.0, np.cumsum(turns_rad))))
    if isinstance(rule, SunSide):
        aside_body = np.asarray(rule.direction_body)
    elif isinstance(camera, PushbroomCamera):
        aside_body = np.cross(camera.line_body, boresight_body)
    else:
        aside_body = np.asarray(camera.side_body)
    boresight_eci = turned(flown.q_eci_from_body_xyzw, boresight_body)
    followed_eci = _followed_eci(rule, session, instants, states)
    followed_eci = followed_eci / np.linalg.norm(followed_eci, axis=1, keepdims=True)
    aside_eci = turned(flown.q_eci_from_body_xyzw, aside_body)
    off = np.sum(cross(boresight_eci, followed_eci) * aside_eci, axis=1)
    # Only the part of the camera's side across the boresight counts.
    along = np.sum(followed_eci * aside_eci, axis=1) - np.sum(
        followed_eci * boresight_eci, axis=1
    ) * np.sum(boresight_eci * aside_eci, axis=1)
    if camera.both_ways and not isinstance(rule, SunSide):
        along = np.abs(along)
    sine = np.linalg.norm(cross(boresight_eci, followed_eci), axis=1)
    return np.asarray(np.abs(np.arctan2(off, along)) * sine)


def _rule_of(platform: BodyPlatform, session: Session) -> RollRule:
    """The session's own; else the platform's, unless it says nothing of the target."""
    if session.roll is not None:
        return session.roll
    target = session.target
    if not isinstance(target, EarthFixedTarget):
        says_nothing = isinstance(platform.roll, LinesAcrossMotion | AzimuthRoll)
    else:
        says_nothing = isinstance(platform.roll, LinesAcrossMotion) and target.rests_on_earth
    return NearestRoll() if says_nothing else platform.roll


def _followed_eci(
    rule: RollRule, session: Session, instants: Instants, states: OrbitStates
) -> Array:
    """What the rule turns a direction of the body towards, (n, 3), of any length."""
    if isinstance(rule, SunSide):
        sun = BodyTarget(name="sun", grazing_altitude_km=0.0)
        return sky_sight(sun, instants, states).apparent_eci
    earth = earth_orientation(instants.epoch_utc, instants.t_s)
    pole_itrf = np.tile([0.0, 0.0, 1.0], (len(instants), 1))
    if isinstance(rule, LinesAcrossTrack):
        spin_rad_s = EARTH_ROTATION_RAD_S * earth.eci_from_itrf(pole_itrf)
        return np.asarray(states.v_sat_eci_m_s - cross(spin_rad_s, states.r_sat_eci_m))
    target = session.target
    if not isinstance(target, EarthFixedTarget):
        raise TypeError(f"a scenario refuses {rule.rule} for a target in the sky")
    if isinstance(rule, AzimuthRoll):
        up_itrf, _ = vertical(target.r_target_itrf_m(instants))
        east = cross(pole_itrf, up_itrf)
        east /= np.linalg.norm(east, axis=1, keepdims=True)
        azimuth_rad = np.deg2rad(rule.azimuth_deg)
        along_itrf = np.sin(azimuth_rad) * east + np.cos(azimuth_rad) * cross(up_itrf, east)
        return earth.eci_from_itrf(along_itrf)
    sooner, later = (
        target.r_target_itrf_m(Instants(instants.epoch_utc, instants.t_s + side_s))
        for side_s in (-OPTIONS.motion_difference_s, OPTIONS.motion_difference_s)
    )
    return earth.eci_from_itrf(later - sooner)
