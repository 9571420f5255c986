"""All windows of a body are found, and no others, where it is looked at every three seconds.

The reference knows no planner of attitudes: the exact orbit and apparent directions, and of each
roll rule what docs say, by vector products; rates are differences of rotation matrices.
"""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from agile_bodies import SMALLSAT, smallsat
from opportunity_requests import START, iss_request
from scipy.spatial.transform import Rotation

from planner.planning.opportunities import (
    OpportunityConditions,
    OpportunityTarget,
    find_opportunities,
)
from planner.world.exclusions import Surroundings
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits.tle import TleOrbit
from planner.world.platforms.body import (
    AzimuthRoll,
    LinesAcrossMotion,
    LinesAcrossTrack,
    NearestRoll,
    SunSide,
)
from planner.world.targets import BodyTarget, GroundTarget, MovingGroundTarget, StarTarget

DAY_S = 86400.0
CITIES = [
    GroundTarget(latitude_deg=float(latitude), longitude_deg=float(longitude))
    for latitude, longitude in zip(
        np.linspace(-50.0, 50.0, 8), (-170, -120, -70, -20, 30, 80, 130, 175), strict=True
    )
]
SHIPS = [
    MovingGroundTarget(
        latitude_deg=place.latitude_deg,
        longitude_deg=place.longitude_deg,
        epoch=START,
        speed_m_s=200.0,
        course_deg=70.0,
    )
    for place in CITIES
]
TRACKERS = SMALLSAT["star_trackers"]["each"] + [
    {"name": "st3", "boresight_body": [0.1, 0.9, -0.2], "sun_deg": 50.0, "limb_deg": 30.0}
]
FRAME = {"type": "frame", "field_of_view_deg": [2.0, 1.5]}
SLOW = {
    "limits": "axis",
    "rate_max_deg_s": [0.4, 0.9, 0.6],
    "acceleration_max_deg_s2": [0.12, 0.1, 0.1],
    "jerk_max_deg_s3": [0.06, 0.05, 0.05],
}
TILTED = FRAME | {"boresight_body": [0.1, 0.3, 0.9], "side_body": [0.9, 0.0, -0.1]}
BODIES = {
    "nearest to a Sun idle": ({}, CITIES),
    "lines across the track, both ways, two trackers of three": (
        {
            "roll": {"rule": "lines_across_track"},
            "camera": TILTED,
            "star_trackers": {"needed": 2, "each": TRACKERS},
            "off_nadir_max_deg": 60.0,
        },
        CITIES,
    ),
    "a body too slow for what passes below": (
        {
            "roll": {"rule": "lines_across_track"},
            "agility": SLOW,
            "torque_max_n_m": None,
            "camera": TILTED,
            "off_nadir_max_deg": 70.0,
            "exclusions": [],
            "star_trackers": None,
        },
        CITIES,
    ),
    "panels to the Sun": (
        {"roll": {"rule": "sun_side", "direction_body": [-1.0, 0.2, 0.0]}, "camera": FRAME},
        [*CITIES[:4], StarTarget(name="Vega")],
    ),
    "an azimuth, and nearest to a nadir idle in the sky": (
        {
            "roll": {"rule": "azimuth", "azimuth_deg": 30.0},
            "camera": FRAME,
            "idle": {"law": "nadir"},
        },
        [*CITIES[4:], StarTarget(name="Sirius"), BodyTarget(name="moon")],
    ),
    "lines across the motion of a ship": ({"camera": SMALLSAT["camera"]}, SHIPS),
    "each target by a rule of its own": ({"camera": TILTED}, [*CITIES, SHIPS[0], SHIPS[5]]),
}
MORNING = TleOrbit(
    line1="1 99001U          15058.50000000  .00000000  00000-0  00000-0 0    06",
    line2="2 99001  97.6400 317.0000 0008000  90.0000   0.0000 15.04000000    05",
)
OWN_ROLLS = (
    AzimuthRoll(azimuth_deg=-40.0),
    None,
    LinesAcrossTrack(),
    SunSide(direction_body=(-1.0, 0.2, 0.0)),
    AzimuthRoll(azimuth_deg=65.0),
    NearestRoll(),
    None,
    LinesAcrossTrack(),
    LinesAcrossMotion(),
    AzimuthRoll(azimuth_deg=-40.0),
)


def unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def between(one, other):
    return np.arctan2(np.linalg.norm(np.cross(one, other), axis=1), np.sum(one * other, axis=1))


def frames(z, x):
    """Rotation matrices whose columns are x as far as it is across z, their product, and z."""
    x = unit(x - np.sum(x * z, axis=-1, keepdims=True) * z)
    return np.stack([x, np.cross(z, x), z], axis=-1)


class Sky:
    """The orbit and a target at instants, GCRF."""

    def __init__(self, request, target, t_s):
        self.instants = Instants(request.start, t_s)
        margin = timedelta(seconds=5)
        ephemeris = request.orbit.ephemeris(request.start - margin, request.stop + margin)
        self.states = ephemeris.states(self.instants)
        seen = target.apparent(self.instants, self.states)
        self.los, self.clearance_rad = seen.direction_eci, seen.clearance_rad
        self.target = target

    def sun(self):
        return BodyTarget(name="sun").apparent(self.instants, self.states).direction_eci

    def over_ground(self, place_m, later_m):
        """Of places in ITRF one second apart, GCRF."""
        return np.einsum("nji,nj->ni", c_itrf_from_eci(self.instants), later_m - place_m)


def attitudes(platform, sky, roll, rule):
    """Every way to lie, c_eci_from_body (n, 3, 3) each, by the words of the rule."""
    camera, body = platform.camera, platform
    mount = frames(body.boresight_body, camera.c_payload_from_body[0])
    if rule == "nearest":
        before = idle(platform, sky)
        there = np.einsum("nij,j->ni", before, body.boresight_body)
        axis = unit(np.cross(there, sky.los))
        turn = Rotation.from_rotvec(axis * between(there, sky.los)[:, None])
        return [turn.as_matrix() @ before]
    if rule == "sun_side":
        panels = np.array(roll.direction_body)
        return [frames(sky.los, sky.sun()) @ frames(body.boresight_body, panels).T]
    if rule == "azimuth":
        place = sky.target.r_target_itrf_m(sky.instants)
        up = unit(place * np.array([1.0, 1.0, 1.0 / (1.0 - 1.0 / 298.257223563) ** 2]))
        east = unit(np.cross([0.0, 0.0, 1.0], up))
        angle = np.deg2rad(roll.azimuth_deg)
        along = np.sin(angle) * east + np.cos(angle) * np.cross(up, east)
        x = sky.over_ground(np.zeros_like(along), along)
    elif rule == "lines_across_track":
        c = c_itrf_from_eci(sky.instants)
        r, v = (np.einsum("nij,nj->ni", c, one) for one in vars(sky.states).values())
        earth_rad_s = np.array([0.0, 0.0, 7.292115e-5])
        x = sky.over_ground(np.zeros_like(r), v - np.cross(earth_rad_s, r))
    else:
        later = Instants(sky.instants.epoch_utc, sky.instants.t_s + 0.5)
        x = sky.over_ground(*(sky.target.r_target_itrf_m(one) for one in (sky.instants, later)))
    senses = (1.0, -1.0) if camera.both_ways else (1.0,)
    return [frames(sky.los, sense * x) @ mount.T for sense in senses]


def idle(platform, sky):
    law = platform.idle
    if law.law == "nadir":
        r, v = vars(sky.states).values()
        body = frames(np.array(law.direction_body), np.array(law.forward_body))
        return frames(-unit(r), v) @ body.T
    north = np.tile([0.0, 0.0, 1.0], (len(sky.los), 1))
    body = frames(np.array(law.direction_body), np.array(law.north))
    return frames(sky.sun(), north) @ body.T


def exclusion_margin(platform, sky, c_eci_from_body):
    around = Surroundings(sky.instants, sky.states)

    def apart(direction_body, celestial, least_deg):
        direction = np.einsum("nij,j->ni", c_eci_from_body, unit(np.array(direction_body)))
        return around.margin_rad(direction, celestial, least_deg)

    kept = [
        apart(platform.direction_of(one), one.body, one.kept_deg) for one in platform.exclusions
    ]
    trackers = platform.star_trackers
    if trackers is not None:
        each = [
            np.min([apart(one.boresight_body, *angle) for angle in one.least_deg], axis=0)
            for one in trackers.each
        ]
        kept.append(np.sort(each, axis=0)[-trackers.needed])
    return np.min(kept, axis=0, initial=np.pi)


def rate_margin(platform, before, after, step_s, nearest):
    """In shares of the limit; nearest: without what turns about the line of sight."""
    turn = Rotation.from_matrix(np.swapaxes(before, 1, 2) @ after).as_rotvec() / step_s
    if nearest:
        turn -= (turn @ platform.boresight_body)[:, None] * platform.boresight_body
    shares = turn / platform.envelope.by_order_rad[0]
    if platform.envelope.limits == "axis":
        return 1.0 - np.max(np.abs(shares), axis=1)
    return 1.0 - np.linalg.norm(shares, axis=1)


def margin_of(request, target, own_roll, t_s):
    """The least of all margins, (n,), of the better way."""
    platform = request.platform
    roll = own_roll or platform.roll
    rule = roll.rule
    sky = Sky(request, target, t_s)
    on_earth = isinstance(target, GroundTarget | MovingGroundTarget)
    if (rule == "lines_across_motion" and not isinstance(target, MovingGroundTarget)) or (
        rule == "azimuth" and not on_earth
    ):
        rule = "nearest"
    least = sky.clearance_rad.copy()
    if on_earth:
        off_nadir = between(sky.los, -sky.states.r_sat_eci_m)
        least = np.minimum(least, np.deg2rad(platform.off_nadir_max_deg) - off_nadir)
    rows = np.flatnonzero(least > -0.01)
    best = np.full(len(rows), -np.inf)
    now, before, after = (Sky(request, target, t_s[rows] + by_s) for by_s in (0.0, -0.1, 0.1))
    for way, back, forth in zip(
        *(attitudes(platform, sky, roll, rule) for sky in (now, before, after)), strict=True
    ):
        kept = exclusion_margin(platform, now, way)
        moves = rate_margin(platform, back, forth, 0.2, rule == "nearest")
        best = np.maximum(best, np.minimum(kept, moves))
    least[rows] = np.minimum(least[rows], best)
    return least


@pytest.mark.parametrize("case", BODIES)
def test_windows_of_a_body_are_those_seen(case):
    changes, targets = BODIES[case]
    rolls = OWN_ROLLS if "of its own" in case else (None,) * len(targets)
    request = iss_request(
        days=1.0,
        platform=smallsat(**changes),
        targets=tuple(
            OpportunityTarget(id=str(number), target=target, roll=roll)
            for number, (target, roll) in enumerate(zip(targets, rolls, strict=True))
        ),
        conditions=OpportunityConditions(),
    )
    found = find_opportunities(request).windows
    span_s = (request.stop - request.start).total_seconds()
    t_s = np.arange(0.5, span_s, 3.0)  # shorter windows: test_opportunities_grazing.py
    seen = 0
    for row, target in enumerate(targets):
        own = found.select(found.target == row)
        is_found = np.zeros(len(t_s), bool)
        for rise_s, set_s in zip(own.rise_s, own.set_s, strict=True):
            is_found |= (t_s > rise_s) & (t_s < set_s)
        margin = margin_of(request, target, rolls[row], t_s)
        # Tables, and sunglint as it leaves the horizon, are within this.
        is_clear = np.abs(margin) > 1e-5
        wrong = np.flatnonzero(is_clear & (is_found != (margin > 0.0)))
        assert not wrong.size, (row, t_s[wrong][:5], margin[wrong][:5], len(wrong))
        seen += np.count_nonzero(is_found)
    assert seen > 20, seen


def test_a_session_isnt_held_where_one_star_tracker_takes_over_too_late_from_another():
    """For less than the second between looks; by the better sense of the rule on rows of 0.2 s."""
    each = [
        tracker | {"sun_deg": sun_deg, "limb_deg": limb_deg}
        for tracker, sun_deg, limb_deg in zip(
            TRACKERS[:2], (53.195475, 47.311956), (36.306088, 42.80303), strict=True
        )
    ]
    roll, target = LinesAcrossTrack(), GroundTarget(latitude_deg=12.97194, longitude_deg=77.59369)
    start = datetime(2015, 2, 28, 5, tzinfo=UTC)
    request = iss_request(
        days=0.0,
        platform=smallsat(star_trackers={"needed": 1, "each": each}),
        orbit=MORNING,
        start=start,
        stop=start + timedelta(minutes=30),
        targets=(OpportunityTarget(id="Bengaluru", target=target, roll=roll),),
        conditions=OpportunityConditions(),
    )
    found = find_opportunities(request).windows
    [held_from_s], [held_to_s] = found.held_from_s, found.held_to_s
    assert held_to_s - held_from_s > 20.0
    inside = np.linspace(held_from_s, held_to_s, round((held_to_s - held_from_s) / 0.2) + 1)
    before = np.arange(found.rise_s[0] + 5.0, held_from_s - 0.2, 0.05)
    for t_s, is_held in ((inside, True), (before, False)):
        sky = Sky(request, target, t_s)
        least_rad = max(
            exclusion_margin(request.platform, sky, way).min()
            for way in attitudes(request.platform, sky, roll, roll.rule)
        )
        assert (least_rad > 0.0) == is_held, least_rad
