"""Opportunities are kept, paged, and given as GeoJSON and as a pass table."""

import csv
import io
import json
import re

import pytest

from app.http.routes import search_routes
from app.ids import new_id
from app.requests.examples import OPPORTUNITY_EXAMPLES

CITIES = OPPORTUNITY_EXAMPLES["cities"][1] | {"name": "Cities by day"}
SKY = OPPORTUNITY_EXAMPLES["sky"][1]
PATH = "/v1/opportunities"
VIEW = "include=view"
GEOJSON, CSV = {"Accept": "application/geo+json"}, {"Accept": "text/csv"}


@pytest.fixture(scope="module")
def posted(client):
    return client.post(f"{PATH}?{VIEW}", json=CITIES)


@pytest.fixture(scope="module")
def cities(posted):
    return posted.json()


def rows(answer):
    assert answer.headers["content-type"].startswith("text/csv")
    assert re.fullmatch(
        r'attachment; filename="[\w-]+\.csv"', answer.headers["content-disposition"]
    )
    return list(csv.DictReader(io.StringIO(answer.text)))


def test_what_was_found_is_kept(client, posted, cities):
    assert posted.status_code == 200
    assert posted.headers["Location"] == f"{PATH}/{cities['id']}"
    again = client.get(f"{posted.headers['Location']}?{VIEW}")
    assert again.content == posted.content
    assert cities["name"] == "Cities by day"
    tag = {"If-None-Match": again.headers["ETag"]}
    assert client.get(f"{posted.headers['Location']}?{VIEW}", headers=tag).status_code == 304
    for other in ({"params": VIEW, "headers": tag | GEOJSON}, {"headers": tag}):
        assert client.get(posted.headers["Location"], **other).status_code == 200
    sent = client.get(f"{posted.headers['Location']}/request")
    assert sent.json() == CITIES
    again = client.post(f"{PATH}?{VIEW}", json=sent.json()).json()
    assert again["windows"] == cities["windows"]


def test_what_is_told_is_what_is_asked_for(client, cities):
    """The rest of a window stays the same, and none of it is lost."""
    at = f"{PATH}/{cities['id']}"
    edges = {"target", "rise", "set", "duration_s", "session", "opened_by", "closed_by"}
    plain = client.get(at).json()["windows"]
    assert {*plain[0]} == edges
    assert plain == [{name: one[name] for name in edges} for one in cities["windows"]]
    likely = client.get(f"{at}?include=probability").json()["windows"]
    assert {*likely[0]} == edges | {"probability_in_frame"}
    both = client.get(f"{at}?include=view,probability").json()["windows"]
    merged = zip(cities["windows"], likely, strict=True)
    assert both == [view | probability for view, probability in merged]
    assert client.get(f"{at}?include=reasons").json()["reasons"] == []


def test_searches_are_listed_and_deleted(client):
    made_id = client.post(PATH, json=CITIES | {"name": "to go"}).json()["id"]
    answer = client.get(f"{PATH}?name=to go&target=london&after=2015-03-01T11:00:00Z").json()
    [row] = answer["opportunities"]
    assert (row["id"], row["state"], row["targets"]) == (made_id, "done", ["Las Vegas", "London"])
    assert (row["start"], row["stop"]) == ("2015-02-27T12:00:00.000Z", "2015-03-01T12:00:00.000Z")
    assert client.delete(f"{PATH}/{made_id}").status_code == 204
    for method, tail in (("GET", ""), ("GET", ""), ("GET", "/request"), ("DELETE", "")):
        gone = client.request(method, f"{PATH}/{made_id}{tail}")
        assert gone.status_code == 404, (method, tail)
        assert f"GET {PATH} lists them" in gone.json()["detail"]
    assert client.get(f"{PATH}?name=to go").json() == {"opportunities": [], "next": None}
    audit = client.get("/v1/audit").json()["entries"]
    deeds = [entry["action"] for entry in audit if entry["subject"] == made_id]
    assert deeds == ["opportunities.delete", "opportunities.accept"]


def test_an_id_of_something_else_is_none(client):
    assert client.get("/v1/plans").json()["plans"] == []
    assert client.get(f"{PATH}/{new_id()}").status_code == 404
    search_id = client.post(PATH, json=SKY).json()["id"]
    for path in ("plans", "campaigns", "spacecraft/plans"):
        assert client.get(f"/v1/{path}/{search_id}").status_code == 404
        assert search_id not in client.get(f"/v1/{path}?limit=200").text


def test_windows_come_in_pages(client, cities):
    found, url = [], f"{PATH}/{cities['id']}?limit=2&{VIEW}"
    while url:
        answer = client.get(url)
        page = answer.json()
        assert 0 < len(page["windows"]) <= 2
        found += page["windows"]
        link = answer.links.get("next")
        assert (link is None) == (page["next"] is None)
        assert link is None or f"cursor={page['next']}" in link["url"]
        url = link and link["url"]
    assert found == cities["windows"]
    assert len(found) > 2


def test_a_page_that_is_known_is_not_sent_again(client, cities):
    address = f"{PATH}/{cities['id']}"
    tags = set()
    for query in (
        "?limit=1",
        "?limit=2",
        "?limit=1&cursor=1",
        "?limit=1&target=London",
        f"?limit=1&{VIEW}",
    ):
        page = client.get(address + query)
        tags.add(page.headers["etag"].removeprefix("W/"))
        again = client.get(address + query, headers={"If-None-Match": page.headers["etag"]})
        assert (again.status_code, again.content) == (304, b"")
    csv = client.get(address + "?limit=1", headers={"Accept": "text/csv"})
    assert csv.headers["content-disposition"].startswith("attachment; ")
    assert len({*tags, csv.headers["etag"].removeprefix("W/")}) == 6
    gone = f"{PATH}/{new_id()}"
    assert client.get(gone, headers={"If-None-Match": "*"}).status_code == 404


def test_windows_of_one_target(client, cities):
    of_london = [window for window in cities["windows"] if window["target"] == "London"]
    answer = client.get(f"{PATH}/{cities['id']}?target=London&{VIEW}").json()
    assert (answer["windows"], answer["next"]) == (of_london, None)
    assert client.get(f"{PATH}/{cities['id']}?target=Lon").json()["windows"] == []


def test_a_target_of_any_name_is_found_by_it(client):
    name = 'Zürich "§\\7, 東京'
    target = {"id": name, "target": CITIES["targets"][0]["target"]}
    made_id = client.post(PATH, json=CITIES | {"targets": [target]}).json()["id"]
    answer = client.get(f"{PATH}/{made_id}", params={"target": name}).json()
    assert {window["target"] for window in answer["windows"]} == {name}


@pytest.mark.parametrize(
    ("query", "field", "says"),
    [
        ("limit=0", "limit", "at least 1"),
        ("limit=10001", "limit", "at most 10000"),
        ("limit=501&include=probability", "limit", "at most 500"),
        ("include=weather", "include", "view, probability, reasons"),
        ("include=view,", "include", "view, probability, reasons"),
        ("limit=x", "limit", "whole number"),
        ("cursor=-1", "cursor", "at least 0"),
        ("target=%07", "target", "can't be seen"),
        ("target=", "target", "at least 1"),
        ("page=2", "page", "not known here"),
    ],
)
def test_pages_that_there_can_t_be_are_refused(client, cities, query, field, says):
    answer = client.get(f"{PATH}/{cities['id']}?{query}")
    assert answer.status_code == 422
    assert answer.json()["field"] == f"query.{field}"
    assert says in answer.json()["detail"]


def test_pass_table(cities):
    """As people know it; against Skyfield: tests/oracles/test_view_skyfield.py."""
    for window in cities["windows"]:
        sky = window["sky"]
        times = [sky[event]["at"] for event in ("rise", "culmination", "set")]
        assert times == [window["rise"], window["highest_at"], window["set"]]
        assert sky["culmination"]["elevation_deg"] == window["highest_deg"]
        assert sky["rise"]["elevation_deg"] == window["through"]["elevation_deg"][0]
        assert sky["set"]["sun_elevation_deg"] == window["through"]["sun_elevation_deg"][-1]
        # Local solar time follows the Sun: before noon it stands in the east.
        is_morning = sky["rise"]["local_solar_time"] < "12:00:00"
        assert is_morning == (sky["rise"]["sun_azimuth_deg"] < 180.0)
    vegas = CITIES["targets"][0]["target"]
    place = cities["windows"][0]["place"]
    assert place == pytest.approx({k: vegas[k] for k in place}, abs=1e-3)


def test_as_geojson(client, cities):
    answer = client.post(PATH, json=CITIES, headers=GEOJSON)
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "application/geo+json"
    assert answer.headers["content-disposition"].endswith('.geojson"')
    assert answer.headers["vary"] == "Accept, Accept-Encoding"
    collection = answer.json()
    kept = client.get(answer.headers["Location"], headers=GEOJSON).json()
    assert kept == collection
    assert collection["id"] in answer.headers["Location"]
    assert (collection["type"], collection["unseen"]) == ("FeatureCollection", [])
    ids = [feature["id"] for feature in collection["features"]]
    assert len({*ids}) == len(ids) == len(cities["windows"])
    for feature, window in zip(collection["features"], cities["windows"], strict=True):
        told, place = feature["properties"], window["place"]
        point = [place["longitude_deg"], place["latitude_deg"], place["height_m"]]
        assert feature["geometry"] == {"type": "Point", "coordinates": point}
        assert told["datetime"] == f"{window['rise']}/{window['set']}"
        assert told["session"] == window["session"]
        assert told["off_nadir_deg"] == window["closest"]["off_nadir_deg"]
        assert told["culmination_azimuth_deg"] == window["sky"]["culmination"]["azimuth_deg"]
        assert told["sun_elevation_deg"] == window["sky"]["culmination"]["sun_elevation_deg"]
    page = client.get(f"{kept and answer.headers['Location']}?limit=1", headers=GEOJSON)
    assert page.json()["features"] == collection["features"][:1]
    assert page.json()["next"] == 1


def test_as_a_table(client, cities):
    found = rows(client.get(f"{PATH}/{cities['id']}", headers=CSV))
    assert len(found) == len(cities["windows"])
    for row, window in zip(found, cities["windows"], strict=True):
        assert (row["target"], row["rise"]) == (window["target"], window["rise"])
        assert row["culmination"] == window["highest_at"]
        assert float(row["set_azimuth_deg"]) == window["sky"]["set"]["azimuth_deg"]
        assert row["local_solar_time"] == window["sky"]["culmination"]["local_solar_time"]
        assert float(row["range_km"]) == window["closest"]["range_km"]
    assert list(found[0])[:4] == ["target", "rise", "rise_azimuth_deg", "rise_elevation_deg"]


def test_what_is_in_space_has_no_ground(client):
    sky = client.post(f"{PATH}?{VIEW}", json=SKY)
    assert {json.dumps([w["sky"], w["place"]]) for w in sky.json()["windows"]} == {"[null, null]"}
    at = sky.headers["Location"]
    features = client.get(at, headers=GEOJSON).json()["features"]
    assert {feature["geometry"] for feature in features} == {None}
    assert {feature["properties"]["sun_elevation_deg"] for feature in features} == {None}
    [*found] = rows(client.get(at, headers=CSV))
    assert {row["rise_azimuth_deg"] for row in found} == {""}
    assert all(row["culmination"] for row in found)


def test_many_windows_stream_in_another_form(client, monkeypatch):
    """Told of in several parts, by whoever reads all of them."""
    monkeypatch.setattr(search_routes, "STREAMED", 150)
    targets = [
        {"id": f"{n}", "target": {"mode": "ground", "latitude_deg": n / 2.0, "longitude_deg": n}}
        for n in range(120)
    ]
    asked = CITIES | {"targets": targets, "conditions": {}}
    first = client.post(f"{PATH}?limit=5&{VIEW}", json=asked)
    at, count = first.headers["Location"], first.json()["count"]
    assert count > 500
    whole = client.get(f"{at}?limit=10000&{VIEW}").json()
    windows = whole["windows"]
    assert (len(windows), whole["next"]) == (count, None)
    assert (first.json()["windows"], first.json()["next"]) == (windows[:5], 5)
    posted = client.post(PATH, json=asked, headers=GEOJSON).json()
    streamed = client.get(at, headers=GEOJSON).json()
    assert streamed["features"] == posted["features"]
    ids = [f"{window['target']}/{window['rise']}" for window in windows]
    assert [feature["id"] for feature in streamed["features"]] == ids
    table = rows(client.get(at, headers=CSV))
    assert [f"{row['target']}/{row['rise']}" for row in table] == ids
    for begin in (0, 490, count - 10, count):
        page = client.get(f"{at}?cursor={begin}&limit=20&{VIEW}").json()
        assert page["windows"] == windows[begin : begin + 20]
        assert page["next"] == (begin + 20 if begin + 20 < count else None)


@pytest.mark.parametrize(("method", "tail"), [("POST", ""), ("GET", "/{id}")])
def test_other_forms_are_not_to_be_had(client, cities, method, tail):
    path = PATH + tail.format(id=cities["id"])
    answer = client.request(method, path, json=CITIES, headers={"Accept": "image/png"})
    assert answer.status_code == 406
    assert "application/geo+json" in answer.json()["detail"]
