"""Every export format keeps the promises all of them make."""

import csv
import dataclasses
import io
import itertools
import json
import re
from datetime import UTC, datetime, timedelta
from types import SimpleNamespace

import numpy as np
import pytest
from export_cases import CREATED_UTC, EPOCH_UTC, ISS, LAS_VEGAS, state_vector
from scipy.io import netcdf_file

from app.work.view import view_json
from planner.base.commands import CommandTable, axis_channels
from planner.base.errors import OutsideCoverage
from planner.output.export import EXPORTERS
from planner.output.export.figure_parts import panels_over_time, shade_spans
from planner.output.view import view_plan
from planner.output.view.netcdf import write_view_netcdf
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.orbits import OemOrbit
from planner.world.platforms import ISS_HRC
from planner.world.scenario import InitialState, Scenario, Session
from planner.world.targets import BenchMotionTarget, BodyTarget, GroundTarget
from planner.world.targets.axis_signals import ConstantRate

EVERY = pytest.mark.parametrize("name", EXPORTERS)
DRAWN = [name for name, exporter in EXPORTERS.items() if exporter.shows]


def plan_of(
    epoch_utc=EPOCH_UTC, *, orbit=ISS, target=LAS_VEGAS, name="any", outer="alpha", outer_rad=0.0
):
    """Ten seconds with the axes at rest, the last six of them a session."""
    t_s = np.arange(51) / 5.0
    start, stop = shifted_utc(epoch_utc, 4.0), shifted_utc(epoch_utc, 10.0)
    return SimpleNamespace(
        scenario=Scenario(
            name=name,
            orbit=orbit,
            attitude=LvlhAttitude(),
            platform=dataclasses.replace(ISS_HRC, outer_name=outer),
            initial_state=InitialState(epoch=epoch_utc, angles_deg={outer: 0.0, "beta": 0.0}),
            sessions=(Session(target=target, start=start, stop=stop),),
        ),
        segments=(
            SimpleNamespace(kind="slew", session=0, start_utc=epoch_utc, stop_utc=start),
            SimpleNamespace(kind="track", session=0, start_utc=start, stop_utc=stop),
        ),
        table=CommandTable(
            epoch_utc=epoch_utc,
            channels=axis_channels((outer, "beta")),
            position=np.tile([outer_rad, 0.0], (len(t_s), 1)),
            rate_rad_s=np.zeros((len(t_s), 2)),
        ),
    )


def write(name, plan):
    return EXPORTERS[name].write(plan, CREATED_UTC)


def unfolded(name, plan):
    """As text; of a calendar's long lines the folds are taken back (RFC 5545, section 3.1)."""
    text = write(name, plan).decode("utf-8", "replace")
    return text.replace("\r\n ", "") if name == "ics" else text


def test_media_types_and_suffixes_tell_formats_apart():
    for field in ("media_type", "suffix"):
        values = [getattr(exporter, field) for exporter in EXPORTERS.values()]
        assert len(set(values)) == len(values)
    for exporter in EXPORTERS.values():
        assert re.fullmatch(r"[a-z]+/[a-z0-9.+-]+", exporter.media_type)


@EVERY
def test_every_file_says_time_scale_and_rotation_order(name):
    text = unfolded(name, plan_of())
    for said in ("UTC", "leap seconds counted", "R(alpha) R(beta)", "right-handed"):
        assert said in text
    for said in ("+Z boresight", "q_platform_from_body_xyzw", "cubic Hermite"):
        assert said in text


@EVERY
def test_the_same_plan_gives_the_same_bytes(name):
    assert write(name, plan_of()) == write(name, plan_of())


def test_a_long_table_is_sampled_in_czml():
    """A day has 432,001 rows, 129 MB of them all."""
    plan = plan_of()
    rows = 432_001
    plan.table = dataclasses.replace(
        plan.table, position=np.zeros((rows, 2)), rate_rad_s=np.zeros((rows, 2))
    )
    document = write("czml", plan)
    assert len(document) < 10_000_000
    packets = {packet["id"]: packet for packet in json.loads(document)}
    told = packets["document"]["description"]
    assert "a sample every 4.4 s, of each 22 rows one" in told
    t_s = packets["carrier"]["position"]["cartesian"][::4]
    assert t_s[:2] == [0.0, 4.4]
    assert t_s[-1] == 86_400.0  # the last row is there, too
    short = {packet["id"]: packet for packet in json.loads(write("czml", plan_of()))}
    assert "a sample every" not in short["document"]["description"]
    assert len(short["carrier"]["position"]["cartesian"]) == 4 * 51


@EVERY
def test_a_leap_second_is_counted(name):
    """Rows before, inside and after 2016-12-31T23:59:60."""
    epoch_utc = datetime(2016, 12, 31, 23, 59, 55, tzinfo=UTC)
    plan = plan_of(epoch_utc, orbit=state_vector(epoch_utc))
    text = unfolded(name, plan)
    if name not in ("json", "ics", *DRAWN):  # those count seconds from the epoch only, or say spans
        inside = "2016-12-31T23:59:60" if name == "oem" else "2016-12-31T23:59:60.2"
        assert inside in text
    assert "2017-01-01T00:00:04" in text or name in ("json", "png", "svg")
    if name == "netcdf":
        assert "calendar" in text
        assert b"utc\0" in write(name, plan)  # CF 1.12: leap seconds are in the count


def test_stop_of_a_leap_second_plan():
    epoch_utc = datetime(2016, 12, 31, 23, 59, 55, tzinfo=UTC)
    plan = plan_of(epoch_utc, orbit=state_vector(epoch_utc))
    (stop,) = Instants(epoch_utc, plan.table.t_s[-1:]).utc_text(3)
    assert stop == "2017-01-01T00:00:04.000Z"
    lines = write("aem", plan).decode().splitlines()
    assert f"STOP_TIME = {stop.removesuffix('Z')}" in lines
    packets = json.loads(write("czml", plan))
    assert packets[0]["clock"]["interval"].endswith("/2017-01-01T00:00:04.000000Z")
    assert packets[1]["position"]["cartesian"][-4] == 10.0


@EVERY
def test_a_test_motion_has_no_target_but_an_attitude(name):
    still = BenchMotionTarget(axes=dict.fromkeys(("alpha", "beta"), ConstantRate(rate_deg_s=0.0)))
    plan = plan_of(target=still)
    written = write(name, plan)
    assert written
    if name == "czml":
        ids = [packet["id"] for packet in json.loads(written)]
        assert "boresight" in ids
        assert not [i for i in ids if i.startswith("target")]


@EVERY
def test_looking_away_from_the_earth_leaves_no_footprint(name):
    plan = plan_of(target=BodyTarget(name="sun"), outer_rad=np.pi)
    written = write(name, plan)
    assert b"NaN" not in written
    if name == "czml":
        ids = [packet["id"] for packet in json.loads(written)]
        assert "footprint" not in ids
        assert "target-0" in ids


@EVERY
def test_rows_before_the_orbit_is_known_are_left_out(name):
    """An OEM that begins with the session: angles are complete, attitude from there on."""
    known = oem_of(plan_of(), from_s=4)
    plan = plan_of(orbit=known)
    written = write(name, plan).decode("utf-8", "replace")
    if name in ("aem", "stk", "stk-attitude"):
        assert "2015-02-27T17:36:03.800 " not in written
        assert "2015-02-27T17:36:04.000 " in written
    if name in ("csv", "json", "ics"):
        assert written == write(name, plan_of()).decode()


@pytest.mark.parametrize("name", [name for name in EXPORTERS if name not in ("csv", "json", "ics")])
def test_an_unknown_orbit_is_refused(name):
    with pytest.raises(OutsideCoverage):
        write(name, plan_of(orbit=oem_of(plan_of(), from_s=7)))


def oem_of(plan, from_s):
    """The plan's own OEM export, cut: states only from `from_s` on, some minutes long."""
    long = SimpleNamespace(**vars(plan))
    rows = 5 * 300
    long.table = dataclasses.replace(
        plan.table, position=np.zeros((rows, 2)), rate_rad_s=np.zeros((rows, 2))
    )
    lines = write("oem", long).decode().splitlines()
    start = (EPOCH_UTC + timedelta(seconds=from_s)).strftime("%Y-%m-%dT%H:%M:%S.000")
    kept = [line for line in lines if not re.match(r"\d{4}-", line) or line >= start]
    text = "\n".join(kept)
    return OemOrbit(content=re.sub(r"START_TIME = .*", f"START_TIME = {start}", text))


@EVERY
def test_no_name_breaks_out_of_its_place(name):
    hostile = 'x,\nMETA_STOP\r\nEND Attitude "</script><b>\u2028é\0'
    written = write(name, plan_of(name=hostile, outer=hostile))
    text = written.decode("utf-8", "replace")
    lines = [line.strip() for line in text.splitlines()]
    assert lines.count("META_STOP") <= 1
    assert not [line for line in lines if line.startswith("END Attitude ")]
    if name in ("aem", "oem", "stk", "stk-attitude", "csv"):
        assert written.isascii()
        assert max(map(len, text.splitlines())) <= 254 or name in ("csv", "stk", "stk-attitude")
    if name == "csv":
        header, row = (next(csv.reader([line])) for line in text.splitlines()[-52:-50])
        assert len(header) == len(row) == 6
    if name == "czml":
        assert "<b>" not in json.loads(written)[0]["description"]


def test_a_calendar_keeps_the_rules_of_its_format():
    """RFC 5545: lines of at most 75 octets that end with CRLF, text escaped, UTC, a UID of its own.

    A leap second is read as 60 (section 3.3.12); an event holds the whole session.
    """
    epoch_utc = datetime(2016, 12, 31, 23, 59, 55, tzinfo=UTC)
    target = GroundTarget(latitude_deg=36.1147, longitude_deg=-115.1728)
    plan = plan_of(epoch_utc, orbit=state_vector(epoch_utc), target=target)
    [session] = plan.scenario.sessions
    first = dataclasses.replace(session, start=epoch_utc, stop=shifted_utc(epoch_utc, 5.0))
    named = dataclasses.replace(
        session,
        name="Łódź; a, b\\c",
        start=shifted_utc(epoch_utc, 5.4),
        stop=shifted_utc(epoch_utc, 9.2),
    )
    plan.scenario = dataclasses.replace(plan.scenario, sessions=(first, named))
    written = write("ics", plan)
    assert written.endswith(b"END:VCALENDAR\r\n")
    lines = written.removesuffix(b"\r\n").split(b"\r\n")
    assert max(map(len, lines)) <= 75
    for line in lines:
        line.decode()  # none ends within a character
        assert b"\n" not in line
    text = unfolded("ics", plan)
    uids = re.findall(r"UID:(\S+)", text)
    assert len({*uids}) == 2
    assert "DTSTART:20161231T235960Z" in text
    assert "DTEND:20170101T000004Z" in text
    assert "2016-12-31T23:59:60.400Z to 2017-01-01T00:00:03.200Z" in text
    assert "SUMMARY:Łódź\\; a\\, b\\\\c\\, iss-hrc" in text
    assert "GEO:36.114700;-115.172800" in text
    assert "DTSTAMP:20260102T030405Z" in text
    later = EXPORTERS["ics"].write(plan, CREATED_UTC + timedelta(seconds=1)).decode()
    assert not {*uids} & {*re.findall(r"UID:(\S+)", later)}


def test_a_view_begins_where_the_orbit_is_known():
    """The axes are seen from the first row on, in JSON and in NetCDF."""
    plan = plan_of(orbit=oem_of(plan_of(), from_s=4))
    view = view_plan(plan, 0.2, 1.0)
    assert np.flatnonzero(np.isfinite(view.carrier.height_m))[0] == 20
    shown = json.loads(view_json(view, "x", verified=True))
    whole = json.loads(view_json(view_plan(plan_of(), 0.2, 1.0), "x", verified=True))
    assert shown["axes"] == whole["axes"]
    assert shown["t_s"] == whole["t_s"]
    for section, name, known in (
        ("carrier", "height_m", None),
        ("boresight", "latitude_deg", None),
        ("footprint", "longitude_deg", [None] * 4),
        ("sun", "above_limb_deg", None),
    ):
        column = shown[section][name]
        assert column[:20] == [known] * 20
        # a cubic through states a second apart, to a millimetre
        np.testing.assert_allclose(column[20:], whole[section][name][20:], rtol=0, atol=2e-3)
    with netcdf_file(io.BytesIO(write_view_netcdf(view, CREATED_UTC)), mmap=False) as file:
        height_m = file.variables["carrier_height_m"]
        assert (height_m[:20] == height_m._FillValue).all()
        assert (height_m[20:] < 5e5).all()


@pytest.mark.parametrize(
    "spans_s", [[(280.0, 300.0)], [(0.0, 8.0)], [(10.0, 60.0), (90.0, 150.0), (250.0, 299.0)]]
)
def test_names_above_a_picture_lie_within_it_and_apart(spans_s):
    name = "near Las Vegas (36.1147, -115.1728)"
    epoch_utc = datetime(2015, 2, 27, tzinfo=UTC)
    figure, panels = panels_over_time(["angle"], "a title", epoch_utc, 0.0, 300.0)
    shade_spans(panels, [(*span_s, name) for span_s in spans_s], "session")
    shown = panels[0].texts[0].get_text()
    assert shown == name or (len(spans_s) > 1 and shown.startswith("near Las Vegas"))
    figure.draw_without_rendering()
    frame = panels[0].get_window_extent()
    boxes = [text.get_window_extent() for text in panels[0].texts]
    assert frame.x0 <= boxes[0].x0
    assert boxes[-1].x1 <= frame.x1
    assert all(first.x1 < second.x0 for first, second in itertools.pairwise(boxes))
