"""Places and stars are offered as somebody begins to type them."""

import pytest

from planner.world.targets.place import PlaceTarget

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
