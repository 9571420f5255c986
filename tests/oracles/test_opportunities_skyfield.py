"""The windows are Skyfield's, and their edges lie where Skyfield's own elevation says."""

from dataclasses import replace

import numpy as np
import pytest
from opportunity_requests import START, iss_request, oco3_targets
from skyfield.api import wgs84

from planner.planning.opportunities import (
    OpportunityConditions,
    OpportunityTarget,
    find_opportunities,
)
from planner.world.clouds import Clouds
from planner.world.frames.time_scales import Instants
from planner.world.platforms import BODIES, PLATFORMS
from planner.world.targets import StationTarget

EDGE_S = 1e-3  # promised
MIN_ELEVATION_DEG = 10.0


def at(timescale, t_s):
    return timescale.tt_jd(*Instants(START, np.asarray(t_s)).tt_jd())


def site(wanted):
    return wgs84.latlon(wanted.target.latitude_deg, wanted.target.longitude_deg)


def late_s(value_deg, limit_deg, t_s):
    """How far from the limit, in time, a quantity is at each edge, by its own rate."""
    rate_deg_s = (value_deg(t_s + 0.05) - value_deg(t_s - 0.05)) / 0.1
    return (value_deg(t_s) - limit_deg) / rate_deg_s


def edges_by(windows, number, cause):
    mine = windows.target == number
    return np.concatenate(
        [
            windows.rise_s[mine & (windows.opened_by == cause)],
            windows.set_s[mine & (windows.closed_by == cause)],
        ]
    )


def test_windows_and_edges_by_elevation(skyfield):
    timescale, _, satellite = skyfield
    request = iss_request(
        7.0,
        targets=oco3_targets(every=20),
        conditions=OpportunityConditions(min_elevation_deg=MIN_ELEVATION_DEG),
    )
    windows = find_opportunities(request).windows
    start, stop = timescale.from_datetime(request.start), timescale.from_datetime(request.stop)
    compared = 0
    for number, wanted in enumerate(request.targets):
        times, events = satellite.find_events(
            site(wanted), start, stop, altitude_degrees=MIN_ELEVATION_DEG
        )
        t_s = (times.whole - start.whole + times.tt_fraction - start.tt_fraction) * 86400.0
        mine = windows.target == number
        rises, sets = edges_by(windows, number, "elevation"), windows.set_s[mine]
        assert np.count_nonzero(events == 0) + np.count_nonzero(events == 2) == len(rises)
        ours_s = np.sort(rises)
        # find_events stops its bisection once it is within half a second
        np.testing.assert_allclose(ours_s, np.sort(t_s[events != 1]), rtol=0, atol=0.5)
        apart = satellite - site(wanted)

        def elevation_deg(t_s, apart=apart):
            return apart.at(at(timescale, t_s)).altaz()[0].degrees

        off_s = late_s(elevation_deg, MIN_ELEVATION_DEG, ours_s)
        assert np.abs(off_s).max() < 0.1 * EDGE_S  # as find_opportunities says
        culminations_s = t_s[events == 1]
        for highest_s, highest_rad, rise_s, set_s in zip(
            windows.highest_s[mine],
            windows.highest_rad[mine],
            windows.rise_s[mine],
            sets,
            strict=True,
        ):
            inside = culminations_s[(culminations_s > rise_s) & (culminations_s < set_s)]
            if len(inside):
                assert np.abs(inside - highest_s).min() < 0.5
            # a millisecond at the elevation's fastest, 1 deg/s
            seen_deg = elevation_deg(np.array([highest_s]))[0]
            assert np.rad2deg(highest_rad) == pytest.approx(seen_deg, abs=1e-3)
        compared += len(ours_s)
    assert compared > 1000


SMALLSAT = BODIES["smallsat-120kg"]
WHILE_IMAGING = tuple(one for one in SMALLSAT.exclusions if one.when == "imaging")


@pytest.mark.parametrize(
    "platform",
    [PLATFORMS["iss-hrc"], replace(SMALLSAT, exclusions=WHILE_IMAGING)],
    ids=["two axes", "body"],
)
def test_contacts_are_skyfields_passes_whatever_a_look_must_meet(skyfield, platform):
    """Down to 5 deg, 69 deg off nadir, by day and by night, beside a place that is looked at."""
    timescale, _, satellite = skyfield
    looked_at = oco3_targets(every=60)
    stations = [
        StationTarget(latitude_deg=37.94, longitude_deg=-75.46),
        StationTarget(latitude_deg=-33.15, longitude_deg=-70.67, height_m=730.0),
        StationTarget(latitude_deg=67.86, longitude_deg=20.96, min_elevation_deg=1.0),
    ]
    request = iss_request(
        3.0,
        platform=platform,
        targets=(*looked_at, *(OpportunityTarget(id=one.label, target=one) for one in stations)),
        conditions=OpportunityConditions(
            min_elevation_deg=60.0, max_off_nadir_deg=20.0, sun_elevation_min_deg=10.0
        ),
        clouds=Clouds(
            format="ascii_grid",
            content="ncols 1\nnrows 1\nxllcorner -180\nyllcorner -90\ncellsize 360\n0.5\n",
        ),
    )
    windows = find_opportunities(request).windows
    is_look = windows.target < len(looked_at)
    assert is_look.any()
    assert windows.highest_rad[is_look].min() > np.deg2rad(60.0)
    assert np.isfinite(windows.clear_share[is_look]).all()
    assert np.isnan(windows.clear_share[~is_look]).all()
    start, stop = timescale.from_datetime(request.start), timescale.from_datetime(request.stop)
    for number, station in enumerate(stations, start=len(looked_at)):
        place = wgs84.latlon(station.latitude_deg, station.longitude_deg, station.height_m)
        times, events = satellite.find_events(
            place, start, stop, altitude_degrees=station.min_elevation_deg
        )
        t_s = (times.whole - start.whole + times.tt_fraction - start.tt_fraction) * 86400.0
        mine = windows.target == number
        for ours_s, event in ((windows.rise_s[mine], 0), (windows.set_s[mine], 2)):
            # find_events stops its bisection once it is within half a second
            np.testing.assert_allclose(np.sort(ours_s), t_s[events == event], rtol=0, atol=0.5)
