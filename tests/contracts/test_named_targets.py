"""Names are found however they are typed, completed, and refused with a way out that works."""

import json
import re
import subprocess
import sys
import unicodedata
from dataclasses import replace

import pytest
from planner_values import find_opportunities, plan_of, read_request

from app.requests.examples import LAS_VEGAS, OPPORTUNITY_EXAMPLES
from app.requests.json_reader import ERRORS_SHOWN, JsonReader
from app.work.searches import read_opportunity_request
from planner.base.errors import InvalidRequest
from planner.world.targets import GroundTarget, PlaceTarget, StarTarget, gazetteer
from planner.world.targets.gazetteer import find_place
from planner.world.targets.star_names import hipparcos_number


@pytest.mark.parametrize(
    "written",
    ["São Paulo", "sao paulo", "SÃO PAULO", "Sao-Paulo", unicodedata.normalize("NFD", "São Paulo"),
     "Сан-Паулу", "Sao Paulo, Brazil", "são paulo, br", "Sao Paulo, 3448439"],
)  # fmt: skip
def test_a_town_is_found_in_any_case_and_script(written):
    assert find_place(written).geonames_id == 3448439


@pytest.mark.parametrize(
    ("written", "country", "region"),
    [
        ("Washington, D.C.", "US", "District of Columbia"),
        ("Portland, OR", "US", "Oregon"),
        ("Portland, oregon, us", "US", "Oregon"),
        ("St. John's, Canada", "CA", "Newfoundland and Labrador"),
        ("Xi’an", "CN", "Shaanxi"),
        ("İstanbul", "TR", "Istanbul"),
    ],
)
def test_what_tells_towns_apart_may_follow(written, country, region):
    place = find_place(written)
    assert (place.country, place.region) == (country, region)


@pytest.mark.parametrize(
    "many", ["Portland", "Suzhou", "Springfield", "La Paz", "Victoria", "York"]
)
def test_each_candidate_told_is_one_place(many):
    with pytest.raises(ValueError, match="may be") as refusal:
        find_place(many)
    told = re.findall(r"'([^']+)' \(", str(refusal.value))
    assert len(told) > 1
    assert len({find_place(one).geonames_id for one in told}) == len(told)


@pytest.mark.parametrize(
    ("misspelt", "meant"),
    [("Ljublana", "Ljubljana, SI"), ("San Franzisco", "San Francisco, US"),
     ("Reykjavic", "Reykjavík, IS"), ("Ljubljana, Austria", "Ljubljana, SI")],
)  # fmt: skip
def test_a_misspelt_town_is_answered_with_those_like_it(misspelt, meant):
    with pytest.raises(ValueError, match="do you mean") as refusal:
        find_place(misspelt)
    assert repr(meant) in str(refusal.value)
    assert find_place(meant)


@pytest.mark.parametrize(
    "name", ["", " ", ",", "SI", "\u200d", "1" * 200, "𝔏" * 50, "'", "\U0010ffff"]
)
def test_what_is_no_name_is_refused_in_one_line(name):
    with pytest.raises(ValueError, match="name ") as refusal:
        find_place(name)
    assert "\n" not in str(refusal.value)
    with pytest.raises(ValueError, match="name "):
        hipparcos_number(name)


@pytest.mark.parametrize("written", ["Sirius", "SIRIUS", "sirius", " Sirius "])
def test_a_star_is_found_in_any_case(written):
    assert StarTarget(name=written).catalogue_number == 32349


def test_all_wrong_names_of_a_request_are_told_at_once_with_those_that_mean_one_place():
    names = ["Ljublana", "Graz", "Springfield", "Paris", "Xqzzyva"]
    targets = [
        {"id": str(number), "target": {"mode": "place", "name": name}}
        for number, name in enumerate(names)
    ]
    asked = {**OPPORTUNITY_EXAMPLES["cities"][1], "targets": targets}
    with pytest.raises(InvalidRequest) as refusal:
        read_opportunity_request(json.dumps(asked).encode())
    told = {error.field: error for error in refusal.value.errors}
    assert set(told) == {f"targets.{number}.target.name" for number in (0, 2, 4)}
    assert "Springfield, Ohio, US" in told["targets.2.target.name"].candidates
    assert told["targets.0.target.name"].candidates == ("Ljubljana, SI",)
    for error in told.values():
        assert all(find_place(one) for one in error.candidates)


def test_many_misspelt_towns_are_answered_with_those_like_them_at_first_only(monkeypatch):
    """Looking for names like one takes a hundredth of a second, 5,000 times a minute."""
    looked_for = []
    monkeypatch.setattr(gazetteer, "nearest_keys", lambda key, _: looked_for.append(key) or [])
    targets = [
        {"id": str(number), "target": {"mode": "place", "name": "Ljublana"}}
        for number in range(1000)
    ]
    asked = {**OPPORTUNITY_EXAMPLES["cities"][1], "targets": targets, "samples": 2}
    with pytest.raises(InvalidRequest) as refusal:
        read_opportunity_request(json.dumps(asked).encode())
    assert len(refusal.value.errors) == len(looked_for) == ERRORS_SHOWN


@pytest.mark.parametrize(
    ("name", "region"),
    [("London", "England"), ("Paris", "Île-de-France"), ("Rome", "Lazio"), ("Vienna", "Vienna")],
)
def test_the_far_more_populous_of_a_name_is_taken_and_the_answer_says_so(name, region):
    """London in Ontario has 420,000 people; a twentieth of London's 9 million."""
    target = PlaceTarget(name=name)
    assert target.place.region == region
    assert "the most populous by far of" in target.assumed("targets.0.target").detail
    alone = PlaceTarget(name="Ljubljana").assumed("targets.0.target").detail
    assert "most populous" not in alone


def test_a_place_and_a_star_by_name_are_planned_as_what_the_answer_says_they_are():
    scenario = read_request(LAS_VEGAS)
    named = PlaceTarget(name="Las Vegas, Nevada, US")
    [session] = scenario.sessions
    by_name = plan_of(replace(scenario, sessions=(replace(session, target=named),)))
    [found] = by_name.scenario.assumed
    assert found.field == "sessions.0.target.name"
    target = JsonReader(GroundTarget).read(json.dumps(found.members).encode())
    assert target == GroundTarget(latitude_deg=36.17497, longitude_deg=-115.13722, height_m=586.0)
    in_full = plan_of(replace(scenario, sessions=(replace(session, target=target),)))
    assert (by_name.table.position == in_full.table.position).all()
    assert by_name.verification.passed
    assert by_name.verification.taken_as_given == in_full.verification.taken_as_given

    found = StarTarget(name="vega").assumed("targets.3.target")
    assert (found.field, found.members) == ("targets.3.target.name", {"mode": "star", "hip": 91262})


def test_opportunities_and_campaigns_say_where_a_named_target_is():
    request = {name: LAS_VEGAS[name] for name in ("platform", "orbit")} | {
        "start": "2015-02-27T17:30:00Z", "stop": "2015-02-27T17:45:00Z",
        "targets": [{"id": "here", "target": {"mode": "place", "name": "Las Vegas, US"}},
                    {"id": "there", "target": {"mode": "ground", "latitude_deg": 36.17497,
                                               "longitude_deg": -115.13722, "height_m": 586.0}}],
    }  # fmt: skip
    found = find_opportunities(request)
    assert [one.field for one in found.assumed] == ["targets.0.target.name"]
    assert found.windows.target.tolist() == [0, 1]
    assert found.windows.rise_s[0] == found.windows.rise_s[1]


def test_a_request_without_names_loads_no_list_of_them():
    code = (
        "import pathlib\n"
        "from app.requests.plan import read_plan_request\n"
        "from planner.world.targets import gazetteer as g, star_names as s\n"
        "read_plan_request(pathlib.Path('examples/las_vegas_2015.json').read_bytes())\n"
        "print(g._read_file.cache_info().currsize, s._star_numbers.cache_info().currsize)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["0", "0"]


# As geonames.org has 2643743.
LONDON = (51.5085, -0.1257)


def places(client, begin: str, **more: int) -> list[dict]:
    answer = client.get("/v1/places", params={"begin": begin, **more})
    assert answer.status_code == 200, answer.text
    return answer.json()["places"]


@pytest.mark.parametrize("begin", ["lond", "LOND", "Лонд"])
def test_the_most_populous_place_comes_first(client, begin):
    first = places(client, begin)[0]
    assert first["name"] == "London, GB"
    assert (first["latitude_deg"], first["longitude_deg"]) == pytest.approx(LONDON, abs=0.01)


@pytest.mark.parametrize(
    ("begin", "first", "other"),
    [("Cologn", "Köln, DE", "Cologna"), ("New Yo", "New York City, US", None),
     ("al", "Alexandria, EG", None), ("Kol", "Kolkata, IN", None), ("Köl", "Köln, DE", None),
     ("Ko\u0308l", "Köln, DE", None)],
)  # fmt: skip
def test_the_larger_place_is_offered_first_by_whichever_name_it_has(client, begin, first, other):
    """Cologno Monzese has 47,000 people, Jakarta was once called New York of Java."""
    offered = places(client, begin)[0]
    assert (offered["name"], offered["other_name"]) == (first, other)


def test_the_brightest_stars_are_offered_first(client):
    """Not Al Aghnam; magnitudes 0.76, 0.87 and 1.69 of the Bright Star Catalogue."""
    stars = client.get("/v1/stars", params={"begin": "al"}).json()["stars"]
    assert [one["name"] for one in stars[:3]] == ["Altair", "Aldebaran", "Alnilam"]


def test_several_of_one_name_are_told_apart(client):
    found = places(client, "Springfield")
    names = [one["name"] for one in found]
    assert len(set(names)) == len(names) == 8
    assert {"Springfield, Missouri, US", "Springfield, Illinois, US"} <= set(names)


def test_each_name_offered_means_one_place(client):
    """A plan's target takes what is offered, and means the same place by it."""
    for one in [*places(client, "san", limit=50), *places(client, "Cambridge")]:
        place = PlaceTarget(name=one["name"]).place
        assert (place.latitude_deg, place.words) == (one["latitude_deg"], one["words"])


def test_after_a_comma_region_and_country_are_completed(client):
    assert [one["name"] for one in places(client, "London, o")] == ["London, CA"]


def test_a_star_is_completed(client):
    answer = client.get("/v1/stars", params={"begin": "veg"}).json()
    assert answer == {"stars": [{"name": "Vega", "hip": 91262}]}


@pytest.mark.parametrize(
    ("query", "field"),
    [("", "query.begin"), ("?begin=", "query.begin"), ("?begin=a&limit=0", "query.limit"),
     ("?begin=a&begins=b", "query.begins")],
)  # fmt: skip
def test_a_wrong_query_is_refused_by_field(client, query, field):
    answer = client.get(f"/v1/stars{query}")
    assert answer.status_code == 422
    assert field in answer.text


def test_what_names_nothing_offers_nothing(client):
    assert places(client, "...") == []
    assert places(client, "xqzzy") == []
