"""Kept plans are served as they were answered, whatever is asked of requests since."""

import copy
import json
import zlib

import pytest
from sqlalchemy import update

from app.requests.examples import FOUR_MODES, PLAN_EXAMPLES, SPACECRAFT_EXAMPLES
from app.requests.spacecraft import SPACECRAFT_READER, read_spacecraft_request
from app.store.models import JobRow
from app.work.view import DRAWN
from planner.base.errors import InvalidRequest
from planner.output.export import EXPORTERS
from planner.output.view import VIEW_EXPORTERS

OWN_PLATFORM = PLAN_EXAMPLES["platform"][1]
HIDDEN = "a\0b\u202ec " + "long " * 600


def let_in_once(client, plan_id, request):
    """As a version stored it that asked less of requests."""
    packed = zlib.compress(json.dumps(request).encode())
    with client.app.state.database.writing() as connection:
        connection.execute(update(JobRow).where(JobRow.id == plan_id).values(request=packed))


def refusal(client, path, request):
    return client.post(path, json=request, params={"dry_run": "true"}).json()["errors"]


@pytest.fixture(scope="module")
def plan(client):
    """Beyond today's ranges, counts, lengths of text and characters."""
    made = client.made("/v1/plans", json=OWN_PLATFORM)
    request = copy.deepcopy(OWN_PLATFORM)
    for axis in ("outer", "inner"):
        request["platform"][axis] |= {"angle_min_deg": -2000.0, "angle_max_deg": 2000.0}
    request["platform"]["name"] = request["name"] = HIDDEN
    request["sessions"][0] |= {"id": HIDDEN, "name": "\u202e"}
    cone = {"direction_platform": [0.0, 0.0, -1.0], "half_angle_deg": 1e-6}
    request["slew"] = {"keep_out": [cone] * 99}
    assert len(refusal(client, "/v1/plans", request)) > 5
    let_in_once(client, made["id"], request)
    return made


@pytest.mark.parametrize("name", EXPORTERS)
def test_a_table_beyond_todays_bounds_in_every_format(client, plan, name):
    answer = client.get(f"/v1/plans/{plan['id']}/table?format={name}")
    assert answer.status_code == 200, answer.text
    assert answer.content


def test_its_numbers_are_those_that_were_answered(client, plan):
    where = f"/v1/plans/{plan['id']}"
    assert client.get(where).json() == plan
    assert client.get(f"{where}/table").json() == plan["table"]
    text = client.get(f"{where}/table?format=csv").text
    rows = [line.split(",") for line in text.splitlines() if not line.startswith("#")]
    column = rows[0].index("azimuth_deg")
    assert [float(row[column]) for row in rows[1:]] == plan["table"]["azimuth_deg"]


@pytest.mark.parametrize("query", ["", *(f"?format={name}" for name in VIEW_EXPORTERS)])
def test_its_view(client, plan, query):
    answer = client.get(f"/v1/plans/{plan['id']}/view{query}")
    assert answer.status_code == 200, answer.text


def test_it_is_flown_and_compared(client, plan):
    flights = client.post(f"/v1/plans/{plan['id']}/flights", json={"runs": 2})
    assert flights.status_code == 201, flights.text
    samples = {"t_s": plan["table"]["t_s"], "tilt_deg": plan["table"]["tilt_deg"]}
    compared = client.post(
        "/v1/telemetry/comparisons", json={"plan": plan["id"], "samples": samples}
    )
    assert compared.status_code == 200, compared.text


def test_a_session_of_the_spacecraft(client):
    path = "/v1/spacecraft/plans"
    asked = SPACECRAFT_EXAMPLES["geojson"][1] | {"simulation_runs": 1}
    made = client.made(path, json=asked)
    request = asked | {"name": HIDDEN, "simulation_runs": 10_000, "stop": "2024-06-02T10:10:00Z"}
    assert refusal(client, path, request)
    let_in_once(client, made["id"], request)
    where = f"{path}/{made['id']}"
    answers = [client.get(f"{where}/table?format={name}") for name in EXPORTERS]
    answers += [client.get(f"{where}/view?format={name}") for name in ("json", *DRAWN)]
    assert [answer.status_code for answer in answers] == [200] * len(answers)
    assert client.get(where).json() == made


def test_features_beyond_todays_bounds():
    """Of positions, of the map."""
    line = {"type": "LineString", "coordinates": [[500.0, 10.0]] * 70}
    feature = {"type": "Feature", "properties": {"mode": "strip", "name": "a"}, "geometry": line}
    features = {"type": "FeatureCollection", "features": [feature]}
    body = json.dumps(FOUR_MODES | {"requests": features}).encode()
    with pytest.raises(InvalidRequest, match="64 positions"):
        read_spacecraft_request(body)
    [one] = SPACECRAFT_READER.read_kept(body).requests
    assert one.geometry.coordinates == ((500.0, 10.0),) * 70


@pytest.mark.parametrize(
    ("change", "kind", "says"),
    [
        ({"colour": "blue"}, "kept-unreadable", "colour: is not a field of this object"),
        ({"platform": "hubble"}, "kept-unreadable", "platform: must be one of iss-hrc"),
        ({"orbit": {"source": "oem", "content": "none"}}, "invalid-message", "OEM line 1: 'none'"),
    ],
)
def test_a_request_in_words_of_another_version_is_told(client, change, kind, says):
    """What needs it is refused; what was answered stays."""
    made = client.made("/v1/plans", json=OWN_PLATFORM)
    let_in_once(client, made["id"], OWN_PLATFORM | change)
    where = f"/v1/plans/{made['id']}"
    for asked in ("table?format=aem", "view"):
        answer = client.get(f"{where}/{asked}")
        assert answer.status_code == (409 if kind == "kept-unreadable" else 422), answer.text
        assert answer.json()["type"] == f"urn:slewtrack:problem:{kind}"
        assert says in answer.json()["detail"]
    assert client.get(where).json() == made
    assert client.get(f"{where}/table").json() == made["table"]
