"""A body's camera stays on its target as the roll rule says, or the refusal names limit and time.

The orbit is a circle, so that directions, rates and the pass overhead follow by hand.
"""

import dataclasses
import math
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from agile_bodies import SMALLSAT, smallsat
from scipy.spatial.transform import Rotation, RotationSpline

from planner.base.errors import NotVisible, TrackBreaksLimit, Unreachable
from planner.motion.attitude.idle import idle_attitude
from planner.motion.attitude.track import TargetSight, attitude_tracks, roll_rule
from planner.world.exclusions import Surroundings
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms.body import (
    AzimuthRoll,
    Exclusion,
    InertialIdle,
    LinesAcrossMotion,
    LinesAcrossTrack,
    MagnitudeAgility,
    NadirIdle,
    NearestRoll,
    SunIdle,
    SunSide,
)
from planner.world.targets import BodyTarget, GroundPathTarget, GroundTarget, StarTarget
from planner.world.targets.ground_path import PathPoint

EPOCH = datetime(2026, 6, 1, 10, 40, tzinfo=UTC)
RADIUS_M = 6878e3
RATE_RAD_S = math.sqrt(3.986004418e14 / RADIUS_M**3)
INCLINATION_RAD = math.radians(97.0)
AGILE = MagnitudeAgility(rate_max_deg_s=3.0, acceleration_max_deg_s2=0.5, jerk_max_deg_s3=0.5)
START_S, STOP_S = 20.0, 40.0
ACROSS_TRACK, NEAREST = LinesAcrossTrack(), NearestRoll()


def rows(start_s=0.0, stop_s=60.0):
    return Instants(EPOCH, np.arange(round(start_s * 5), round(stop_s * 5) + 1) / 5.0)


def circle(instants):
    """States of a circular orbit that comes north over the equator at the epoch."""
    angle = RATE_RAD_S * instants.t_s
    x, y = (
        np.array([1.0, 0.0, 0.0]),
        np.array([0.0, math.cos(INCLINATION_RAD), math.sin(INCLINATION_RAD)]),
    )
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return OrbitStates(RADIUS_M * (c * x + s * y), RADIUS_M * RATE_RAD_S * (c * y - s * x))


def place_below(at_s, off_m=(0.0, 0.0)):
    """Latitude and longitude under the satellite, and so far north and east of it, deg."""
    instants = Instants(EPOCH, np.array([at_s]))
    r_itrf_m = c_itrf_from_eci(instants)[0] @ circle(instants).r_sat_eci_m[0]
    latitude, longitude, _ = geodetic_from_itrf(r_itrf_m)
    return (
        math.degrees(latitude + off_m[0] / 6371e3),
        math.degrees(longitude + off_m[1] / (6371e3 * math.cos(latitude))),
    )


def ground(at_s=30.0, off_m=(0.0, 60e3)):
    latitude_deg, longitude_deg = place_below(at_s, off_m)
    return GroundTarget(latitude_deg=latitude_deg, longitude_deg=longitude_deg)


def path(azimuth_deg=20.0, speed_m_s=3000.0):
    """A straight line through a place beside the track, begun with the session."""
    azimuth = math.radians(azimuth_deg)
    step = speed_m_s * 30.0 * np.array([math.cos(azimuth), math.sin(azimuth)])
    begin, end = place_below(30.0, -step), place_below(30.0, step)
    return GroundPathTarget(
        points=tuple(PathPoint(latitude_deg=at[0], longitude_deg=at[1]) for at in (begin, end)),
        speed_m_s=speed_m_s,
        start=EPOCH,
    )


def sight_of(target, instants=None):
    instants = rows() if instants is None else instants
    states = circle(instants)
    los_eci = target.apparent(instants, states).direction_eci
    return TargetSight(target=target, instants=instants, states=states, los_eci=los_eci)


def agile(**changes):
    """Without trackers and exclusions, which hang on the Sun."""
    bare = {"star_trackers": None, "exclusions": [], "torque_max_n_m": None}
    return dataclasses.replace(smallsat(**(bare | changes)), agility=AGILE)


def tracks(target, roll, platform=None, before=None):
    sight = sight_of(target)
    before = Rotation.identity() if before is None else before
    platform = agile() if platform is None else platform
    return sight, attitude_tracks(platform, roll, sight, START_S, STOP_S, before)


def both_ways(**changes):
    return agile(camera=SMALLSAT["camera"] | {"both_ways": True}, **changes)


SKY = StarTarget(ra_deg=60.0, dec_deg=-30.0, grazing_altitude_km=0.0)
RULES = [
    (path(), LinesAcrossMotion()),
    (path(), ACROSS_TRACK),
    (ground(), ACROSS_TRACK),
    (ground(), NEAREST),
    (ground(), SunSide(direction_body=(-1.0, 0.0, 0.3))),
    (ground(), AzimuthRoll(azimuth_deg=30.0)),
    (SKY, NEAREST),
    (SKY, SunSide(direction_body=(0.0, 1.0, 0.0))),
]


@pytest.mark.parametrize(("target", "roll"), RULES)
def test_boresight_stays_on_the_target_and_rates_are_those_of_the_attitude(target, roll):
    sight, [track, *_] = tracks(target, roll)
    assert track.t_s[0] <= START_S
    assert track.t_s[-1] >= STOP_S
    here = np.searchsorted(sight.instants.t_s, track.t_s)
    q_eci_from_body = Rotation.from_quat(track.motion.position)
    # rounding of directions; a pixel is 1.3e-6
    assert q_eci_from_body.apply([0.0, 0.0, 1.0]) == pytest.approx(sight.los_eci[here], abs=1e-12)
    assert np.all(np.sum(track.motion.position[1:] * track.motion.position[:-1], axis=1) > 0.9)
    # SciPy's spline of rotation vectors, with rates by its own tridiagonal system; in its middle
    # it errs by the fourth derivative: 1 deg/s (0.2 s / 60 s)^3
    spline = RotationSpline(track.t_s, q_eci_from_body)
    inside = slice(20, -20)
    t_s = track.t_s[inside]
    omega, alpha = (
        q_eci_from_body[inside].inv().apply(q_eci_from_body[inside].apply(spline(t_s, order)))
        for order in (1, 2)
    )
    assert track.motion.rate_rad_s[inside] == pytest.approx(omega, abs=2e-8)
    assert track.motion.acceleration_rad_s2[inside] == pytest.approx(alpha, abs=2e-6)


def payload_x(track):
    return Rotation.from_quat(track.motion.position).apply([1.0, 0.0, 0.0])


def ground_point(track, sight, direction_payload):
    """Where a direction beside the boresight meets the sphere through the target, ITRF."""
    here = np.searchsorted(sight.instants.t_s, track.t_s)
    q_eci_from_body = Rotation.from_quat(track.motion.position)
    direction = q_eci_from_body.apply(direction_payload / np.linalg.norm(direction_payload))
    r = sight.states.r_sat_eci_m[here]
    instants = Instants(EPOCH, track.t_s)
    c_itrf = c_itrf_from_eci(instants)
    radius_m = np.linalg.norm(sight.target.r_target_itrf_m(instants), axis=1)
    along = np.sum(r * direction, axis=1)
    depth = -along - np.sqrt(along**2 - np.sum(r * r, axis=1) + radius_m**2)
    return np.einsum("nij,nj->ni", c_itrf, r + depth[:, None] * direction)


@pytest.mark.parametrize("azimuth_deg", [0.0, 20.0, 200.0, 287.0])
def test_the_image_of_a_path_runs_across_the_line(azimuth_deg):
    """A point of the ground that the middle of the line sees is seen in the column's direction
    a moment later: its displacement in the image is square to the line."""
    target = path(azimuth_deg)
    sight, [track] = tracks(target, LinesAcrossMotion())
    on_ground = ground_point(track, sight, np.array([0.0, 0.0, 1.0]))
    k, later = 150, 153
    instants = Instants(EPOCH, track.t_s[[later]])
    here = np.searchsorted(sight.instants.t_s, track.t_s[[later]])
    point_eci = c_itrf_from_eci(instants)[0].T @ on_ground[k]
    los = point_eci - sight.states.r_sat_eci_m[here][0]
    seen = Rotation.from_quat(track.motion.position[later]).inv().apply(los / np.linalg.norm(los))
    # aberration, which the mirror image of the ground leaves out, turns with the line of sight by
    # 2.5e-5 (0.6 s x 7.6 km / 600 km) = 2e-7; the line's bend over 0.6 s is of the same size
    assert seen[0] < -2e-3  # it has moved towards -X: the camera scans towards +X
    assert abs(seen[1]) < 2e-6


def test_lines_across_the_track_lie_square_to_the_motion_over_the_turning_earth():
    sight, [track] = tracks(ground(), ACROSS_TRACK)
    here = np.searchsorted(sight.instants.t_s, track.t_s)
    states = sight.states
    omega_earth = np.array([0.0, 0.0, 7.2921151e-5])  # rad/s; the pole is 0.15 deg off GCRF's
    v_over_earth = states.v_sat_eci_m_s - np.cross(omega_earth, states.r_sat_eci_m)
    line = Rotation.from_quat(track.motion.position).apply([0.0, 1.0, 0.0])
    cosine = np.sum(line * v_over_earth[here], axis=1) / np.linalg.norm(v_over_earth[here], axis=1)
    assert cosine == pytest.approx(0.0, abs=2e-4)  # 0.15 deg of 500 m/s beside 7.5 km/s
    assert np.all(np.sum(payload_x(track) * v_over_earth[here], axis=1) > 0.0)


def test_the_nearest_attitude_is_turned_least_and_then_not_about_the_line_of_sight():
    before = Rotation.from_euler("xyz", [30.0, -20.0, 140.0], degrees=True)
    _, [track] = tracks(ground(), NEAREST, before=before)
    first = int(np.searchsorted(track.t_s, START_S))
    q = Rotation.from_quat(track.motion.position[first])
    turned = (before.inv() * q).magnitude()
    about_los = [
        (before.inv() * Rotation.from_rotvec(roll * q.apply([0.0, 0.0, 1.0])) * q).magnitude()
        for roll in np.linspace(-math.pi, math.pi, 721)
    ]
    assert turned <= min(about_los) + 1e-12
    # what the chords between rows leave: 1e-8 rad/s (0.2 s, 1 deg/s, bent by 0.01 deg/s2)
    assert track.motion.rate_rad_s[:, 2] == pytest.approx(0.0, abs=2e-8)


def test_the_sun_side_is_turned_to_the_sun_as_far_as_it_goes():
    side = np.array([-1.0, 0.0, 0.3])
    sight, [track] = tracks(ground(), SunSide(direction_body=tuple(side)))
    here = np.searchsorted(sight.instants.t_s, track.t_s)
    sun = Surroundings(sight.instants, sight.states).disk("sun")[0][here]
    q = Rotation.from_quat(track.motion.position)
    towards = np.sum(q.apply(side) * sun, axis=1)
    for roll_rad in np.linspace(0.05, 6.2, 40):
        turned = q * Rotation.from_rotvec([0.0, 0.0, roll_rad])
        assert np.all(np.sum(turned.apply(side) * sun, axis=1) < towards)


def test_an_azimuth_is_that_of_the_scan_at_the_target():
    """The camera's +X, followed a little way over the ground, leaves the target by the azimuth."""
    target = ground(off_m=(0.0, 5e3))
    sight, [track] = tracks(target, AzimuthRoll(azimuth_deg=30.0))
    place, ahead = (ground_point(track, sight, np.array([x, 0.0, 1.0])) for x in (0.0, 1e-3))
    latitude, longitude, _ = geodetic_from_itrf(place[150])
    latitude_ahead, longitude_ahead, _ = geodetic_from_itrf(ahead[150])
    azimuth = math.atan2(
        (longitude_ahead - longitude) * math.cos(latitude), latitude_ahead - latitude
    )
    # looked at from the side by 6 deg at most, and the sphere for the ellipsoid: 0.4 deg
    assert math.degrees(azimuth) == pytest.approx(30.0, abs=0.5)


def test_a_camera_that_images_both_ways_has_two_senses_and_the_nearer_goes_first():
    before = Rotation.from_quat(tracks(path(), LinesAcrossMotion())[1][0].motion.position[100])
    for turn_deg, is_reversed in ((0.0, [False, True]), (180.0, [True, False])):
        turned = before * Rotation.from_rotvec([0.0, 0.0, math.radians(turn_deg)])
        _, ways = tracks(path(), LinesAcrossMotion(), both_ways(), turned)
        assert [way.is_reversed for way in ways] == is_reversed
        assert payload_x(ways[0]) == pytest.approx(-payload_x(ways[1]), abs=1e-12)


def refusal_of(kind, target, roll, platform=None):
    with pytest.raises(kind) as refused:
        tracks(target, roll, platform)
    return refused.value


def test_a_target_too_far_off_nadir_is_refused_with_the_first_time():
    refusal = refusal_of(Unreachable, ground(off_m=(0.0, 900e3)), NEAREST)
    assert refusal.limit == "off_nadir"
    assert refusal.at_utc == EPOCH + timedelta(seconds=START_S)
    assert "more than the 40" in refusal.detail


def test_off_nadir_says_nothing_of_the_sky():
    sight, [track] = tracks(SKY, NEAREST)
    nadir = -sight.states.r_sat_eci_m / RADIUS_M
    assert np.all(np.sum(sight.los_eci * nadir, axis=1) < 0.5)
    assert len(track.t_s) == len(sight.instants)


@pytest.mark.parametrize(
    ("limits", "limit"),
    [
        ({"rate_max_deg_s": 0.7}, "rate"),
        ({"acceleration_max_deg_s2": 0.002}, "acceleration"),
        ({"jerk_max_deg_s3": 0.0002}, "jerk"),
    ],
)
def test_a_limit_that_following_the_target_breaks_is_named(limits, limit):
    """Passed overhead at 500 km it takes 7.1 km/s / 500 km = 0.82 deg/s at most."""
    platform = dataclasses.replace(agile(), agility=dataclasses.replace(AGILE, **limits))
    refusal = refusal_of(TrackBreaksLimit, ground(off_m=(0.0, 0.0)), NEAREST, platform)
    assert refusal.limit == limit
    assert START_S <= (refusal.at_utc - EPOCH).total_seconds() <= STOP_S


def test_rate_overhead_is_the_relative_speed_over_the_height():
    sight, [track] = tracks(ground(off_m=(0.0, 0.0)), NEAREST)
    k = int(np.argmin(np.abs(track.t_s - 30.0)))
    states, instants = sight.states, Instants(EPOCH, np.array([30.0]))
    r_itrf_m = sight.target.r_target_itrf_m(instants)[0]
    omega_earth = np.array([0.0, 0.0, 7.2921151e-5])
    r_target_m = c_itrf_from_eci(instants)[0].T @ r_itrf_m
    here = int(np.searchsorted(sight.instants.t_s, track.t_s[k]))
    v = states.v_sat_eci_m_s[here] - np.cross(omega_earth, r_target_m)
    height_m = np.linalg.norm(states.r_sat_eci_m[here] - r_target_m)
    # aberration bends by 2.5e-5 and turns with the line of sight by as much of its rate
    assert np.linalg.norm(track.motion.rate_rad_s[k]) == pytest.approx(
        np.linalg.norm(v) / height_m, rel=1e-3
    )


def test_where_the_image_stands_still_lines_across_the_motion_are_refused():
    refusal = refusal_of(TrackBreaksLimit, ground(), LinesAcrossMotion())
    assert refusal.limit == "rate"
    assert "stands still" in refusal.detail
    # turned back on its own line: between the legs the point stops, and the line turns half over
    there, back = place_below(30.0, (-30e3, 0.0)), place_below(30.0, (30e3, 0.0))
    corner = GroundPathTarget(
        points=tuple(
            PathPoint(latitude_deg=at[0], longitude_deg=at[1]) for at in (there, back, there)
        ),
        speed_m_s=2000.0,
        corner_s=4.0,
        start=EPOCH,
    )
    refusal = refusal_of(TrackBreaksLimit, corner, LinesAcrossMotion())
    assert refusal.limit in ("rate", "acceleration", "jerk")
    # the corner is passed 60 km / 2 km/s = 30 s after the epoch
    assert (refusal.at_utc - EPOCH).total_seconds() == pytest.approx(30.0, abs=2.5)


def test_a_rule_that_says_nothing_of_a_target_gives_way_to_the_nearest_unless_asked_for():
    across_motion = agile()
    assert roll_rule(across_motion, ground(), None) == NEAREST
    assert roll_rule(across_motion, SKY, None) == NEAREST
    assert roll_rule(across_motion, path(), None) == LinesAcrossMotion()
    assert roll_rule(across_motion, path(), ACROSS_TRACK) == ACROSS_TRACK
    azimuth = dataclasses.replace(agile(), roll=AzimuthRoll(azimuth_deg=3.0))
    assert roll_rule(azimuth, ground(), None) == AzimuthRoll(azimuth_deg=3.0)
    assert roll_rule(azimuth, SKY, None) == NEAREST
    refusal = refusal_of(TrackBreaksLimit, SKY, AzimuthRoll(azimuth_deg=3.0))
    assert refusal.field == "roll"


def test_an_exclusion_in_the_way_is_named():
    sun = Exclusion(name="camera Sun", of="camera", away_from="sun", min_deg=5.0)
    platform = dataclasses.replace(agile(), exclusions=(sun,))
    target = BodyTarget(name="sun", grazing_altitude_km=0.0)
    refusal = refusal_of(NotVisible, target, NEAREST, platform)
    assert refusal.limit == "exclusion"
    assert "camera Sun" in refusal.detail


def test_the_nadir_attitude_turns_once_an_orbit_about_the_pitch_axis():
    """On a circle: -n about body y (against the orbit normal), and no acceleration."""
    instants = rows()
    motion = idle_attitude(NadirIdle(), instants, circle(instants))
    n = len(instants)
    assert motion.rate_rad_s == pytest.approx(np.tile([0.0, -RATE_RAD_S, 0.0], (n, 1)), abs=1e-11)
    assert motion.acceleration_rad_s2 == pytest.approx(np.zeros((n, 3)), abs=1e-10)
    q = Rotation.from_quat(motion.position)
    assert q.apply([0.0, 0.0, 1.0]) == pytest.approx(
        -circle(instants).r_sat_eci_m / RADIUS_M, abs=1e-12
    )


def test_the_sun_attitude_looks_at_the_sun_and_hardly_turns():
    instants = rows()
    states = circle(instants)
    motion = idle_attitude(SunIdle(direction_body=(0.0, 0.0, -1.0)), instants, states)
    panels = Rotation.from_quat(motion.position).apply([0.0, 0.0, -1.0])
    assert panels == pytest.approx(Surroundings(instants, states).disk("sun")[0], abs=1e-12)
    # once a year, and aberration by the orbit's 26 arcsec
    most = 2.0 * math.pi / (365.25 * 86400.0) * 1.1 + 1.3e-4 * RATE_RAD_S
    assert np.all(np.linalg.norm(motion.rate_rad_s, axis=1) < most)


def test_the_inertial_attitude_stands_still():
    q_body_from_eci = Rotation.from_euler("xyz", [10.0, 20.0, 200.0], degrees=True)
    law = InertialIdle(q_body_from_eci_xyzw=tuple(q_body_from_eci.as_quat()))
    motion = idle_attitude(law, rows(), circle(rows()))
    assert (q_body_from_eci * Rotation.from_quat(motion.position)).magnitude().max() < 1e-15
    assert not motion.rate_rad_s.any()
    assert motion.position[0, 3] >= 0.0
