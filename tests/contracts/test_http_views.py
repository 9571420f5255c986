"""Does a plan's view over HTTP hold what there is to see, in every format?"""

import pytest
from waiting import PatientClient

from app.http.app import create_app
from app.requests.examples.plan import LAS_VEGAS


@pytest.fixture(scope="module")
def client():
    with PatientClient(create_app()) as client:
        yield client


def made(client, document):
    answer = client.post("/v1/plans", json=document)
    assert answer.status_code == 201, answer.text
    return answer.json()


@pytest.fixture(scope="module")
def plan(client):
    return made(client, LAS_VEGAS)


def seen(client, plan, query=""):
    answer = client.get(f"/v1/plans/{plan['id']}/view{query}")
    assert answer.status_code == 200, answer.text
    return answer


@pytest.fixture(scope="module")
def view(client, plan):
    return seen(client, plan, "?step_s=0.2").json()


def columns(section):
    return {name: values for name, values in section.items() if isinstance(values, list)}


def test_every_column_has_a_line_for_every_row(view, plan):
    rows = len(plan["table"]["t_s"])
    assert view["t_s"] == plan["table"]["t_s"]
    assert len(view["activity"]) == len(view["session"]) == rows
    sections = [view[name] for name in ("carrier", "boresight", "footprint", "sun", "moon")]
    target = {k: v for k, v in view["targets"][0].items() if k != "windows"}
    for section in (*sections, view["pointing"], target, *view["axes"].values()):
        assert columns(section)
        for name, values in columns(section).items():
            assert len(values) == rows, name


def test_the_axes_are_the_tables(view, plan):
    for axis in ("alpha", "beta"):
        assert view["axes"][axis]["angle_deg"] == plan["table"][f"{axis}_deg"]
        assert view["axes"][axis]["rate_deg_s"] == plan["table"][f"{axis}_rate_deg_s"]
