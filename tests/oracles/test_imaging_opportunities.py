"""The spacecraft's windows lie where its camera's angles, by Skyfield's frames, are met."""

from datetime import timedelta

import numpy as np
import pytest
from skyfield.api import wgs84
from skyfield.framelib import itrs
from spacecraft_cases import EPOCH, ORBIT, four_modes, line

from planner.spacecraft.opportunities import ImagingSearch
from planner.spacecraft.opportunity_request import ImagingOpportunityRequest, positions_of
from planner.spacecraft.requests import CorridorRequest, SpacecraftSettings, StripRequest
from planner.world.frames.time_scales import Instants

ALONG_DEG, ACROSS_DEG = 30.0, 45.0
# The search's directions hold light time and aberration, 5 arcsec together, which these do not.
ANGLE_DEG = 2e-3
HOURS = 26


def asked(requests, **more):
    return ImagingOpportunityRequest(
        orbit=ORBIT,
        requests=tuple(requests),
        start=EPOCH,
        stop=EPOCH + timedelta(hours=HOURS),
        **more,
    )


def camera_angles_deg(timescale, position, t_s):
    """Along and across, as the plan's documentation has them; NaN beyond the horizon."""
    instants = Instants(EPOCH, np.asarray(t_s))
    states = ORBIT.ephemeris(EPOCH, EPOCH + timedelta(hours=HOURS)).states(instants)
    c = np.moveaxis(itrs.rotation_at(timescale.tt_jd(*instants.tt_jd())), -1, 0)
    place = wgs84.latlon(position[1], position[0]).itrs_xyz.m
    r_place = np.einsum("nji,j->ni", c, place)
    r, v = states.r_sat_eci_m, states.v_sat_eci_m_s
    los = r_place - r
    down = -r / np.linalg.norm(r, axis=1, keepdims=True)
    right = np.cross(v, r)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    ahead = np.cross(right, down)
    along, across = (
        np.degrees(np.arctan2(np.sum(los * axis, axis=1), np.sum(los * down, axis=1)))
        for axis in (ahead, right)
    )
    hidden = np.sum(los * r_place, axis=1) > 0.0
    return np.where(hidden, np.nan, along), np.where(hidden, np.nan, across)


def searched(request):
    """The edges of all passes, and what is told of them."""
    search = ImagingSearch(request)
    edges = search.find()
    return edges, search.tell(edges)


def is_seen(angles_deg):
    along, across = angles_deg
    return (np.abs(along) <= ALONG_DEG) & (np.abs(across) <= ACROSS_DEG)


@pytest.fixture(scope="module")
def found():
    return searched(asked(four_modes()))


def test_every_pass_is_found_and_no_other(found, timescale):
    t_s = np.arange(0.0, HOURS * 3600.0, 10.0)
    passes, (_, windows) = 0, found
    for number, request in enumerate(four_modes()):
        seen = np.array(
            [is_seen(camera_angles_deg(timescale, p, t_s)) for p in positions_of(request)]
        )
        any_seen = seen.any(axis=0)
        mine = windows.select(windows.target == number)
        inside = np.zeros(len(t_s), bool)
        for rise_s, set_s in zip(mine.rise_s, mine.set_s, strict=True):
            inside |= (t_s >= rise_s) & (t_s <= set_s)
            passes += 1
        begins = np.flatnonzero(np.diff(np.append(False, any_seen).astype(int)) == 1)
        ends = np.flatnonzero(np.diff(np.append(any_seen, False).astype(int)) == -1)
        for first, last in zip(begins, ends, strict=True):
            every = seen[:, first : last + 1].any(axis=1).all()
            assert inside[first : last + 1].all() == every
        assert not (inside & ~any_seen).any()
    assert passes >= 4


@pytest.mark.parametrize(
    ("across_max_deg", "causes"), [(ACROSS_DEG, {"reach"}), (9.0, {"reach", "across"})]
)
def test_edges_are_where_the_camera_s_angles_are_met(timescale, across_max_deg, causes):
    """Seen from 6.5 to 10.8 deg across, the strip leaves a camera that looks to 9."""
    settings = SpacecraftSettings(across_max_deg=across_max_deg)
    _, windows = searched(asked(four_modes(), settings=settings))
    compared = set()
    for row, number in enumerate(windows.target):
        positions = positions_of(four_modes()[number])
        for edge_s, cause in (
            (windows.rise_s[row], windows.opened_by[row]),
            (windows.set_s[row], windows.closed_by[row]),
        ):
            if cause == "interval":
                continue
            angles = [camera_angles_deg(timescale, p, [edge_s]) for p in positions]
            which, limit_deg = (0, ALONG_DEG) if cause == "reach" else (1, across_max_deg)
            off_deg = [abs(abs(a[which][0]) - limit_deg) for a in angles]
            assert min(off_deg) < ANGLE_DEG
            compared.add(cause)
    assert compared == causes


def test_the_view_s_angles_are_those_of_the_camera(found, timescale):
    _, windows = found
    for row, number in enumerate(windows.target):
        if four_modes()[number].mode != "strip":
            continue  # whose middle is that of its two ends
        (a, b) = positions_of(four_modes()[number])
        through = windows.through
        expected = [
            np.mean([camera_angles_deg(timescale, p, through.t_s[row])[k] for p in (a, b)], axis=0)
            for k in (0, 1)
        ]
        # The mean of two ends 30 km to either side, seen from 650 km and more.
        np.testing.assert_allclose(
            np.degrees(through.angle_rad[row]), np.transpose(expected), rtol=0, atol=0.1
        )
        moved = 0.05
        before, after = (
            np.transpose(
                np.mean([camera_angles_deg(timescale, p, through.t_s[row] + s) for p in (a, b)], 0)
            )
            for s in (-moved, moved)
        )
        np.testing.assert_allclose(
            np.degrees(through.rate_rad_s[row]), (after - before) / (2 * moved), rtol=0, atol=2e-3
        )


def test_while_it_is_seen_whole(found, timescale):
    edges, windows = found
    for row, number in enumerate(windows.target):
        from_s, until_s = edges.whole_from_s[row], edges.whole_to_s[row]
        assert windows.rise_s[row] <= from_s < until_s <= windows.set_s[row]
        t_s = np.linspace(from_s, until_s, 21)[1:-1]
        for position in positions_of(four_modes()[number]):
            assert is_seen(camera_angles_deg(timescale, position, t_s)).all()


def test_a_line_longer_than_the_camera_s_reach_is_never_seen_whole():
    long = CorridorRequest(name="long", geometry=line(360.0, half_km=900.0))
    edges, windows = searched(asked([long]))
    assert len(windows)
    assert np.isnan(edges.whole_from_s).all()
    assert (windows.set_s - windows.rise_s > 300.0).all()  # 1800 km at 7 km/s


def test_what_a_request_says_of_its_time_counts():
    free = StripRequest(name="free", geometry=line(90.0))
    late = EPOCH + timedelta(seconds=100)
    strips = (
        free,
        StripRequest(name="late", geometry=line(90.0), window_start=late),
        StripRequest(name="then", geometry=line(90.0), start=late),
        StripRequest(name="never", geometry=line(90.0), start=EPOCH + timedelta(hours=3)),
    )
    _, windows = searched(asked(strips))
    rise_s = {
        name: windows.rise_s[windows.target == n]
        for n, name in enumerate(one.name for one in strips)
    }
    assert rise_s["late"][0] == 100.0
    assert windows.opened_by[windows.target == 1][0] == "interval"
    assert rise_s["then"][0] == rise_s["free"][0] < 100.0
    assert len(rise_s["then"]) == 1
    assert len(rise_s["never"]) == 0


def test_settings_and_conditions_narrow_it(found):
    _, narrow = searched(
        asked(four_modes(), settings=SpacecraftSettings(along_max_deg=10.0, across_max_deg=20.0))
    )
    assert 0 < len(narrow) < len(found[1])
    assert np.degrees(np.abs(narrow.closest.angle_rad[:, 1])).max() <= 20.0
    # The minute's window at 10 deg along, 117 km to either side at 7 km/s.
    assert (narrow.set_s - narrow.rise_s < 60.0).all()
