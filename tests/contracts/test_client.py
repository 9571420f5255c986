"""The client plans, waits, follows, and raises what a served instance refuses."""

import asyncio
import dataclasses
import inspect
import json
import math
import os
import re
import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from urllib.request import urlopen

import numpy as np
import pytest
from live_service import live_service
from relay import Relay
from typer.testing import CliRunner

import slewtrack
from app.cli import main
from app.requests.examples import SPACECRAFT_EXAMPLES

EXAMPLES = Path(__file__).parents[2] / "examples"
LAS_VEGAS = json.loads((EXAMPLES / "las_vegas_2015.json").read_text())
CITIES = (EXAMPLES / "campaign_cities.json").read_bytes()
GALLERY = (EXAMPLES / "opportunities_gallery.json").read_bytes()
STRIP = SPACECRAFT_EXAMPLES["geojson"][1] | {"simulation_runs": 0}
EPOCH = datetime(2015, 2, 27, tzinfo=UTC)
TOO_EARLY = LAS_VEGAS | {"sessions": [LAS_VEGAS["sessions"][0] | {"start": "2015-02-27T17:34:02Z"}]}


@pytest.fixture(scope="module")
def client(service):
    with slewtrack.Client(service.address) as one:
        yield one


@pytest.fixture(scope="module")
def plan(client):
    return client.plan(LAS_VEGAS)


@pytest.fixture(scope="module")
def guarded(tmp_path_factory):
    """A service that asks for keys, and one of them, for 60 requests a minute."""
    folder = tmp_path_factory.mktemp("guarded")
    words = ["keys", "create", "hasty", "--rate-per-minute", "60"]
    made = CliRunner().invoke(main, words, env={"SLEWTRACK_DATA_DIR": str(folder)})
    with live_service(folder, SLEWTRACK_REQUIRE_KEYS="true") as service:
        yield service, made.stdout.strip()


def test_a_table_holds_the_numbers_that_were_answered(service, client, plan):
    with urlopen(f"{service.address}/v1/plans/{plan.id}") as answer:
        told = json.load(answer)["table"]
    for table in (plan.table, client.get(plan.id).table, client.table(plan.id)):
        assert set(table) == set(told) - {"epoch", "step_s"}
        assert table.epoch == told["epoch"]
        for name, values in table.items():
            assert values.dtype == np.float64
            assert values.tolist() == told[name]
    assert str(plan.table.utc[-1]) == "2015-02-27T17:37:50.000000000"


def test_a_table_in_pandas_and_xarray(plan):
    frame = plan.table.to_pandas()
    assert frame["alpha_deg"].tolist() == plan.table["alpha_deg"].tolist()
    assert frame.index[1].isoformat() == "2015-02-27T17:34:00.200000+00:00"
    dataset = plan.table.to_xarray()
    assert dataset["beta_rate_deg_s"].values.tolist() == plan.table["beta_rate_deg_s"].tolist()
    assert dataset.attrs["step_s"] == 0.2


def test_the_view_in_columns_along_the_table(service, client, plan):
    with urlopen(f"{service.address}/v1/plans/{plan.id}/view?step_s=10.0") as answer:
        told = json.load(answer)
    view = client.view(plan.id, step_s=10.0)
    assert view["carrier.latitude_deg"].tolist() == told["carrier"]["latitude_deg"]
    azimuth_deg = np.array(told["targets"][0]["azimuth_deg"], dtype=float)  # NaN for null
    np.testing.assert_array_equal(view["targets.0.azimuth_deg"], azimuth_deg)
    assert view["footprint.latitude_deg"].shape == (len(view.t_s), 4)
    assert view["activity"].tolist() == told["activity"]
    assert view.facts["targets"][0]["name"] == told["targets"][0]["name"]
    assert view.to_xarray().sizes["t_s"] == len(view.to_pandas()) == len(view.t_s)


def test_the_same_calls_without_a_service(client, plan):
    """The same names, answers of the same classes, the same numbers and refusals."""
    here = slewtrack.plan(LAS_VEGAS)
    for mine, theirs in (
        (here.table, plan.table),
        (slewtrack.table(here), client.table(plan)),
        (slewtrack.view(here, step_s=10.0), client.view(plan, step_s=10.0)),
    ):
        assert list(mine) == list(theirs)
        for name, values in mine.items():
            np.testing.assert_array_equal(values, theirs[name])
    assert set(here.members) == set(plan.members)
    rows = [
        [line for line in file.splitlines() if not line.startswith(b"#")]
        for file in (slewtrack.export(here, "csv"), client.export(plan, "csv"))
    ]
    assert rows[0] == rows[1]
    for request in (TOO_EARLY, LAS_VEGAS | {"platform": "hubble", "nmae": "x"}):
        said = []
        for door in (slewtrack, client):
            with pytest.raises(slewtrack.Refused) as refused:
                door.plan(request)
            said.append(dataclasses.replace(refused.value.problem, instance="", members={}))
        assert said[0] == said[1]
    for door, one in ((slewtrack, here), (client, plan)):
        with pytest.raises(slewtrack.Refused, match="netcdf"):
            door.export(one, "xlsx")


def test_the_next_pass_is_found_and_planned(client):
    """As the command's --next-pass has it: test_command_ways_out.py."""
    kept = len(client.searches(limit=500))
    plans = [
        door.next_pass(EXAMPLES / "my_city.json", start="2015-02-28T00:00:00Z")
        for door in (slewtrack, client)
    ]
    for plan in plans:
        assert plan.passed
        assert plan["segments"][1]["start"] == "2015-02-28T09:03:48.8Z"
        assert plan.table.epoch == "2015-02-28T09:01:48.8Z"
    assert len(client.searches(limit=500)) == kept
    pole = {"mode": "ground", "latitude_deg": 89.0, "longitude_deg": 0.0, "height_m": 0.0}
    for door in (slewtrack, client):
        with pytest.raises(slewtrack.Refused, match="within 7 days") as refused:
            door.next_pass(LAS_VEGAS | {"sessions": [{"target": pole}]}, start=EPOCH)
        assert refused.value.problem.field == "sessions.0.target"
    with pytest.raises(ValueError, match="append Z"):
        client.next_pass(LAS_VEGAS, start="2015-02-28T00:00:00")


@pytest.mark.parametrize("target", [{"mode": "place", "name": "Nowhere at all"}, 5])
def test_the_next_pass_of_what_is_no_target_names_the_plans_field(client, target):
    for door in (slewtrack, client):
        with pytest.raises(slewtrack.Refused) as refused:
            door.next_pass(LAS_VEGAS | {"sessions": [{"target": target}]})
        problem = refused.value.problem
        assert problem.field.startswith("sessions.0.target")
        assert problem.errors[0].field == problem.field


def test_progress_ends_with_what_became_of_it(client):
    told = []
    assert client.plan(LAS_VEGAS, progress=told.append).passed
    assert [told[0].state, told[-1].state] == ["queued", "done"]


@pytest.mark.parametrize("progress", [None, lambda _: None])
def test_a_refusal_carries_its_problem(client, progress):
    with pytest.raises(slewtrack.Refused) as refused:
        client.plan(TOO_EARLY, progress=progress)
    problem = refused.value.problem
    assert problem.type == "urn:slewtrack:problem:infeasible-slew"
    assert (problem.status, problem.field, problem.axis) == (422, "sessions.0.start", "alpha")
    start, *others = problem.ways_out
    assert start["sessions.0.start"] == problem.earliest_feasible_start
    better = LAS_VEGAS["sessions"][0] | {"start": problem.earliest_feasible_start}
    for way_out in ({"sessions": [better]}, *others):
        assert client.plan(TOO_EARLY | way_out).passed


def test_a_refusal_lists_what_each_way_out_costs_and_every_field_at_fault(client):
    sequence = json.loads((EXAMPLES / "three_sessions.json").read_text())
    sequence |= {"on_conflict": "refuse"}
    sequence["sessions"][1]["start"] = sequence["sessions"][0]["stop"]
    with pytest.raises(slewtrack.Refused) as refused:
        client.plan(sequence)
    offer = refused.value.problem.relaxations[0]
    client.check(sequence | {"on_conflict": offer.on_conflict})
    with pytest.raises(slewtrack.Refused) as refused:
        client.plan(LAS_VEGAS | {"platform": "hubble", "nmae": "x"})
    assert {fault.field for fault in refused.value.problem.errors} == {"platform", "nmae"}


def test_what_is_kept_is_listed_exported_revised_and_deleted(client):
    first = client.wait(client.submit(LAS_VEGAS | {"name": "kept"}).id)
    second = client.plan(LAS_VEGAS | {"name": "kept"}, revises=first.id)
    assert (first.revision, second.revision) == (1, 2)
    assert [job.id for job in client.plans(name="kept")] == [second.id, first.id]
    assert len(client.plans(limit=1)) == 1
    assert client.export(first.id, "netcdf").startswith(b"CDF")
    client.delete(first.id)
    with pytest.raises(slewtrack.Refused) as refused:
        client.get(first.id)
    assert refused.value.problem.status == 404


def test_a_target_that_is_never_seen_says_why(client):
    """The ISS never stands above the pole's horizon."""
    pole = {"id": "pole", "target": {"mode": "ground", "latitude_deg": 90.0, "longitude_deg": 0.0}}
    found = client.opportunities(json.loads(GALLERY) | {"targets": [pole]}, include=["reasons"])
    [one] = found.reasons
    assert (one.target, one.closed_by, one["closed_by"]) == ("pole", "elevation", "elevation")
    assert -30.0 < one.best_elevation_deg < 0.0
    assert one.best_time.utcoffset().total_seconds() == 0.0
    assert (found.unseen, str(one)) == (("pole",), f"pole ({one.because})")
    assert "unseen: pole" in repr(found)


def test_a_campaign_is_followed_over_broken_connections(service):
    """Each time it is told something, the connection breaks: nothing is lost or told twice."""
    relay = Relay("127.0.0.1", service.port)
    told = []

    def break_it(progress):
        told.append(progress)
        relay.hang_up()

    with slewtrack.Client(f"http://127.0.0.1:{relay.port}") as client:
        campaign = client.campaign(CITIES, progress=break_it)
        assert [client.get(one["plan"]).passed for one in campaign.passes] == [True, True]
        looks = client.export_campaign(campaign, "csv").decode().splitlines()
        with pytest.raises(slewtrack.Refused, match="or text/csv or"):
            client.export_campaign(campaign, "netcdf")
    assert len(looks) == 1 + sum(len(one.looks) for one in campaign.passes)
    assert campaign.value <= campaign.bound
    assert [progress.done for progress in told if progress.stage == "plans"] == [1, 2]
    assert [progress.state for progress in told].count("done") == 1


def test_the_callers_own_exception_comes_through(client):
    def broken(_):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        client.plan(LAS_VEGAS, progress=broken)


def test_names_are_completed(client):
    assert client.places("london, c", limit=1)[0]["name"] == "London, CA"
    assert [star["name"] for star in client.stars("veg")] == ["Vega"]


def test_images_and_imaging(client):
    images = [(EXAMPLES / f"horizon_{side}.png").read_bytes() for side in ("ahead", "right")]
    request = (EXAMPLES / "horizon_estimate.json").read_bytes()
    assert client.estimate_vertical(images, request)["verdict"] == "consistent"
    spacecraft = client.spacecraft
    session = spacecraft.plan(STRIP)
    assert session.table["q_body_from_eci_xyzw"].shape == (len(session.table.t_s), 4)
    assert session.id in [job.id for job in spacecraft.plans(target="strip")]
    assert spacecraft.get(session.id).members == session.members
    view = spacecraft.view(session.id, step_s=10.0)
    assert view["carrier.latitude_deg"].shape == view.t_s.shape
    assert spacecraft.export(session.id, "png").startswith(b"\x89PNG")
    whole = client.get(session.id)  # of the body that the spacecraft is
    assert whole.members["summary"]["targets"] == ["strip"]
    assert whole.table["q_eci_from_body_w"].shape == session.table.t_s.shape


def test_telemetry_is_compared_with_a_kept_plan(client, plan):
    """Its own table, as if flown: only the digits of its CSV are off."""
    content = client.export(plan.id, "csv")
    found = client.compare({"plan": plan.id}, content)
    assert found["plan"] == plan.id
    assert found["axes"]["alpha"]["max_arcsec"] < 0.001
    samples = {"t_s": plan.table.t_s.tolist(), "beta_deg": plan.table["beta_deg"].tolist()}
    assert client.compare({"plan": plan.id, "samples": samples})["samples"]["dropped"] == {}
    assert client.draw_comparison({"plan": plan.id}, content).startswith(b"\x89PNG")
    with pytest.raises(slewtrack.Refused) as refused:
        client.compare({"plan": plan.id}, b"nothing")
    assert refused.value.problem.field == "samples"


def test_a_request_is_given_back_and_plans_again(client, plan):
    assert client.request(plan.id) == LAS_VEGAS
    again = client.plan(client.request(plan.id) | {"name": "again"})
    assert again.table["alpha_deg"].tolist() == plan.table["alpha_deg"].tolist()


def test_lists_are_sought_through(client, plan):
    """The example flies on 27 February 2015 between 17:34 and 17:38."""
    noon, evening = (datetime(2015, 2, 27, hour, tzinfo=UTC) for hour in (12, 18))
    found = client.plans(name="Las Vegas", state="done", after=noon, before=evening, limit=500)
    assert plan.id in [job.id for job in found]
    assert client.plans(after=evening, before="2015-02-28T00:00:00Z") == []
    assert client.plans(text="no such words") == client.plans(target="no such words") == []
    with pytest.raises(ValueError, match="after must be an aware datetime"):
        client.plans(after=datetime(2015, 2, 27))  # noqa: DTZ001 (what is tested)
    with pytest.raises(slewtrack.Refused, match="state"):
        client.plans(state="finished")


@pytest.mark.parametrize(
    ("example", "target", "parts"),
    [("opportunities_gallery.json", "Las Vegas", None), ("opportunities_modes.json", "stereo", 2)],
)
def test_what_was_searched_for_is_kept(client, example, target, parts):
    request = json.loads((EXAMPLES / example).read_text())
    found = client.opportunities(request)
    assert client.get_search(found.id) == found
    assert client.search_request(found.id) == request
    assert tuple(client.windows(found.id)) == found.windows
    theirs = [window for window in found.windows if window.target == target]
    assert {window.scan and window.scan["parts"] for window in theirs} == {parts}
    assert client.windows(found.id, target=target) == theirs
    assert client.windows(found.id, target=target, limit=1) == theirs[:1]
    assert client.searches(limit=1)[0].id == found.id
    client.delete_search(found.id)
    with pytest.raises(slewtrack.Refused, match="no search"):
        client.get_search(found.id)


def test_windows_come_page_after_page(monkeypatch, client):
    monkeypatch.setattr(slewtrack.client.calls, "WINDOWS_A_PAGE", 40)
    found = client.opportunities(GALLERY)
    assert len(found.windows) == 92
    assert tuple(client.windows(found.id)) == found.windows
    assert tuple(client.windows(found.id, limit=50)) == found.windows[:50]
    assert client.opportunities(GALLERY, limit=50).windows == found.windows[:50]
    [edges, *_] = client.get_search(found.id, include=(), limit=3).windows
    assert (edges.rise, edges.session) == (found.windows[0].rise, found.windows[0].session)
    assert not edges.closest
    assert math.isnan(edges.highest_deg)


def test_many_at_once_with_await(service):
    async def plans():
        async with slewtrack.AsyncClient(service.address) as client:
            told = []
            made = await asyncio.gather(
                client.plan(LAS_VEGAS),
                client.plan(LAS_VEGAS, progress=told.append),
                client.plan(TOO_EARLY),
                return_exceptions=True,
            )
            return made, told, await client.export(made[0].id, "csv")

    (one, other, refused), told, csv = asyncio.run(plans())
    np.testing.assert_array_equal(one.table["alpha_deg"], other.table["alpha_deg"])
    assert told[-1].state == "done"
    assert refused.problem.field == "sessions.0.start"
    assert b"alpha_deg" in csv


def test_both_clients_have_the_same_calls():
    def calls(kind):
        return {
            name: inspect.signature(call)
            for name, call in inspect.getmembers(kind, inspect.isfunction)
            if not name.startswith("_")
        }

    assert calls(slewtrack.Client) == calls(slewtrack.AsyncClient)


def test_a_key_is_sent_and_its_lack_told(guarded):
    service, _ = guarded
    for key, said in ((None, "send an API key"), ("st_wrong", "unknown or revoked")):
        with (
            slewtrack.Client(service.address, key) as client,
            pytest.raises(slewtrack.Refused, match=said) as refused,
        ):
            client.plans()
        assert refused.value.problem.status == 401


def test_a_rate_limit_is_waited_out(guarded):
    service, secret = guarded
    with slewtrack.Client(service.address, secret) as client:
        began_s = time.monotonic()
        for _ in range(62):
            client.plans()
    assert time.monotonic() - began_s > 0.5  # 60 at once, one more each second


def test_the_pages_example(service):
    page = (EXAMPLES.parent / "docs" / "python.md").read_text()
    [example] = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    [shown] = re.findall(r"```\n(True .*?)```", page, re.DOTALL)
    done = subprocess.run(
        [sys.executable, "-c", example],
        capture_output=True,
        text=True,
        cwd=EXAMPLES.parent,
        env=os.environ | {"SLEWTRACK_URL": service.address},
    )
    assert done.stdout == shown, done.stderr
