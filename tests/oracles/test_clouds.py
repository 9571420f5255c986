"""Clouds of a forecast: files by xarray, its own interpolation, and skies drawn at random."""

import base64
import json
import math
from pathlib import Path

import numpy as np
import pytest
import xarray
from planner_values import plan_of, read_request

from app.requests.campaign import read_campaign_request
from app.requests.examples import LAS_VEGAS
from app.work.searches import read_opportunity_request
from planner.base.errors import InvalidRequest
from planner.planning.campaigns import choose_campaign
from planner.planning.opportunities import find_opportunities
from planner.planning.sessions.summary import summarise
from planner.world.clouds import Clouds
from planner.world.frames.time_scales import Instants, utc_from_text

EXAMPLES = Path(__file__).parents[2] / "examples"
START = utc_from_text("2015-02-27T12:00:00Z")
DRAWN = 200


def forecast(hours=(0.0, 3.0, 6.0, 12.0, 24.0, 48.0), step_deg=2.5, seed=1):
    """All of the Earth, as centres of forecasts are written."""
    latitude = np.arange(90.0, -90.0 - 1e-9, -step_deg)
    longitude = np.arange(0.0, 360.0, step_deg)
    smooth = np.random.default_rng(seed).uniform(
        0.0, 1.0, (len(hours), len(latitude), len(longitude))
    )
    return xarray.DataArray(
        smooth,
        dims=("time", "latitude", "longitude"),
        coords={
            "time": ("time", np.array(hours), {"units": "hours since 2015-02-27 12:00:00"}),
            "latitude": ("latitude", latitude, {"units": "degrees_north"}),
            "longitude": ("longitude", longitude, {"units": "degrees_east"}),
        },
        name="tcc",
    )


def written(array, path, encoding=None, **how):
    array.to_netcdf(path, **({"format": "NETCDF3_CLASSIC"} | how), encoding={"tcc": encoding or {}})
    return base64.b64encode(path.read_bytes()).decode()


PACKED = {"dtype": "int16", "scale_factor": 1.0 / 30000.0, "_FillValue": -32767}


@pytest.mark.parametrize(
    ("encoding", "south_first", "percent"),
    [({}, False, False), (PACKED, False, False), ({"dtype": "float32"}, True, True)],
)
def test_clear_sky_is_what_xarray_has_between_the_centres(tmp_path, encoding, south_first, percent):
    array = forecast()
    if south_first:
        array = array.isel(latitude=slice(None, None, -1))
    if percent:
        array = (100.0 * array).assign_attrs(units="%")
    clouds = Clouds(format="netcdf", content=written(array, tmp_path / "f.nc", encoding))
    rng = np.random.default_rng(2)
    count = 300
    latitude, longitude = rng.uniform(-90, 90, count), rng.uniform(0.0, 357.5, count)
    t_s = np.sort(rng.uniform(0.0, 48.0 * 3600.0, count))
    at = {
        "time": xarray.DataArray(t_s / 3600.0, dims="n"),
        "latitude": xarray.DataArray(latitude, dims="n"),
        "longitude": xarray.DataArray(longitude, dims="n"),
    }
    wanted = 1.0 - array.interp(at).values / (100.0 if percent else 1.0)
    longitude = np.where(longitude > 180.0, longitude - 360.0, longitude)
    found = clouds.clear(latitude, longitude, Instants(START, t_s))
    # half a step of the packing
    np.testing.assert_allclose(found, wanted, rtol=0, atol=2e-5)


def test_nothing_is_said_where_and_when_the_forecast_says_nothing(tmp_path):
    array = forecast().where(lambda one: one.latitude < 60.0).sel(longitude=slice(200.0, 300.0))
    clouds = Clouds(format="netcdf", content=written(array, tmp_path / "f.nc", PACKED))
    places = np.array([[30.0, -100.0], [75.0, -100.0], [30.0, 20.0]])
    known = clouds.clear(*places.T, Instants(START, np.full(3, 3600.0)))
    assert np.isnan(known).tolist() == [False, True, True]
    for t_s in (-1.0, 48.0 * 3600.0 + 1.0):
        assert np.isnan(clouds.clear(*places[:1].T, Instants(START, np.array([t_s]))))


def test_what_is_no_cloud_fraction_is_refused_with_a_way_out(tmp_path):
    array, path = forecast(), tmp_path / "f.nc"
    renamed = array.rename(latitude="y")
    renamed["y"].attrs["units"] = "m"
    uneven = array.isel(latitude=[0, 1, 3, 4])
    undated = array.copy()
    undated["time"].attrs["units"] = "month as %Y"
    two = xarray.Dataset({"tcc": array, "lcc": array})
    two.to_netcdf(path, format="NETCDF3_CLASSIC")
    both = base64.b64encode(path.read_bytes()).decode()
    good = written(array, path)
    for content, told in (
        (written(array, path, format="NETCDF4"), "nccopy"),
        (written(renamed, path), "degrees"),
        (written(uneven, path), "even steps"),
        (written(undated, path), "hours since"),
        (written(100.0 * array, path), "between 0 and 1"),
        (both, "tcc, lcc"),
        (good[: len(good) // 8 * 4], "can be read"),
        ("AAAA", "can be read"),
        ("!", "base64"),
    ):
        with pytest.raises(ValueError, match=told):
            Clouds(format="netcdf", content=content)
    assert Clouds(format="netcdf", content=both, variable="lcc").clear(
        np.zeros(1), np.zeros(1), Instants(START, np.zeros(1))
    )
    request = LAS_VEGAS | {"clouds": {"format": "netcdf", "content": "AAAA"}}
    with pytest.raises(InvalidRequest, match="clouds"):
        read_request(request)


GRID = "ncols 2\nnrows 1\nxllcorner -180\nyllcorner -90\ncellsize 180\n0.25 0.75\n"


def test_plans_and_windows_tell_it_beside_the_probability_in_frame():
    """A climatology of two cells: the first has its centre at -90 deg, the second at 90."""
    clouds = {"format": "ascii_grid", "content": GRID}
    session = LAS_VEGAS["sessions"][0]
    west = (session["target"]["longitude_deg"] + 90.0) / 180.0
    cloudy = 0.25 if west < 0.0 else 0.25 + 0.5 * west
    plan = plan_of(LAS_VEGAS | {"clouds": clouds})
    [told] = summarise(plan).sessions
    assert told.clear_probability == pytest.approx(1.0 - cloudy, abs=1e-6)
    assert told.probability_in_frame not in (None, told.clear_probability)
    bare = plan_of(LAS_VEGAS)
    assert summarise(bare).sessions[0].clear_probability is None
    request = {name: LAS_VEGAS[name] for name in ("orbit", "platform", "attitude")} | {
        "targets": [{"id": "it", "target": session["target"]}],
        "start": "2015-02-27T12:00:00Z",
        "stop": "2015-02-28T00:00:00Z",
    }
    for given, known in (({}, False), ({"clouds": clouds}, True)):
        asked = read_opportunity_request(json.dumps(request | given).encode())
        windows = find_opportunities(asked).windows
        assert len(windows) > 1
        if known:
            np.testing.assert_allclose(windows.clear_share, 1.0 - cloudy, rtol=0, atol=1e-6)
        else:
            assert np.isnan(windows.clear_share).all()


def test_a_campaign_with_the_forecast_is_worth_more_over_drawn_skies(tmp_path):
    """Where a campaign that knows of no clouds looks first, they are thick."""
    document = json.loads((EXAMPLES / "campaign_cities.json").read_text())
    for one in document["targets"]:  # longer than fit beside each other
        one |= {"session_s": 100.0, "min_session_s": 60.0, "priority": 1.0}
    start = utc_from_text(document["start"])
    blind = choose_campaign(read_campaign_request(json.dumps(document).encode()))
    array = 0.0 * forecast(hours=(0.0, 240.0), step_deg=1.0) + 0.1
    array["time"].attrs["units"] = f"hours since {start:%Y-%m-%d %H:%M:%S}"
    taken = {look.target for flight in blind.passes for look in flight.looks}
    for one in document["targets"]:
        if one["id"] in taken:
            north = abs(array.latitude - one["target"]["latitude_deg"]) < 1.0
            east = abs(array.longitude - one["target"]["longitude_deg"] % 360.0) < 1.0
            array = array.where(~(north & east), 0.9)
    array["time"].attrs["units"] = f"hours since {start:%Y-%m-%d %H:%M:%S}"
    for axis, unit in (("latitude", "degrees_north"), ("longitude", "degrees_east")):
        array[axis].attrs["units"] = unit
    clouds = {"format": "netcdf", "content": written(array, tmp_path / "f.nc", PACKED)}
    grid = Clouds(**clouds)
    sighted = choose_campaign(
        read_campaign_request(json.dumps(document | {"clouds": clouds}).encode())
    )
    places = {one["id"]: one["target"] for one in document["targets"]}
    values, expected = [], []
    for campaign in (blind, sighted):
        looks = [look for flight in campaign.passes for look in flight.looks]
        middle_s = [
            (0.5 * (look.start_utc.timestamp() + look.stop_utc.timestamp())) - start.timestamp()
            for look in looks
        ]
        order = np.argsort(middle_s)
        assert order.tolist() == list(range(len(looks)))
        clear = grid.clear(
            np.array([places[look.target]["latitude_deg"] for look in looks]),
            np.array([places[look.target]["longitude_deg"] for look in looks]),
            Instants(start, np.array(middle_s)),
        )
        worth = np.array([look.value for look in looks])
        if campaign is sighted:
            told = [look.clear_probability for look in looks]
            np.testing.assert_allclose(told, clear, rtol=0, atol=1e-4)
            worth = worth / clear  # in a clear sky
        skies = np.random.default_rng(3).uniform(size=(DRAWN, len(looks))) < clear
        values.append(skies @ worth)
        expected.append(float(clear @ worth))
    assert sighted.value == pytest.approx(expected[1], rel=1e-3)  # linear over a look
    for drawn, mean in zip(values, expected, strict=True):
        assert abs(drawn.mean() - mean) < 4.0 * drawn.std() / math.sqrt(DRAWN)
    assert expected[1] > 1.05 * expected[0], (taken, expected)
