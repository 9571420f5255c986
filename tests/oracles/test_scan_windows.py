"""Windows of imaging modes are the begins whose scans are held, looked at every three seconds.

The reference is that of a body's windows (`test_body_windows.py`), along each line as it is passed.
"""

import math

import numpy as np
import pytest
from agile_bodies import SMALLSAT, smallsat
from opportunity_requests import START, iss_request
from skyfield.api import wgs84
from spacecraft_cases import EPOCH, ORBIT, four_modes
from test_body_windows import Sky, attitudes, between, exclusion_margin, rate_margin

from planner.base.commands import ROWS_PER_S
from planner.planning.opportunities import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
    WindowSearch,
)
from planner.planning.opportunities.carrier import carrier_over
from planner.planning.opportunities.platforms.registry import lookout_of
from planner.planning.opportunities.scan_windows import scanned_path, windows_of_scans
from planner.planning.opportunities.scans import scans_by_pass
from planner.planning.sessions.pipeline import make_plan
from planner.world.attitude import LvlhAttitude
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.platforms import ISS_HRC
from planner.world.platforms.agile_cmg import AGILE_CMG
from planner.world.platforms.body import AzimuthRoll, LinesAcrossMotion
from planner.world.rules.registry import rules_of
from planner.world.scenario import InitialState, Scenario, Session
from planner.world.targets import EarthFixedTarget, GroundTarget
from planner.world.targets.geojson import GeoLineString
from planner.world.targets.imaging import CorridorMode, StereoMode, StripMode, TriStereoMode

SLOW = {
    "limits": "axis",
    "rate_max_deg_s": [0.75, 0.9, 0.8],
    "acceleration_max_deg_s2": [0.12, 0.1, 0.1],
    "jerk_max_deg_s3": [0.06, 0.05, 0.05],
}


def strip(longitude_deg, latitude_deg, **members):
    ends = (longitude_deg, latitude_deg), (longitude_deg + 0.5, latitude_deg + 0.4)
    return StripMode(geometry=GeoLineString(coordinates=ends), **members)


def corridor(longitude_deg, latitude_deg):
    legs = ((0.0, 0.0), (0.3, 0.4), (0.9, 0.3))
    places = tuple((longitude_deg + x, latitude_deg + y) for x, y in legs)
    return CorridorMode(geometry=GeoLineString(coordinates=places), speed_m_s=4000.0)


CASES = {
    "exclusions and star trackers": ({}, LinesAcrossMotion(), [strip(20.0, 30.0)]),
    "a body too slow for what passes below": (
        {
            "agility": SLOW,
            "torque_max_n_m": None,
            "off_nadir_max_deg": 60.0,
            "exclusions": [],
            "star_trackers": None,
        },
        LinesAcrossMotion(),
        [strip(-70.0, -20.0, speed_m_s=9000.0), corridor(80.0, 40.0)],
    ),
    "an azimuth, and both senses": (
        {"camera": SMALLSAT["camera"] | {"both_ways": True}},
        AzimuthRoll(azimuth_deg=30.0),
        [corridor(-120.0, 10.0)],
    ),
}


class Passed(EarthFixedTarget):
    """The point of a line that is scanned, at instants of n scans, each from its begin."""

    min_elevation_deg = 0.0
    refraction = "none"

    def __init__(self, path, begins_s):
        self.path, self.begins_s = path.starting(START), begins_s

    def r_target_itrf_m(self, instants):
        later_s = (instants.epoch_utc - START).total_seconds()
        begins_s = np.resize(self.begins_s, len(instants))
        t_s = instants.t_s + later_s - begins_s
        return self.path.r_target_itrf_m(type(instants)(START, t_s))


def margins_of(request, roll, scan, begins_s, lasts_s):
    """The least of all margins through each scan, (n,), of the way that does best."""
    platform = request.platform
    after_s = np.linspace(0.0, lasts_s, int(lasts_s) + 2)
    target = Passed(scan.path, np.repeat(begins_s, len(after_s)))
    t_s = (begins_s[:, None] + after_s).ravel()
    now, before, after = (Sky(request, target, t_s + by_s) for by_s in (0.0, -0.1, 0.1))
    off_nadir = between(now.los, -now.states.r_sat_eci_m)
    seen = np.minimum(now.clearance_rad, np.deg2rad(platform.off_nadir_max_deg) - off_nadir)
    best = np.full(len(begins_s), -np.inf)
    for way, back, forth in zip(
        *(attitudes(platform, sky, roll, roll.rule) for sky in (now, before, after)), strict=True
    ):
        kept = exclusion_margin(platform, now, way)
        moves = rate_margin(platform, back, forth, 0.2, nearest=False)
        least = np.minimum(seen, np.minimum(kept, moves))
        best = np.maximum(best, least.reshape(len(begins_s), -1).min(axis=1))
    return best


def found_in(request, modes, rolls):
    lookout = lookout_of(request.platform, request.attitude)
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    carrier = carrier_over(ephemeris, lookout, request.start, request.stop)
    scans = scans_by_pass(request, modes, carrier, 2.0)
    return list(windows_of_scans(scans.found, rolls, request, carrier))


def place():
    """A request has to have one; its modes are searched for beside it."""
    return OpportunityTarget(id="0", target=GroundTarget(latitude_deg=0.0, longitude_deg=0.0))


def asked(platform):
    return iss_request(
        days=1.0, platform=platform, targets=(place(),), conditions=OpportunityConditions()
    )


def whole_day_s(request, scan):
    """Instants of the request at which the middle of a line is in sight."""
    t_s = np.arange(0.5, (request.stop - request.start).total_seconds() - 60.0, 3.0)
    return t_s[Sky(request, scan.middle, t_s).clearance_rad > 0.0]


def off_s(scan, begins_s):
    """From the first begin that the line of sight allows, infinite where there is none."""
    return np.abs(scan.begins_s.min(initial=np.inf) - begins_s)


@pytest.mark.parametrize("case", CASES)
def test_begins_of_scans_are_those_held(case):
    changes, roll, modes = CASES[case]
    request = asked(smallsat(**changes))
    found = found_in(request, dict(enumerate(modes)), dict.fromkeys(range(len(modes)), roll))
    held = 0
    for row in range(len(modes)):
        own = [one for one in found if one.scan.row == row]
        for part in {one.scan.part for one in own}:
            scans = [one for one in own if one.scan.part == part]
            begins_s = whole_day_s(request, scans[0].scan)
            nearest = np.argmin([off_s(one.scan, begins_s) for one in scans], axis=0)
            for number, one in enumerate(scans):
                at_s = begins_s[nearest == number]
                # Of the line, and of whole rows of the table.
                line, margin = (
                    margins_of(request, roll, one.scan, at_s, lasts_s)
                    for lasts_s in (one.scan.path.duration_s, one.scan.duration_s)
                )
                is_found = np.zeros(len(at_s), bool)
                for from_s, to_s in one.begins_s:
                    is_found |= (at_s > from_s) & (at_s < to_s)
                # Points along a line tell its view to 1e-4, a second of a scan its rate to as much.
                wrong = np.where(is_found, line < -1e-4, margin > 1e-4)
                assert not wrong.any(), (row, part, at_s[wrong][:5], margin[wrong][:5])
                held += np.count_nonzero(is_found)
    assert held > 20, held


@pytest.mark.parametrize(
    ("platform", "mode"),
    [(smallsat(), strip(20.0, 30.0)), (ISS_HRC, strip(20.0, 30.0, speed_m_s=3000.0))],
    ids=lambda value: getattr(value, "name", ""),
)
def test_a_session_that_begins_first_or_last_is_planned(platform, mode):
    request = asked(platform)
    found = found_in(request, {0: mode}, {0: rules_of(platform).scan_roll})
    held = [(one.scan, span_s) for one in found for span_s in one.held_s if span_s[0] > 600.0]
    scan, (first_s, last_s) = held[0]
    stands = platform.kind == "two_axis"
    angles_deg = dict.fromkeys(platform.dof_names, 0.0) if stands else {}
    rows = 1e-6 * START.microsecond * ROWS_PER_S
    for row in (math.ceil(first_s * ROWS_PER_S + rows), math.floor(last_s * ROWS_PER_S + rows)):
        start = shifted_utc(START, (row - rows) / ROWS_PER_S)
        plan = make_plan(
            Scenario(
                platform=platform,
                orbit=request.orbit,
                attitude=LvlhAttitude() if stands else None,
                initial_state=InitialState(epoch=shifted_utc(start, -300.0), angles_deg=angles_deg),
                sessions=(
                    Session(
                        target=scan.path,
                        start=start,
                        stop=shifted_utc(start, scan.duration_s),
                        roll=rules_of(platform).scan_roll,
                    ),
                ),
            )
        )
        assert plan.verification.passed


# Of the search and the choice for the spacecraft with gyros, at acc148e1, in seconds since the
# cases' epoch: the spans in which its lines begin with both ends within 40 deg of nadir, in each
# pass of three days, and when its stereo looks begin, 24 deg ahead and behind.
BEGINS_S = {
    "strip": [(5.7783, 162.8891), (43264.7979, 43317.3473), (130921.1989, 131078.1661)],
    "corridor": [(275.0265, 433.4614), (88026.8930, 88102.1966), (218408.9815, 218531.9110)],
}
LOOKS_S = [182.0, 266.0, 218549.2, 218632.6]


@pytest.mark.parametrize("line", ["plane", "geodesic"])
def test_scans_begin_when_those_of_the_search_for_the_spacecraft_did(line):
    lines = {one.mode: one.geometry for one in four_modes() if one.mode != "area"}
    modes = (
        StripMode(geometry=lines["strip"], line=line),
        CorridorMode(geometry=lines["corridor"], line=line),
        StereoMode(geometry=lines["stereo"], line=line),
        TriStereoMode(geometry=lines["stereo"], line=line),
    )
    request = OpportunityRequest(
        platform=AGILE_CMG,
        orbit=ORBIT,
        targets=tuple(
            OpportunityTarget(id=str(row), target=mode) for row, mode in enumerate(modes)
        ),
        start=EPOCH,
        stop=shifted_utc(EPOCH, 72.0 * 3600.0),
        conditions=OpportunityConditions(max_off_nadir_deg=40.0),
    )
    edges = WindowSearch(request).find()
    lasts_s = np.array(
        [scanned_path(request, edges, window).duration_s for window in range(len(edges))]
    )
    begins_s = np.stack([edges.rise_s, edges.set_s - lasts_s], axis=1)
    part = edges.scan_parameters[:, 0]
    # A plan's row; 1 ms of each edge's halving and 0.1 ms of the search are within it.
    for row, expected_s in enumerate(BEGINS_S.values()):
        np.testing.assert_allclose(begins_s[edges.target == row], expected_s, rtol=0.0, atol=0.2)
    # Half a row to either side, of the middle of those that are near the angle.
    for row, last in ((2, 2), (3, 3)):
        outer = (edges.target == row) & np.isin(part, (1, last))
        np.testing.assert_allclose(begins_s[outer].mean(axis=1), LOOKS_S, rtol=0.0, atol=0.2)
    assert np.count_nonzero((edges.target == 3) & (part == 2)) == len(LOOKS_S) / 2


@pytest.mark.parametrize(("line", "off_m"), [("plane", 1e-3), ("geodesic", 1.0)])
def test_a_line_lies_where_the_plane_through_its_ends_and_the_earth_s_centre_does(line, off_m):
    """Of 60 km; a geodesic leaves that plane by less than half a metre, a TDI line is 0.9 m."""
    for one in four_modes():
        if one.mode == "area":
            continue
        path = StripMode(geometry=one.geometry, line=line).path_between(*one.geometry.coordinates)
        t_s = np.linspace(0.0, path.duration_s, 101)
        r_itrf_m = path.starting(EPOCH).r_target_itrf_m(Instants(EPOCH, t_s))
        longitude_deg, latitude_deg = np.transpose(one.geometry.coordinates)
        ends_itrf_m = wgs84.latlon(latitude_deg, longitude_deg).itrs_xyz.m.T
        np.testing.assert_allclose(r_itrf_m[[0, -1]], ends_itrf_m, rtol=0.0, atol=off_m)
        normal = np.cross(*ends_itrf_m)
        off_plane_m = r_itrf_m @ (normal / np.linalg.norm(normal))
        assert np.abs(off_plane_m).max() < off_m
