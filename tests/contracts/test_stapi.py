"""STAPI by a plain HTTP client: its classes, its published schema, orders that become plans."""

import json
from pathlib import Path

import pytest
import stapi_pydantic
import yaml
from databases import own_settings
from fastapi.testclient import TestClient
from jsonschema import Draft202012Validator
from waiting import eventually

from app.http.app import create_app
from app.settings import Settings
from planner.base.errors import InvalidInput

ROOT = Path(__file__).parents[2]
PRODUCTS = ROOT / "examples" / "stapi_products.json"
SPECIFICATION = yaml.safe_load((ROOT / "tests/data/stapi/openapi.yaml").read_text("utf-8"))
LAS_VEGAS = {"type": "Point", "coordinates": [-115.1728, 36.1147]}
ISS, SMALLSAT = "/stapi/products/iss-hrc", "/stapi/products/smallsat"
DAY = "2015-02-27T12:00:00Z/2015-02-28T12:00:00Z"
OFF_NADIR, SUN = {"property": "view:off_nadir"}, {"property": "view:sun_elevation"}
ASKED = {"datetime": DAY, "geometry": LAS_VEGAS, "order_parameters": {}}
AREA = {
    "type": "Polygon",
    "coordinates": [
        [[-115.2, 36.0], [-115.1, 36.0], [-115.1, 36.08], [-115.2, 36.08], [-115.2, 36.0]]
    ],
}


@pytest.fixture(scope="module")
def settings(tmp_path_factory):
    return own_settings(tmp_path_factory.mktemp("stapi"), stapi_products=PRODUCTS, workers=1)


@pytest.fixture(scope="module")
def client(settings):
    with TestClient(create_app(settings)) as client:
        yield client


def as_published(name, answer):
    """Its JSON, which STAPI's classes read and its published schema admits."""
    told = answer.json()
    kind = getattr(stapi_pydantic, name)
    if name in ("Order", "OrderCollection", "OrderStatuses"):
        kind = kind[stapi_pydantic.OrderStatus]
    if name == "OpportunityCollection":
        kind = kind[stapi_pydantic.order.Geometry, stapi_pydantic.OpportunityProperties]
    kind.model_validate(told)
    schemas = SPECIFICATION["components"]["schemas"]
    [published] = {name, f"{name}_OrderStatus_"} & schemas.keys() - ({"Order"} & {name})
    whole = {"$ref": f"#/components/schemas/{published}", **SPECIFICATION}
    assert not [*map(str, Draft202012Validator(whole).iter_errors(told))]
    return told


def by_rel(told):
    return {link["rel"]: link for link in told["links"]}


def opportunities(client, product=ISS, **asked):
    answer = client.post(f"{product}/opportunities", json=ASKED | asked)
    assert answer.status_code == 200, answer.text
    assert answer.headers["Content-Type"] == "application/geo+json"
    return as_published("OpportunityCollection", answer)


def ordered(client, product=ISS, **asked):
    """An order once nothing more is to happen to it."""
    answer = client.post(f"{product}/orders", json=ASKED | asked)
    assert answer.status_code == 201, answer.text
    as_published("Order", answer)
    return eventually(lambda: ended(client, answer.headers["Location"]))


def ended(client, location):
    told = as_published("Order", client.get(location))
    is_open = told["properties"]["status"]["status_code"] in ("received", "accepted")
    return None if is_open else told


def test_all_is_found_from_the_landing_page(client):
    root = as_published("RootResponse", client.get("/stapi/"))
    assert root == client.get("/stapi").json()
    links = by_rel(root)
    conformance = as_published("Conformance", client.get(links["conformance"]["href"]))
    assert conformance["conformsTo"] == root["conformsTo"]
    assert {one.rsplit("/", 1)[1] for one in root["conformsTo"]} == {"core", "order-statuses"}
    assert as_published("OrderCollection", client.get(links["orders"]["href"]))["features"] == []
    first = client.get(links["products"]["href"], params={"limit": 1})
    [iss], after = as_published("ProductsCollection", first)["products"], by_rel(first.json())
    [small] = client.get(after["next"]["href"]).json()["products"]
    assert [iss["id"], small["id"]] == ["iss-hrc", "smallsat"]
    for product in (iss, small):
        links = by_rel(product)
        assert as_published("Product", client.get(links["self"]["href"])) == product
        told = as_published("Conformance", client.get(links["conformance"]["href"]))
        assert told["conformsTo"] == product["conformsTo"]
        for rel in ("queryables", "order-parameters"):
            schema = client.get(links[rel]["href"]).json()
            Draft202012Validator.check_schema(schema)
            assert all(field["description"] for field in schema["properties"].values())


def test_opportunities_are_the_windows(client):
    """Each with the probability that a plan of it will state, as pages of one kept search."""
    found = opportunities(client)
    links = by_rel(found)
    kept = client.get(links["search"]["href"], params={"include": "view,probability"}).json()
    assert len(kept["windows"]) == len(found["features"]) > 1
    for window, told in zip(kept["windows"], found["features"], strict=True):
        properties = told["properties"]
        assert properties["probability_in_frame"] == window["probability_in_frame"]
        assert properties["view:off_nadir"] == window["closest"]["off_nadir_deg"]
        assert properties["session"] == window["session"]
        assert window["duration_s"] >= 10.0
        assert told["geometry"] == LAS_VEGAS
    pages, page = [], opportunities(client, limit=1)
    while "next" in by_rel(page):
        pages += page["features"]
        link = by_rel(page)["next"]
        page = as_published("OpportunityCollection", client.post(link["href"], json=link["body"]))
    assert pages + page["features"] == found["features"]
    other = link["body"] | {"geometry": {"type": "Point", "coordinates": [0.0, 51.5]}}
    assert client.post(link["href"], json=other).json()["field"] == "next"


@pytest.mark.parametrize(
    ("asked", "property_name", "holds"),
    [
        ({"op": "<=", "args": [OFF_NADIR, 30]}, "view:off_nadir", lambda x: x <= 30),
        ({"op": ">", "args": [SUN, 33]}, "view:sun_elevation", lambda x: x > 33),
        ({"op": "<", "args": [{"property": "gsd"}, 2]}, "gsd", lambda x: x < 2),
        ({"op": "<=", "args": [{"property": "view:incidence_angle"}, 40]}, "view:incidence_angle",
         lambda x: x <= 40),
        ({"op": "and", "args": [{"op": "between", "args": [SUN, 0, 33]},
                                {"op": "<=", "args": [OFF_NADIR, 60]}]}, "view:sun_elevation",
         lambda x: 0 <= x <= 33),
    ],
)  # fmt: skip
def test_a_filter_bounds_the_windows(client, asked, property_name, holds):
    all_there_are = opportunities(client)["features"]
    found = opportunities(client, filter=asked)["features"]
    assert found
    assert all(holds(one["properties"][property_name]) for one in found)
    lengths = [sum(map(length_s, those)) for those in (found, all_there_are)]
    assert lengths[0] < lengths[1]


def length_s(feature):
    interval = stapi_pydantic.OpportunityProperties.model_validate(feature["properties"]).datetime
    return (interval[1] - interval[0]).total_seconds()


@pytest.mark.parametrize("product", [ISS, SMALLSAT])
def test_an_opportunity_that_is_ordered_becomes_a_plan(client, product):
    filter_30 = {"op": "<=", "args": [OFF_NADIR, 30]}
    [found] = opportunities(client, product, filter=filter_30)["features"]
    link = by_rel(found)["create-order"]
    assert link["method"] == "POST"
    assert link["href"].endswith(f"{product}/orders")
    told = ordered(client, product, **link["body"] | {"order_parameters": {"name": "Strip"}})
    assert told["properties"]["status"]["status_code"] == "scheduled", told
    [look] = told["properties"]["opportunity_properties"]["looks"]
    begin, end = found["properties"]["datetime"].split("/")
    assert begin < look["start"].replace("Z", "+00:00") < look["stop"].replace("Z", "+00:00") < end
    statuses = as_published("OrderStatuses", client.get(by_rel(told)["monitor"]["href"]))
    codes = [one["status_code"] for one in statuses["statuses"]]
    assert codes == ["received", "accepted", "scheduled"]
    at = [one["timestamp"] for one in statuses["statuses"]]
    assert at == sorted(at)
    plan = client.get(by_rel(told)["plan"]["href"]).json()
    assert plan["state"] == "done"
    assert plan["verification"]["passed"]
    [session, *_] = plan["summary"]["sessions"]
    assert session["start"] == look["start"]
    likely = told["properties"]["opportunity_properties"]["probability_in_frame"]
    assert likely == pytest.approx(plan["summary"]["probability_in_frame"])
    assert client.get(by_rel(told)["campaign"]["href"]).json()["name"] == "Strip"
    tables = [one for one in told["links"] if one["rel"] == "table"]
    formats = {one["href"].rsplit("=", 1)[1] for one in tables}
    assert {"csv", "aem", "czml"} <= formats
    for one in tables:
        if one["href"].endswith(("csv", "geojson")):
            answer = client.get(one["href"])
            assert answer.headers["Content-Type"].startswith(one["type"])


def test_an_area_is_ordered_as_strips(client):
    body = {"geometry": AREA, "filter": {"op": "<=", "args": [OFF_NADIR, 30]}}
    [found] = opportunities(client, **body)["features"]
    assert found["bbox"] == [-115.2, 36.0, -115.1, 36.08]
    told = ordered(client, **by_rel(found)["create-order"]["body"])
    looks = told["properties"]["opportunity_properties"]["looks"]
    assert len(looks) > 1
    assert {look["of" if "of" in look else "target"] for look in looks} == {"order"}


def test_what_can_not_be_seen_is_rejected_with_the_reason(client):
    pole = {"type": "Point", "coordinates": [0.0, 89.0]}
    assert opportunities(client, geometry=pole)["features"] == []
    status = ordered(client, geometry=pole)["properties"]["status"]
    assert (status["status_code"], status["reason_code"]) == ("rejected", "elevation")
    assert "20 deg" in status["reason_text"]
    late = "2035-02-27T12:00:00Z/2035-02-28T12:00:00Z"
    status = ordered(client, datetime=late)["properties"]["status"]
    assert (status["status_code"], status["reason_code"]) == ("rejected", "outside-coverage")


def test_no_order_is_lost_or_taken_twice(client, settings, tmp_path):
    key = {"Idempotency-Key": "one of a kind"}
    first, again = (client.post(f"{ISS}/orders", json=ASKED, headers=key) for _ in range(2))
    assert first.headers["Location"] == again.headers["Location"]
    other = ASKED | {"order_parameters": {"name": "Another"}}
    assert client.post(f"{ISS}/orders", json=other, headers=key).status_code == 422
    told = eventually(lambda: ended(client, first.headers["Location"]))
    listed = as_published("OrderCollection", client.get("/stapi/orders", params={"limit": 200}))
    assert told in listed["features"]
    pages, page = [], client.get("/stapi/orders", params={"limit": 2}).json()
    while "next" in by_rel(page):
        pages += page["features"]
        page = client.get(by_rel(page)["next"]["href"]).json()
    assert pages + page["features"] == listed["features"]
    with TestClient(create_app(settings)) as restarted:
        assert restarted.get(first.headers["Location"]).json() == told
    assert client.get("/stapi/orders/" + "0" * 36).status_code == 422
    plan_id = by_rel(told)["plan"]["href"].rsplit("/", 1)[1]
    assert client.get(f"/stapi/orders/{plan_id}").status_code == 404


def test_an_order_that_waits_is_cancelled_as_its_campaign(client):
    posted = [client.post(f"{ISS}/orders", json=ASKED | {"geometry": AREA}) for _ in range(3)]
    waiting = as_published("Order", posted[-1])
    assert waiting["properties"]["status"]["status_code"] == "received"
    campaign = by_rel(waiting)["campaign"]["href"]
    assert client.delete(campaign).status_code == 200
    told = ended(client, posted[-1].headers["Location"])
    assert told["properties"]["status"]["status_code"] == "user_cancelled"
    assert client.delete(campaign).status_code == 204
    assert client.get(posted[-1].headers["Location"]).status_code == 404


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"datetime": "2015-02-27T12:00:00Z"}, "datetime"),
        ({"datetime": "../.."}, "datetime"),
        ({"datetime": "2015-02-27T12:00:00/2015-02-28T12:00:00"}, "datetime"),
        ({"datetime": "2015-02-28T12:00:00Z/2015-02-27T12:00:00Z"}, "datetime"),
        ({"datetime": "2015-02-27T12:00:00Z/2016-02-27T12:00:00Z"}, "datetime"),
        ({"datetime": "0000-01-01T00:00:00Z/.."}, "datetime"),
        ({"datetime": "/1972-01-02T00:00:00Z"}, "datetime"),
        ({"datetime": None}, "datetime"),
        ({"geometry": None}, "geometry"),
        ({"geometry": {"type": "MultiPoint", "coordinates": [[0.0, 0.0]]}}, "geometry.type"),
        ({"geometry": {"type": "Point", "coordinates": [0.0, 91.0]}}, "geometry.coordinates"),
        ({"geometry": {"type": "Point", "coordinates": []}}, "geometry.coordinates"),
        ({"geometry": {"type": "Point", "coordinates": [0, 0, 2e5]}}, "geometry"),
        ({"geometry": {"type": "Polygon", "coordinates": [[[0.0, 0.0]]]}}, "geometry"),
        ({"filter": {"op": "<=", "args": [{"property": "eo:cloud_cover"}, 30]}}, "filter"),
        ({"filter": {"op": ">=", "args": [OFF_NADIR, 30]}}, "filter"),
        ({"filter": {"op": "<=", "args": [OFF_NADIR, True]}}, "filter"),
        ({"filter": {"op": "<=", "args": [OFF_NADIR, 1e999]}}, ""),
        ({"filter": {"op": "<=", "args": [OFF_NADIR, 200]}}, "filter"),
        ({"filter": {"op": "or", "args": []}}, "filter"),
        ({"filter": {"op": "between", "args": [SUN, 9, 3]}}, "filter"),
        ({"filter": []}, "filter"),
        ({"order_parameters": {"duration_s": 0.1}}, "order_parameters.duration_s"),
        ({"order_parameters": {"priority": 1}}, "order_parameters.priority"),
        (
            {"order_parameters": {"duration_s": 9.0}, "geometry": AREA},
            "order_parameters.duration_s",
        ),
        ({"order_parameters": {"name": "x" * 300}}, "order_parameters.name"),
        ({"product_id": "iss-hrc"}, "product_id"),
    ],
    ids=str,
)  # fmt: skip
def test_bad_orders_and_searches_are_refused(client, given, field):
    listed = ids_of(client)
    body = json.dumps(ASKED | given).replace("Infinity", "1e999")
    for what in ("orders", "opportunities"):
        headers = {"Content-Type": "application/json"}
        answer = client.post(f"{ISS}/{what}", content=body, headers=headers)
        assert answer.status_code == 422, answer.text
        assert answer.headers["Content-Type"] == "application/problem+json"
        assert (answer.json()["errors"][0]["field"] or "filter").startswith(field)
    assert ids_of(client) == listed


def ids_of(client):
    return [one["id"] for one in client.get("/stapi/orders").json()["features"]]


@pytest.mark.parametrize(
    ("given", "field"),
    [({"limit": 0}, "limit"), ({"limit": 501}, "limit"), ({"next": "x"}, "next"),
     ({"next": "x:1"}, "next"), ({"next": ""}, None)],
)  # fmt: skip
def test_pages_that_there_are_not(client, given, field):
    answer = client.post(f"{ISS}/opportunities", json=ASKED | given)
    assert answer.status_code == (200 if field is None else 422)
    assert field is None or answer.json()["field"] == field


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [
        ("GET", "/stapi/products/other", 404),
        ("POST", "/stapi/products/other/orders", 404),
        ("GET", "/stapi/products?next=other", 404),
        ("GET", "/stapi/products?page=2", 422),
        ("GET", "/stapi/orders?limit=0", 422),
        ("GET", f"{ISS}?limit=1", 422),
        ("DELETE", "/stapi/orders", 405),
        ("GET", "/stapi/nothing", 404),
    ],
)
def test_addresses_that_there_are_not(client, method, path, status):
    body = {"json": ASKED} if method == "POST" else {}
    answer = client.request(method, path, **body)
    assert answer.status_code == status
    assert answer.headers["Content-Type"] == "application/problem+json"
    if status == 405:
        assert "GET" in answer.headers["Allow"]


def test_an_interval_may_have_one_end(client):
    for asked, found in (
        ("2015-02-27T12:00:00Z/..", "2015-02-27T12:00:00.000000Z/2015-03-06T12:00:00.000000Z"),
        ("/2015-02-28T12:00:00Z", "2015-02-21T12:00:00.000000Z/2015-02-28T12:00:00.000000Z"),
    ):
        link = by_rel(opportunities(client, datetime=asked, limit=1))["create-order"]
        assert link["body"]["datetime"] == found


def test_keys_are_asked_for_as_everywhere(settings):
    there = settings.model_copy(update={"require_keys": True})
    with TestClient(create_app(there)) as closed:
        for path in ("/stapi", "/stapi/products", "/stapi/orders"):
            assert closed.get(path).status_code == 401
        assert closed.post(f"{ISS}/orders", json=ASKED).status_code == 401


def test_without_products_there_is_no_stapi(tmp_path):
    with TestClient(create_app(own_settings(tmp_path))) as client:
        assert client.get("/stapi").status_code == 404


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"products": []}, "products: must hold at least 1 entries"),
        ({"url": "tasking.example"}, "url: must be like https://tasking.example/"),
        ({"id": "a b"}, "products.0.id: must be 1 to 64"),
        ({"id": "smallsat"}, "products.1.id: 'smallsat' is taken"),
        ({"platform": "no-such"}, "products.0.platform: must be one of"),
        ({"platform": "smallsat-120kg"}, "products.0.attitude: must be left out"),
        ({"orbit": {"source": "none"}}, "products.0.orbit.source: must be one of"),
        ({"colour": "red"}, "products.0.colour: is not a field"),
        (None, "can't be read: No such file"),
    ],
    ids=str,
)
def test_a_file_of_products_that_is_wrong(tmp_path, changed, told):
    file = tmp_path / "products.json"
    if changed is not None:
        document = json.loads(PRODUCTS.read_text("utf-8"))
        (document if {"products", "url"} & changed.keys() else document["products"][0]).update(
            changed
        )
        file.write_text(json.dumps(document), "utf-8")
    with pytest.raises(InvalidInput) as refused:
        create_app(Settings(data_dir=tmp_path, stapi_products=file))
    assert refused.value.field == "SLEWTRACK_STAPI_PRODUCTS"
    assert told in refused.value.detail


def test_without_its_classes_the_way_to_them_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr("app.requests.stapi.find_spec", lambda _: None)
    with pytest.raises(InvalidInput, match="pip install stapi-pydantic"):
        create_app(Settings(data_dir=tmp_path, stapi_products=PRODUCTS))


def test_links_are_under_the_address_that_a_proxy_has(tmp_path):
    document = json.loads(PRODUCTS.read_text("utf-8")) | {"url": "https://tasking.example/space/"}
    file = tmp_path / "products.json"
    file.write_text(json.dumps(document), "utf-8")
    with TestClient(create_app(own_settings(tmp_path, stapi_products=file))) as client:
        told = by_rel(client.get("/stapi").json())
    assert told["products"]["href"] == "https://tasking.example/space/stapi/products"
