"""The service's answers to the worked examples.

The API's pages show it, and a test compares; `make answers` writes it down anew.
"""

import json
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import httpx2 as httpx
from child_work import spin
from fastapi.testclient import TestClient
from waiting import eventually

from app.http.app import create_app
from app.http.negotiation import EVENT_STREAM, JSON
from app.http.openapi.schema import ANSWERS
from app.http.routes import job_routes
from app.ids import new_id
from app.jobs.kinds import JOB_KINDS
from app.requests import examples
from app.settings import Settings
from app.store import jobs
from app.store.jobs import NewJob
from app.work.campaign import SUFFIXES
from app.work.searches import CSV, GEOJSON
from planner.output.export import EXPORTERS

EXAMPLES = Path(__file__).parents[2] / "examples"
SEARCHES = {"/v1/opportunities": examples.OPPORTUNITY_EXAMPLES["cities"][1]}
FLIGHTS = "/v1/flights"
LIST_MAX, LIST_SHOWN = 10, 5
LINES_MAX = 12
TEXT_MAX, TEXT_SHOWN = 1000, 60
WITHOUT_TEXT = {"application/x-netcdf", "image/png", "application/zip"}

STRIP = examples.SPACECRAFT_EXAMPLES["geojson"][1]
CITIES = examples.CAMPAIGN_EXAMPLES["cities"][1]
KEPT = {  # per resource of jobs: kind, request, formats of its table
    "/v1/plans": ("plan", examples.LAS_VEGAS, EXPORTERS),
    "/v1/spacecraft/plans": ("spacecraft", STRIP, EXPORTERS),
    "/v1/campaigns": ("campaign", CITIES, {}),
}
FILES = {"/v1/campaigns": SUFFIXES}  # by Accept


@dataclass
class Answers:
    """As OpenAPI nests them: path, method, status, media type, name of the example."""

    client: TestClient
    shown: dict[str, Any] = field(default_factory=dict)

    def ask(
        self, method: str, path: str, name: str = "answer", made_id: str = "", **given: Any
    ) -> httpx.Response:
        """Ask and keep what is answered, unless it isn't text."""
        query = given.pop("query", "")
        answer = self.client.request(method, path.format(id=made_id) + query, **given)
        assert answer.is_success, answer.text
        media_type = answer.headers["content-type"].split(";")[0]
        if media_type not in WITHOUT_TEXT:
            operation = self.shown.setdefault(path, {}).setdefault(method.lower(), {})
            answers = operation.setdefault(str(answer.status_code), {})
            answers.setdefault(media_type, {})[name] = _shown(answer, media_type)
        return answer


def _shown(answer: httpx.Response, media_type: str) -> dict[str, Any]:
    if media_type.endswith("json"):
        whole = answer.json()
        value = _shortened(whole)
        cut = (
            f"Of lists longer than {LIST_MAX} the first {LIST_SHOWN} items, of texts longer than "
            f"{TEXT_MAX} the first {TEXT_SHOWN} characters."
        )
    else:
        whole = answer.text
        lines = whole.splitlines(keepends=True)
        value = whole if media_type == EVENT_STREAM else "".join(lines[:LINES_MAX])
        cut = f"The first {LINES_MAX} lines of {len(lines)}."
    if value == whole:
        return {"summary": "As answered", "value": value}
    return {"summary": "As answered, shortened", "description": cut, "value": value}


def _shortened(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _shortened(member) for name, member in value.items()}
    if isinstance(value, list):
        shown = value[:LIST_SHOWN] if len(value) > LIST_MAX else value
        return [_shortened(item) for item in shown]
    if isinstance(value, str) and len(value) > TEXT_MAX:
        return value[:TEXT_SHOWN]
    return value


def all_answers(folder: Path) -> dict[str, Any]:
    """Of every operation."""
    with _service(folder / "works") as client:
        answers = Answers(client)
        eventually(lambda: client.get("/readyz").status_code == 200)
        for path in ("/healthz", "/readyz", "/metrics", "/v1/platforms"):
            answers.ask("GET", path)
        answers.ask("GET", "/v1/places", query="?begin=lond")
        answers.ask("GET", "/v1/stars", query="?begin=al")
        for path in KEPT:
            _made(answers, path)
        _flown(answers)
        _asked_at_once(answers)
        answers.ask("GET", "/v1/audit")
    with _that_never_ends(folder / "hangs") as client:
        answers.client = client
        for path in KEPT:
            _under_way(answers, path)
        _ended_on_request(answers, FLIGHTS, "flights", "Las Vegas, before uplink")
    return answers.shown


def _made(answers: Answers, path: str) -> None:
    kind, request, formats = KEPT[path]
    given = {"json": request, "headers": {"Prefer": "wait=60", "Idempotency-Key": kind}}
    answers.ask("POST", path, query="?dry_run=true", json=request)
    eventually(lambda: answers.client.post(path, **given).status_code == 201)
    made_id = answers.ask("POST", path, **given).json()["id"]
    for name in formats:
        answers.ask("POST", path, name=name, query=f"?format={name}", **given)
    answers.ask("GET", path)
    for media_type in (JSON, *FILES.get(path, ())):
        answers.ask("GET", f"{path}/{{id}}", made_id=made_id, headers={"Accept": media_type})
    answers.ask("GET", f"{path}/{{id}}/request", made_id=made_id)
    answers.ask("GET", f"{path}/{{id}}/events", made_id=made_id)
    if formats:
        answers.ask("GET", f"{path}/{{id}}/table", made_id=made_id)
        _seen(answers, path, made_id, formats)
    for name in formats:
        table = f"{path}/{{id}}/table"
        answers.ask("GET", table, name=name, made_id=made_id, query=f"?format={name}")


def _flown(answers: Answers) -> None:
    """A plan of its own, so that it can be made by itself."""
    plan_id = answers.client.post("/v1/plans", json=examples.LAS_VEGAS).json()["id"]
    path = "/v1/plans/{id}/flights"
    later = {"json": examples.FLIGHTS_EXAMPLES["errors"][1], "headers": {"Prefer": "respond-async"}}
    answers.ask("POST", path, made_id=plan_id, **later)
    waits = {"json": examples.FLIGHTS_EXAMPLES["series"][1], "headers": {"Prefer": "wait=60"}}
    flights_id = answers.ask("POST", path, made_id=plan_id, **waits).json()["id"]
    answers.ask("GET", path, made_id=plan_id)
    answers.ask("GET", FLIGHTS)
    answers.ask("GET", f"{FLIGHTS}/{{id}}", made_id=flights_id)
    answers.ask("GET", f"{FLIGHTS}/{{id}}/events", made_id=flights_id)


def _seen(answers: Answers, path: str, made_id: str, formats: dict[str, Any]) -> None:
    view = f"{path}/{{id}}/view"
    answers.ask("GET", view, made_id=made_id)
    for name, exporter in formats.items():
        if exporter.shows:
            answers.ask("GET", view, name=name, made_id=made_id, query=f"?format={name}")


def _asked_at_once(answers: Answers) -> None:
    for path, request in SEARCHES.items():
        _searched(answers, path, request)
    answers.ask("POST", "/v1/orbits/tracks", json=examples.ORBIT_TRACK_EXAMPLES["tle"][1])
    answers.ask("POST", "/v1/horizon/predictions", json=examples.PREDICTION_EXAMPLES["pass"][1])
    accept = {"Accept": JSON}
    answers.ask(
        "POST", "/v1/horizon/images", json=examples.PICTURE_EXAMPLES["ahead"][1], headers=accept
    )
    files = [
        ("images", (f"{name}.png", (EXAMPLES / f"horizon_{name}.png").read_bytes()))
        for name in ("ahead", "right")
    ]
    request = {"request": json.dumps(examples.ESTIMATE_EXAMPLE)}
    answers.ask("POST", "/v1/horizon/estimates", data=request, files=files)
    [plan] = answers.client.get("/v1/plans", params={"state": "done", "limit": 1}).json()["plans"]
    compared = examples.COMPARISON_EXAMPLES["angles"][1] | {"plan": plan["id"]}
    for media_type in (JSON, "text/csv", "image/svg+xml"):
        accept = {"Accept": media_type}
        answers.ask("POST", "/v1/telemetry/comparisons", json=compared, headers=accept)


def _searched(answers: Answers, path: str, request: dict[str, Any]) -> None:
    """The example's answer once; what says the same in another form of one target only."""
    everything = "view" if "requests" in request else "view,probability,reasons"
    answers.ask("POST", path, query=f"?include={everything}", json=request)
    [name] = {"targets", "requests"} & request.keys()
    little = request | {name: request[name][:1], "samples": 2}
    made_id = answers.client.post(path, json=little).json()["id"]
    for media_type in (JSON, GEOJSON, CSV):
        accept = {"Accept": media_type}
        if media_type != JSON:
            answers.ask("POST", path, json=little, headers=accept)
        windows = {"made_id": made_id, "query": "?limit=1&include=view", "headers": accept}
        answers.ask("GET", f"{path}/{{id}}", **windows)
    answers.ask("GET", path)
    answers.ask("GET", f"{path}/{{id}}/request", made_id=made_id)


def _under_way(answers: Answers, path: str) -> None:
    kind, request, _ = KEPT[path]
    one = f"{path}/{{id}}"
    later = {"Prefer": "respond-async"}
    running_id = answers.ask("POST", path, json=request, headers=later).json()["id"]
    answers.ask("DELETE", one, made_id=running_id)
    answers.client.delete(f"{path}/{running_id}").raise_for_status()
    _ended_on_request(answers, path, kind, request["name"])


def _ended_on_request(answers: Answers, path: str, kind: str, name: str) -> None:
    """What waits is ended at once, what another service works on a little later."""
    one = f"{path}/{{id}}"
    here, elsewhere = (
        NewJob(
            id=new_id(),
            kind=kind,
            name=name,
            request=b"",
            request_sha256="0" * 64,
            deadline_s=60.0,
            options={"runs": 100, "seed": 1} if kind == "flights" else {},
        )
        for _ in range(2)
    )
    if path == FLIGHTS:
        with answers.client.app.state.database.writing() as connection:
            jobs.accept(connection, here)
        answers.ask("DELETE", one, made_id=here.id)
    with answers.client.app.state.database.writing() as connection:
        jobs.accept(connection, elsewhere, lease_s=3600.0)
    with patch.object(job_routes, "CANCEL_WAIT_S", 0.0):
        answers.ask("DELETE", one, made_id=elsewhere.id)


@contextmanager
def _service(folder: Path) -> Iterator[TestClient]:
    folder.mkdir()
    app = create_app(Settings(data_dir=folder, database_url="", workers=1))
    with TestClient(app, base_url="http://localhost") as client:
        yield client


@contextmanager
def _that_never_ends(folder: Path) -> Iterator[TestClient]:
    hanging = {name: replace(kind, work=spin) for name, kind in JOB_KINDS.items()}
    with ExitStack() as stack:
        stack.enter_context(patch.dict(JOB_KINDS, hanging))
        yield stack.enter_context(_service(folder))


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary:
        document = all_answers(Path(temporary))
    ANSWERS.write_text(json.dumps(document, indent=1) + "\n")
