"""A campaign that revises another: what stays, what is chosen anew, and what became of targets."""

import io
import itertools
import json
import re
import zipfile
import zlib
from contextlib import nullcontext
from pathlib import Path

import pytest
from typer.testing import CliRunner

import slewtrack
from app.cli import main
from app.here import told_pass
from app.requests.campaign import read_campaign_request
from app.work.campaign import choose, revised
from app.work.plan import plan_and_pack
from planner.base.errors import InvalidRequest, Refusal
from planner.world.frames.time_scales import elapsed_s, utc_from_text
from slewtrack.client import Client, Refused

EXAMPLES = Path(__file__).parents[2] / "examples"
ASKED = {
    name: json.loads((EXAMPLES / f"campaign_{name}.json").read_text())
    for name in ("cities", "fleet")
}
LATE = {"id": "Chicago", "session_s": 40.0, "min_session_s": 20.0}
LATE["target"] = {"mode": "ground", "latitude_deg": 41.8781, "longitude_deg": -87.6298}


def chosen(asked):
    """The answer as a service would give it, were every pass planned as chosen."""
    made = choose(json.dumps(asked).encode())
    passes = [told_pass(part, "done", f"plan {n}") for n, part in enumerate(made.parts)]
    told = {"choice": json.loads(zlib.decompress(made.document)), "passes": passes}
    return json.loads(json.dumps(told)), made.parts


@pytest.fixture(scope="module")
def before():
    return {name: chosen(asked)[0] for name, asked in ASKED.items()}


def revision(asked, campaign, until):
    return json.loads(revised(json.dumps(asked).encode(), until, campaign))


def without(*ids):
    return lambda asked: [one for one in asked["targets"] if one["id"] not in ids]


def all_of(answer):
    frozen = (answer["choice"].get("revision") or {"frozen": []})["frozen"]
    anew = [
        {**look, "carrier": one.get("carrier"), "pass_start": one["start"]}
        | {"pass_stop": one["stop"]}
        for one in answer["passes"]
        for look in one["looks"]
    ]
    return frozen, anew


@pytest.mark.parametrize("name", ASKED)
@pytest.mark.parametrize("passes_that_stay", [0, 1, 2])
@pytest.mark.parametrize(
    "targets",
    [lambda asked: asked["targets"], without("Phoenix", "Boston"), lambda a: [*a["targets"], LATE]],
    ids=["the same", "two fewer", "one more"],
)
def test_what_begins_before_stays_and_nothing_else_begins_there(
    before, name, passes_that_stay, targets
):
    asked, campaign = ASKED[name], before[name]
    starts = [one["start"] for one in campaign["passes"]]
    until = [*starts, campaign["passes"][-1]["stop"]][passes_that_stay]
    changed = asked | {"targets": targets(asked)}
    answer, parts = chosen(revision(changed, campaign, until))
    frozen, anew = all_of(answer)
    _, were = all_of(campaign)
    names = ("target", "carrier", "start", "stop", "value", "pass_start", "pass_stop")

    def facts(look):
        return tuple(look.get(name) for name in names)

    assert sorted(map(facts, frozen), key=str) == sorted(
        (facts(look) for look in were if look["pass_start"] < until), key=str
    )
    assert all(look["pass_start"] >= until for look in anew)
    everything = sorted((*frozen, *anew), key=lambda look: look["start"])
    assert len({look["target"] for look in everything}) == len(everything)  # one look each
    for carrier in {look["carrier"] for look in everything}:
        own = [look for look in everything if look["carrier"] == carrier]
        ends = sorted({(look["pass_start"], look["pass_stop"]) for look in own})
        assert all(one[1] <= after[0] for one, after in itertools.pairwise(ends))
    told = answer["choice"]["revision"]
    assert told["frozen_value"] == pytest.approx(sum(look["value"] for look in frozen))
    changes = {one["target"]: one["change"] for one in told["targets"]}
    had, has = ({look["target"] for look in looks} for looks in (were, everything))
    assert {one for one, change in changes.items() if change == "dropped"} == had - has
    assert {one for one, change in changes.items() if change == "added"} == has - had
    for one in told["targets"]:
        assert (one["change"] == "kept") == (not one["before"] and not one["now"])
        assert (one["change"] == "moved") == (bool(one["before"]) and bool(one["now"]))
    assert [sum(change == one for change in changes.values()) for one in changes.values()] == [
        told[one] for one in changes.values()
    ]
    if targets(asked) == asked["targets"]:
        whole = told["frozen_value"] + answer["choice"]["value"]
        assert whole >= campaign["choice"]["value"] - 1e-9
    for part in parts:
        assert plan_and_pack(part.request).state == "done"


def test_a_revision_of_a_revision_counts_what_flew_before(before):
    asked, campaign = ASKED["fleet"], before["fleet"]
    starts = [one["start"] for one in campaign["passes"]]
    once, _ = chosen(revision(asked, campaign, starts[1]))
    later = starts[-1]
    twice, _ = chosen(revision(asked | {"start": starts[2]}, once, later))
    frozen, anew = all_of(twice)
    assert [look["plan"] for look in frozen if look["pass_start"] == starts[0]] == ["plan 0"] * 2
    assert {look["target"] for look in frozen}.isdisjoint(look["target"] for look in anew)
    assert twice["choice"]["revision"]["dropped"] == 0


def test_a_carrier_that_is_gone_flies_nothing_more(before):
    asked, campaign = ASKED["fleet"], before["fleet"]
    gone = campaign["passes"][0]["carrier"]
    fewer = asked | {"carriers": [one for one in asked["carriers"] if one["id"] != gone]}
    answer, _ = chosen(revision(fewer, campaign, campaign["passes"][1]["start"]))
    frozen, anew = all_of(answer)
    assert gone not in {look["carrier"] for look in (*frozen, *anew)}
    assert [one for one in answer["choice"]["warnings"] if f"passes of {gone}" in one]
    # What it flew before the start stays flown.
    late = fewer | {"start": campaign["passes"][0]["stop"]}
    frozen, anew = all_of(chosen(revision(late, campaign, late["start"]))[0])
    assert {look["target"] for look in frozen if look["carrier"] == gone}
    assert {look["target"] for look in frozen}.isdisjoint(look["target"] for look in anew)


def test_a_least_gap_is_kept_to_what_stays(before):
    campaign = before["cities"]
    gap_s, last = 900.0, campaign["passes"][0]
    asked = ASKED["cities"] | {"conditions": {"min_gap_s": gap_s}}
    asked["targets"] = [*asked["targets"], LATE | {"priority": 9.0}]
    answer, _ = chosen(revision(asked, campaign, last["stop"]))
    _, anew = all_of(answer)
    ended = max(utc_from_text(look["stop"]) for look in last["looks"])
    assert all(elapsed_s(utc_from_text(look["start"]), ended) >= gap_s for look in anew)


LOOK = {
    "target": "Boston",
    "start": "2015-02-27T17:36:08Z",
    "stop": "2015-02-27T17:36:48Z",
    "pass_start": "2015-02-27T17:35:00Z",
    "pass_stop": "2015-02-27T17:38:00Z",
}
UNTIL = "2015-02-27T18:00:00Z"


@pytest.mark.parametrize(
    ("change", "field", "way_out"),
    [
        ({"frozen_until": "2015-02-27T18:00:00"}, "revises.frozen_until", "append Z"),
        ({"frozen_until": "soon"}, "revises.frozen_until", "soon"),
        ({"frozen_until": "2015-02-26T18:00:00Z"}, "revises.frozen_until", "before start"),
        ({"frozen_until": ASKED["cities"]["stop"]}, "revises.frozen_until", "before stop"),
        ({"frozen_h": 3.0}, "revises.frozen_h", "remove it"),
        ({"looks": [LOOK | {"stop": LOOK["pass_start"]}]}, "revises.looks.0.stop", "before start"),
        ({"looks": [LOOK | {"value": -1.0}]}, "revises.looks.0.value", "0..1e+06"),
        ({"looks": [LOOK | {"part": 0}]}, "revises.looks.0.part", "1..10000"),
        ({"looks": [LOOK | {"target": None}]}, "revises.looks.0.target", "must be a string"),
        ({"looks": {}}, "revises.looks", "list"),
    ],
)
@pytest.mark.parametrize("name", ASKED)
def test_a_refusal_names_the_field(name, change, field, way_out):
    asked = ASKED[name] | {"revises": {"frozen_until": UNTIL, "looks": []} | change}
    with pytest.raises(InvalidRequest) as refused:
        read_campaign_request(json.dumps(asked).encode())
    told = [f"{one.field}: {one.detail}" for one in refused.value.errors]
    assert any(one.startswith(f"{field}: ") and way_out in one for one in told), told


@pytest.mark.parametrize(
    ("change", "field", "way_out"),
    [
        (
            {"conditions": {"duty_cycle": {"imaging_max_s": 30.0, "span_s": 9000.0}}},
            "revises.frozen_until",
            "let less stay, or allow more",
        ),
        ({"targets": ASKED["cities"]["targets"][:1]}, "revises.frozen_until", "freeze less"),
    ],
)
def test_what_cannot_be_revised_is_refused(change, field, way_out):
    looks = [LOOK | {"target": ASKED["cities"]["targets"][0]["id"]}]
    asked = ASKED["cities"] | {"revises": {"frozen_until": UNTIL, "looks": looks}} | change
    with pytest.raises((Refusal, InvalidRequest)) as refused:
        choose(json.dumps(asked).encode())
    errors = getattr(refused.value, "errors", None) or [refused.value]
    assert any(one.field == field and way_out in one.detail for one in errors)


def test_the_service_revises_by_id_and_the_client_asks_it(service):
    with Client(service.address) as client:
        first = client.campaign(ASKED["cities"])
        until = first.passes[1].start
        again = client.campaign(ASKED["cities"], revises=first.id, frozen_until=until)
        told = again["choice"]["revision"]
        assert again["revises"] == first.id
        assert {look["plan"] for look in told["frozen"]} == {first.passes[0].plan}
        assert [one["change"] for one in told["targets"]] == ["kept"] * told["kept"]
        assert client.get(told["frozen"][0]["plan"])["verification"]["passed"]
        for query, field, detail in (
            ({"revises": first.id}, "query.frozen_until", "which of its passes"),
            ({"frozen_until": until}, "query.revises", "names a campaign"),
            ({"revises": first.passes[0].plan, "frozen_until": until}, "query.revises", "no camp"),
            ({"revises": "1", "frozen_until": until}, "query.revises", "must be an id"),
            ({"revises": first.id, "frozen_until": "soon"}, "query.frozen_until", "soon"),
        ):
            with pytest.raises(Refused) as refused:
                client.campaign(ASKED["cities"], **query)
            problem = refused.value.problem
            errors = problem.members.get("errors") or [problem.members]
            assert any(one["field"] == field and detail in one["detail"] for one in errors), errors


def passes_in(content, format_name):
    """What a campaign's file holds of each pass, by its number."""
    found = {}
    if format_name == "zip":
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            for name in set(archive.namelist()) - {"looks.csv"}:
                found.setdefault(int(name.split("-")[1].split(".")[0]), []).append(
                    (name, archive.read(name))
                )
        return {number: sorted(files) for number, files in found.items()}
    if format_name == "csv":
        for line in content.decode().splitlines()[1:]:
            found.setdefault(int(line.split(",")[0]), []).append(line)
    elif format_name == "geojson":
        for one in json.loads(content)["features"]:
            found.setdefault(one["properties"]["pass"], []).append(one)
    else:
        for one in content.decode().split("<Placemark")[1:]:
            number = re.search(r"pass: (\d+)", one)[1]
            found.setdefault(int(number), []).append(one.partition("</Placemark>")[0])
    return found


@pytest.mark.parametrize("asks", ["a service", "this process"])
def test_files_of_a_revision_hold_what_stays_as_it_was_and_what_is_chosen_anew(service, asks):
    """Of a revision's revision, too."""
    with Client(service.address) if asks == "a service" else nullcontext(slewtrack) as door:
        asked = ASKED["cities"]
        first = door.campaign(asked)
        starts = [one.start for one in first.passes]
        second = door.campaign(asked, revises=first.id, frozen_until=starts[1])
        late = asked | {"targets": [*asked["targets"], LATE]}
        third = door.campaign(late, revises=second.id, frozen_until=second.passes[0].stop)
        assert [one.number for one in second.passes] == [*range(1, 1 + len(second.passes))]
        for format_name in ("csv", "geojson", "kml", "zip"):
            own = [
                passes_in(door.export_campaign(one, format_name), format_name)
                for one in (first, second, third)
            ]
            assert own[1][1] == own[0][1]
            assert [own[2][number] for number in (1, 2)] == [own[1][number] for number in (1, 2)]
            for campaign, held in zip((first, second, third), own, strict=True):
                anew = {one.number + 1 for one in campaign.passes}
                stay = {
                    look["pass_number"] + 1
                    for look in (campaign["choice"]["revision"] or {"frozen": []})["frozen"]
                }
                assert {*held} == stay | anew
                assert not stay & anew


def test_a_fleet_with_resources_is_planned_and_revised_by_the_service(service):
    """Each pass's plan begins with what the answer tells, and stays within every limit."""
    asked = json.loads((EXAMPLES / "campaign_fleet_resources.json").read_text())
    with Client(service.address) as client:
        first = client.campaign(asked)
        lacks = {one["target"]: one["lacks"] for one in first["choice"]["left_out"]}
        assert set(lacks.values()) & {"battery", "memory", "duty_cycle"}
        until = max(one.stop for one in first.passes if one.start < "2015-02-27T18")
        again = client.campaign(asked, revises=first.id, frozen_until=until)
        changes = [one["change"] for one in again["choice"]["revision"]["targets"]]
        assert changes == ["kept"] * first["choice"]["looks"]
        for one in (*first.passes, *again.passes):
            request, plan = client.request(one.plan), client.get(one.plan)
            assert plan["verification"]["passed"]
            own = next(x for x in asked["carriers"] if x["id"] == one.carrier)
            held = one["resources"] or {}
            assert [*filter(held.get, held)] == [
                {"battery": "battery_wh", "memory": "memory_gbit"}[name]
                for name in own.get("resources", ())
            ]
            if "resources" in own:
                begun = request["resources"]["battery"]["start_wh"]
                assert begun == pytest.approx(held["battery_wh"][0])
        [last], [was] = again.passes, first.passes[-1:]
        assert last.number == was.number
        assert last["resources"] is not None
        for name in filter(was["resources"].get, was["resources"]):
            for told, before in zip(last["resources"][name], was["resources"][name], strict=True):
                assert told == pytest.approx(before, rel=2e-3)


def test_lines_of_a_revision_by_a_file_hold_what_stays(tmp_path):
    """What the command writes of it is revised again."""
    asked, lines, until = json.dumps(ASKED["fleet"]), [], None
    for number in range(3):
        words = ["campaign", "-", "--json", f"{tmp_path}/{number}.json"]
        words += ["--csv", f"{tmp_path}/looks.csv", "--export", f"kml={tmp_path}/looks.kml"]
        if until:
            words += ["--revises", f"{tmp_path}/{number - 1}.json", "--frozen-until", until]
        made = CliRunner().invoke(main, words, input=asked)
        assert made.exit_code == 0, made.stderr
        assert ("files of --export lack" in made.stdout) == bool(until)
        lines.append(passes_in((tmp_path / "looks.csv").read_bytes(), "csv"))
        told = json.loads((tmp_path / f"{number}.json").read_text())
        assert {one["number"] + 1 for one in told["passes"]} == {*lines[-1]}
        until = told["passes"][number]["stop"]
    assert lines[1][1] == lines[0][1]
    assert [lines[2][number] for number in (1, 2)] == [lines[1][number] for number in (1, 2)]


def test_the_command_revises_by_a_file(tmp_path, before):
    told, asked = tmp_path / "told.json", json.dumps(ASKED["fleet"])
    told.write_text(json.dumps(before["fleet"]))
    until = before["fleet"]["passes"][1]["start"]
    words = ["campaign", "-", "--dry-run", "--revises", str(told), "--frozen-until", until]
    made = CliRunner().invoke(main, words, input=asked)
    assert made.exit_code == 0, made.stderr
    assert "2 looks worth" in made.stdout
    assert f"stay, of passes that begin before {until[:19]}Z" in made.stdout
    for words, why in (
        (["--revises", str(told)], "--frozen-until: must be given, too"),
        (["--frozen-until", until], "--revises: must be given, too"),
        (["--revises", str(tmp_path / "none.json"), "--frozen-until", until], "none.json"),
        (["--revises", "-", "--frozen-until", until], "-"),
    ):
        refused = CliRunner().invoke(main, ["campaign", "-", "--dry-run", *words], input=asked)
        assert (refused.exit_code, why in refused.stderr) == (2, True), refused.stderr
    for damaged in (
        "[]",
        '{"passes": [1]}',
        '{"passes": {"state": "done"}}',
        '{"choice": 1, "passes": []}',
    ):
        told.write_text(damaged)
        words = ["campaign", "-", "--dry-run", "--revises", str(told), "--frozen-until", until]
        refused = CliRunner().invoke(main, words, input=asked)
        assert (refused.exit_code, len(refused.stderr.splitlines())) == (2, 1), refused.stderr
