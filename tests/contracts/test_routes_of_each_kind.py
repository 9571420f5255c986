"""Each route answers each kind of platform as the table of docs/http.md says."""

import csv
import io
import json
import re
from pathlib import Path

import other_body
import pytest
from other_body import EXAMPLE, Flown, written
from waiting import eventually

from app.requests.examples import ESTIMATE_EXAMPLE
from planner.output.export import EXPORTERS

DOCS = Path(__file__).parents[2] / "docs" / "http.md"
KINDS = {"two_axis": "iss-hrc", "body": "smallsat-120kg", "gyros": "agile-cmg"}
NO_PLATFORM = ("/v1/orbits/", "/v1/horizon/")  # asked of an orbit or of cameras


def table_of_kinds():
    """By what is asked and kind, how its cell begins."""
    text = DOCS.read_text().split("## Each kind of platform")[1].split("\n## ")[0]
    rows = [re.split(r"(?<!\\) \| ", line.strip("| ")) for line in text.splitlines() if "|" in line]
    names, _, *rows = rows
    assert len(names) == 1 + len(KINDS)
    return {(row[0], kind): cell for row in rows for kind, cell in zip(KINDS, row[1:], strict=True)}


def asked(kind, **changes):
    """A plan of one city, seen high above it."""
    request = json.loads(EXAMPLE.read_text()) if kind == "two_axis" else other_body.body_request(1)
    request |= {"platform": KINDS[kind], "sessions": request["sessions"][:1]}
    [session] = request["sessions"]
    session |= {"start": "2015-05-10T10:35:50Z", "stop": "2015-05-10T10:36:40Z"}
    return request | changes


def search(kind):
    request = asked(kind)
    parts = {name: request[name] for name in ("platform", "orbit", "attitude") if name in request}
    [session] = request["sessions"]
    return parts | {
        "targets": [{"id": "London", "target": session["target"]}],
        "start": "2015-05-10T10:00:00Z",
        "stop": "2015-05-10T11:00:00Z",
    }


def looks(kind):
    found = search(kind)
    found["targets"][0]["session_s"] = 30.0
    return found | ({"rest_angles_deg": {"alpha": 0.0, "beta": 0.0}} if kind == "two_axis" else {})


class Asked:
    """A service, and one plan of each kind."""

    def __init__(self, client, kind):
        self.post, self.get, self.kind = client.post, client.get, kind
        answer = client.post("/v1/plans", json=asked(kind))
        assert answer.status_code == 201, answer.text
        self.plan = answer.json()["id"]

    def plan_with(self, **changes):
        return self.post("/v1/plans?dry_run=true", json=asked(self.kind, **changes))

    def campaign_planned(self):
        answer = self.post("/v1/campaigns", json=looks(self.kind))
        where = f"/v1/campaigns/{answer.json()['id']}"
        done = eventually(
            lambda: (now := self.get(where)).json()["state"] not in ("queued", "running") and now
        )
        assert [one["state"] for one in done.json()["passes"]] == ["done"], done.text
        return answer

    def compared(self, **members):
        columns = self.get(f"/v1/plans/{self.plan}/table?format=json").json()
        if self.kind == "two_axis":
            text = io.StringIO()
            names = ["t_s", "alpha_deg", "beta_deg"]
            csv.writer(text).writerows([names, *zip(*(columns[one] for one in names), strict=True)])
            told = text.getvalue().encode()
        else:
            told = written(columns, Flown(), 1)
        parts = {"samples": ("telemetry.csv", told, "text/csv")}
        request = {"request": json.dumps({"plan": self.plan, **members})}
        return self.post("/v1/telemetry/comparisons", data=request, files=parts)


ROUTES = {
    "`POST /v1/plans`": lambda at: at.plan_with(),
    "`slew.keep_out`": lambda at: at.plan_with(
        slew={"keep_out": [{"body": "sun", "half_angle_deg": 10.0}]}
    ),
    "`slew.method: spline`": lambda at: at.plan_with(slew={"method": "spline"}),
    "`horizon_cameras`": lambda at: at.plan_with(horizon_cameras=ESTIMATE_EXAMPLE["cameras"][:1]),
    "`GET /v1/plans/{id}/table`": lambda at: max(
        (at.get(f"/v1/plans/{at.plan}/table?format={name}") for name in EXPORTERS),
        key=lambda answer: answer.status_code,
    ),
    "`GET /v1/plans/{id}/view`": lambda at: at.get(f"/v1/plans/{at.plan}/view"),
    "`POST /v1/plans/{id}/flights`": lambda at: at.post(
        f"/v1/plans/{at.plan}/flights", json={"runs": 2}
    ),
    "`POST /v1/opportunities`": lambda at: at.post("/v1/opportunities", json=search(at.kind)),
    "`POST /v1/campaigns`": lambda at: at.campaign_planned(),
    "`POST /v1/telemetry/comparisons`": lambda at: at.compared(),
    "`identify`": lambda at: at.compared(identify=["alpha.coulomb_deg_s2"]),
    "`corrections`": lambda at: at.compared(
        corrections=[
            {"epoch": "2015-05-10T10:36:00Z", "turn_body_deg": [0.3, 0.1, 0.2],
             "covariance_deg2": [[1e-4, 0.0, 0.0], [0.0, 1e-4, 0.0], [0.0, 0.0, 1e-4]]}
        ]
    ),
}  # fmt: skip


@pytest.fixture(scope="module", params=[*KINDS])
def at(request, client):
    return Asked(client, request.param)


def test_each_cell_of_the_table_is_what_the_route_answers(at):
    told = table_of_kinds()
    assert {what for what, _ in told} == {*ROUTES}
    for what, ask in ROUTES.items():
        answer, cell = ask(at), told[what, at.kind]
        if answer.is_success:
            assert cell.startswith("yes"), (what, cell)
        else:
            assert answer.status_code == 422, answer.text
            assert re.match("no: .{10}", cell), (what, cell, answer.text)


def test_no_route_that_takes_a_platform_lacks_a_row(client):
    paths = client.get("/openapi.json").json()["paths"]
    asking = {
        f"`POST {path}`"
        for path, methods in paths.items()
        if "post" in methods and not path.startswith(("/v1/spacecraft/", *NO_PLATFORM))
    }
    assert asking <= {what for what, _ in table_of_kinds()}
