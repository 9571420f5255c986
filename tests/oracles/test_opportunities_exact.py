"""All windows are found, and no others, where the planner itself looks every three seconds.

The reference is the chain a plan is made of: the exact orbit, the apparent
direction, the attitude law, both branches of the axes; none of the search's tables.
"""

import dataclasses
import math
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from mask_shapes import boom, inside, mask_corners, star
from opportunity_requests import ISS, ROOT, START, iss_request, oco3_targets

from planner.motion.pointing.angles import axis_angles
from planner.motion.pointing.line_of_sight import line_of_sight
from planner.planning.opportunities import (
    OpportunityConditions,
    OpportunityTarget,
    find_opportunities,
)
from planner.verification.sky import limb_clearance_rad
from planner.world.attitude.inertial import InertialAttitude
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.earth_orientation import c_itrf_from_eci
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OemOrbit, TleOrbit
from planner.world.platforms import PLATFORMS, FieldMask, PlatformDefinition
from planner.world.platforms.definition import AxisDefinition
from planner.world.targets import BodyTarget, GroundTarget, MovingGroundTarget, StarTarget

HRC = PLATFORMS["iss-hrc"]
SPINNING = InertialAttitude(
    epoch=START, q_body_from_eci_xyzw=(0.5, 0.5, 0.5, 0.5), omega_body_deg_s=(0.3, -0.2, 0.1)
)
# Made up: perigee of 700 km in the south, 12 h: long windows, high and slow, and short ones, fast
MOLNIYA = TleOrbit(
    line1="1 00001U 15001A   15058.00000000  .00000000  00000-0  00000-0 0  9997",
    line2="2 00001  63.4000 100.0000 7300000 270.0000  10.0000  2.00600000    16",
)


def stopped(platform, outer_deg, inner_deg):
    """The platform with nearer stops."""
    limits = [
        dataclasses.replace(axis, angle_min_rad=math.radians(low), angle_max_rad=math.radians(high))
        for axis, (low, high) in zip(platform.axis_limits, (outer_deg, inner_deg), strict=True)
    ]
    return dataclasses.replace(platform, outer_limits=limits[0], inner_limits=limits[1])


def _axis(name, axis_platform, low, high):
    return AxisDefinition(
        name=name,
        axis_platform=axis_platform,
        angle_min_deg=low,
        angle_max_deg=high,
        rate_max_deg_s=3.0,
        acceleration_max_deg_s2=1.0,
        jerk_max_deg_s3=1.0,
    )


# Axes 60 deg apart: directions within 30 deg of the outer axis can't be reached at all
SKEWED = PlatformDefinition(
    name="skewed",
    outer=_axis("yaw", (0.0, 0.0, 1.0), -350.0, 350.0),
    inner=_axis("tilt", (0.0, math.sin(math.pi / 3), math.cos(math.pi / 3)), -60.0, 170.0),
    zero_direction_platform=(1.0, 0.0, 0.0),
).platform()


def margins(request, wanted, t_s):
    """All of a target's margins by the exact chain, (k, n), at n uniform instants."""
    instants = Instants(request.start, t_s)
    ephemeris = request.orbit.ephemeris(
        request.start - timedelta(seconds=1), request.stop + timedelta(seconds=1)
    )
    target, asked = wanted.target, request.conditions
    los = line_of_sight(
        instants, ephemeris, request.law, request.platform.q_platform_from_body, target
    )
    states = ephemeris.states(instants)
    direction_eci = target.apparent(instants, states).direction_eci
    found = []
    on_earth = isinstance(target, GroundTarget | MovingGroundTarget)
    least_deg = max(asked.min_elevation_deg - target.min_elevation_deg, 0.0) if on_earth else 0.0
    found.append(los.clearance_rad - math.radians(least_deg))
    if asked.max_off_nadir_deg is not None and on_earth:
        nadir = -states.r_sat_eci_m / np.linalg.norm(states.r_sat_eci_m, axis=1, keepdims=True)
        found.append(math.radians(asked.max_off_nadir_deg) - between(direction_eci, nadir))
    for keep_out_deg, name in ((asked.sun_keep_out_deg, "sun"), (asked.moon_keep_out_deg, "moon")):
        if keep_out_deg is not None:
            body_eci = BodyTarget(name=name).apparent(instants, states).direction_eci
            c = c_itrf_from_eci(instants)
            above_limb = limb_clearance_rad(
                np.einsum("nij,nj->ni", c, body_eci),
                np.einsum("nij,nj->ni", c, states.r_sat_eci_m),
                0.0,
            )
            away = between(direction_eci, body_eci) - math.radians(keep_out_deg)
            found.append(np.maximum(away, -math.radians(1.5) - above_limb))
    found.append(reach(request.platform, los.los_base))
    found += [  # the exact edge, and no more than its sign
        np.where(inside(mask_corners(mask), los.los_base), -1.0, 1.0)
        for mask in request.platform.masks
    ]
    return np.array(found)


def between(one, other):
    return np.arctan2(np.linalg.norm(np.cross(one, other), axis=1), np.sum(one * other, axis=1))


def reach(platform, los_platform):
    """How far inside the stops, trying whole turns one by one."""
    angles, _ = axis_angles(platform, los_platform)
    best = np.full(len(los_platform), -math.pi)
    for branch in angles:
        inside = np.full(len(los_platform), math.inf)
        for axis, limits in enumerate(platform.axis_limits):
            turned = [branch[:, axis] + turn * 2.0 * math.pi for turn in (-2, -1, 0, 1, 2)]
            spare = [np.minimum(a - limits.angle_min_rad, limits.angle_max_rad - a) for a in turned]
            inside = np.minimum(inside, np.max(spare, axis=0))
        best = np.fmax(best, inside)
    return best


def behind(*corners):
    """The HRC behind structure."""
    masks = tuple(
        FieldMask(name=f"{number}", corners_platform=tuple(map(tuple, each.tolist())))
        for number, each in enumerate(corners)
    )
    return dataclasses.replace(HRC, masks=masks)


def rig():
    """A ragged panel ahead, and three booms of 0.2 to 1 deg that lie 1 to 3 deg apart below."""
    rng = np.random.default_rng(2)
    panel = star(rng, np.array([0.8, 0.0, 0.6]), math.radians(30.0), 12)
    booms = []
    for place_deg, half_width_deg in ((0.0, 0.1), (1.5, 0.25), (5.0, 0.5)):
        along = math.radians(place_deg - 10.0)
        middle = np.array([math.sin(along), 0.1, math.cos(along)])
        middle /= np.linalg.norm(middle)
        booms.append(
            boom(np.random.default_rng(1), middle, math.radians(35.0), math.radians(half_width_deg))
        )
    return behind(panel, *booms)


GROUND = oco3_targets(every=140)
CASES = {
    "near stops": {
        "platform": stopped(HRC, (-40.0, 25.0), (-15.0, 60.0)),
        "attitude": LvlhAttitude(yaw_deg=3.0, pitch_deg=-8.0, roll_deg=2.0),
        "targets": GROUND,
    },
    "dead zone overhead": {
        "platform": stopped(HRC, (-20.0, 330.0), (-175.0, 175.0)),
        "attitude": LvlhAttitude(roll_deg=25.0),
        "targets": GROUND,
    },
    "skewed axes": {"platform": SKEWED, "targets": GROUND},
    "spinning": {
        "platform": stopped(HRC, (-90, 60), (-90, 90)),
        "attitude": SPINNING,
        "days": 0.08,  # a constant rate is believed for two hours
        "targets": GROUND,
    },
    "all at once": {
        "platform": HRC,
        "targets": GROUND,
        "conditions": OpportunityConditions(
            min_elevation_deg=5.0,
            max_off_nadir_deg=55.0,
            sun_keep_out_deg=60.0,
            moon_keep_out_deg=90.0,
        ),
    },
    "behind structure": {"platform": rig(), "targets": GROUND},
    "behind structure, spinning": {
        "platform": rig(),
        "attitude": SPINNING,
        "days": 0.08,
        "targets": (*GROUND, OpportunityTarget(id="Sirius", target=StarTarget(hip=32349))),
    },
    "eccentric": {
        "orbit": MOLNIYA,
        "platform": HRC,
        "targets": GROUND,
        "conditions": OpportunityConditions(min_elevation_deg=25.0),
    },
    "in space and under way": {
        "platform": HRC,
        "attitude": LvlhAttitude(roll_deg=120.0),
        "conditions": OpportunityConditions(sun_keep_out_deg=30.0),
        "targets": (
            OpportunityTarget(id="Sirius", target=StarTarget(hip=32349)),
            OpportunityTarget(id="Moon", target=BodyTarget(name="moon")),
            OpportunityTarget(
                id="ship",
                target=MovingGroundTarget(
                    epoch=START,
                    latitude_deg=30.0,
                    longitude_deg=-40.0,
                    course_deg=300.0,
                    speed_m_s=250.0,
                ),
            ),
        ),
    },
}


@pytest.mark.parametrize("case", CASES)
def test_same_windows_as_by_the_planners_chain(case):
    request = iss_request(**{"days": 0.6} | CASES[case])
    windows = find_opportunities(request).windows
    assert len(windows)
    span_s = (request.stop - request.start).total_seconds()
    t_s = np.arange(0.0, span_s + 1.0, 3.0)
    for number, wanted in enumerate(request.targets):
        mine = windows.target == number
        rises, sets = windows.rise_s[mine], windows.set_s[mine]
        ours = np.zeros(len(t_s), dtype=bool)
        for rise_s, set_s in zip(rises, sets, strict=True):
            ours |= (t_s > rise_s) & (t_s < set_s)
        theirs = margins(request, wanted, t_s).min(axis=0) > 0.0
        edges_s = np.concatenate([rises, sets])
        near_edge = np.any(np.abs(t_s[:, None] - edges_s[None, :]) < 2e-3, axis=1)
        assert np.array_equal(ours[~near_edge], theirs[~near_edge])
        inner_s = edges_s[(edges_s > 1.0) & (edges_s < span_s - 1.0)]
        for edge_s in inner_s:
            around_s = edge_s + 1e-3 * np.arange(-3.0, 4.0)
            holds = margins(request, wanted, around_s).min(axis=0) > 0.0
            # the promise: the exact margin changes its sign within a millisecond of the edge
            assert holds[2] != holds[4], (wanted.id, edge_s)


def test_booms_passed_in_a_moment_break_windows():
    """At 0.05 s, in which the line of sight turns by 0.06 deg at most."""
    request = iss_request(0.6, platform=rig(), targets=oco3_targets(every=20))
    windows = find_opportunities(request).windows
    step_s, gaps = 0.05, 0
    for number, wanted in enumerate(request.targets):
        mine = windows.target == number
        if not mine.any():
            continue
        begin_s, end_s = windows.rise_s[mine].min() - 5.0, windows.rise_s[mine].min() + 700.0
        t_s = np.arange(begin_s, end_s, step_s)
        holds = margins(request, wanted, t_s).min(axis=0) > 0.0
        edges_s = t_s[:-1][np.diff(holds)] + step_s
        for rise_s, set_s in zip(windows.rise_s[mine], windows.set_s[mine], strict=True):
            if set_s < end_s - 1.0:
                assert np.abs(edges_s - rise_s).min() <= step_s
                assert np.abs(edges_s - set_s).min() <= step_s
        found_s = np.concatenate([windows.rise_s[mine], windows.set_s[mine]])
        inner_s = edges_s[edges_s < end_s - 1.0]
        assert np.abs(inner_s[:, None] - found_s).min(axis=1).max() <= step_s
        by_mask = windows.closed_by[mine] == "mask"
        gaps += np.count_nonzero(by_mask)
    assert gaps > 10


def test_samples_are_the_planners_own():
    request = iss_request(
        0.5,
        targets=oco3_targets(every=60),
        conditions=OpportunityConditions(min_elevation_deg=30.0),
    )
    windows = find_opportunities(request).windows
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    assert len(windows) > 3
    for row in range(len(windows)):
        wanted = request.targets[windows.target[row]]
        for column, at_s in enumerate(windows.through.t_s[row]):
            los = line_of_sight(
                Instants(request.start, at_s + 0.2 * np.arange(-3.0, 4.0)),
                ephemeris,
                request.law,
                HRC.q_platform_from_body,
                wanted.target,
            )
            branch = windows.branch[row]
            angles = axis_angles(HRC, los.los_base).angle_rad[branch]
            exact_rad_s = (angles[4] - angles[2]) / 0.4
            seen = windows.through
            # interpolation of orbit and attitude: 0.2 arcsec at the most
            np.testing.assert_allclose(seen.angle_rad[row, column], angles[3], rtol=0, atol=1e-6)
            # second differences of a pass over 0.2 s
            np.testing.assert_allclose(
                seen.rate_rad_s[row, column], exact_rad_s, rtol=1e-4, atol=1e-6
            )
            assert seen.range_m[row, column] == pytest.approx(los.range_m[3], abs=0.05)
            elevation_rad = los.clearance_rad[3]
            assert seen.elevation_rad[row, column] == pytest.approx(elevation_rad, abs=1e-6)


def test_ground_sample_of_the_hrc():
    """1.15 m at the nadir from 350 km (Sumarokov 2016, p. 85): in proportion to the range."""
    request = iss_request(1.0, targets=oco3_targets(every=20))
    closest = find_opportunities(request).windows.closest
    overhead = closest.elevation_rad > math.radians(85.0)
    assert overhead.any()
    expected_m = 1.15 * closest.range_m[overhead] / 350e3
    np.testing.assert_allclose(closest.ground_sample_across_m[overhead], expected_m, rtol=1e-12)
    slant = closest.ground_sample_along_m[overhead] / expected_m
    np.testing.assert_allclose(slant, 1.0, atol=4e-3)  # 1/sin(85 deg)


def test_closest_approach_is_the_least_range():
    request = iss_request(1.0, targets=oco3_targets(every=60))
    windows = find_opportunities(request).windows
    ephemeris = ISS.ephemeris(request.start, request.stop)
    for row in range(len(windows)):
        t_s = np.linspace(windows.rise_s[row], windows.set_s[row], 2001)
        target = request.targets[windows.target[row]].target
        instants = Instants(request.start, t_s)
        ranges_m = target.apparent(instants, ephemeris.states(instants)).range_m
        # the grid of 0.3 s or less meets the least range within 2 m at 7.4 km/s and 400 km
        assert windows.closest.range_m[row] <= ranges_m.min() + 0.05
        assert windows.closest.range_m[row] == pytest.approx(ranges_m.min(), abs=2.0)


def test_edges_after_a_reboost():
    """An ephemeris message with a burn of 2 s rows between rows of 240 s, and of the table."""
    orbit = OemOrbit(content=(ROOT / "tests" / "data" / "iss_oem_2022-038_excerpt.xml").read_text())
    burning = datetime(2022, 2, 8, 7, 56, tzinfo=UTC)
    request = iss_request(
        0.0,
        orbit=orbit,
        targets=oco3_targets(every=4),
        start=burning - timedelta(minutes=30),
        stop=burning + timedelta(minutes=45),
    )
    windows = find_opportunities(request).windows
    assert len(windows) > 30
    checked = 0
    for row in range(len(windows)):
        wanted = request.targets[windows.target[row]]
        for edge_s, cause in (
            (windows.rise_s[row], windows.opened_by[row]),
            (windows.set_s[row], windows.closed_by[row]),
        ):
            if cause == "elevation":
                around_s = edge_s + 1e-3 * np.arange(-3.0, 4.0)
                holds = margins(request, wanted, around_s).min(axis=0) > 0.0
                assert holds[2] != holds[4], (wanted.id, edge_s)
                checked += 1
    assert checked > 60
