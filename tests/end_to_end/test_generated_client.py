"""A client generated from the schema has every operation, and plans Las Vegas.

It is generated and run by the Python of an environment of its own, which
`.ci/with-client-generator` makes: the generator wants an older typer than ours.
"""

import json
import os
import re
import subprocess
from pathlib import Path

import pytest
from live_service import live_service

from app.http.app import create_app
from app.requests.examples import LAS_VEGAS

PYTHON = os.environ.get("SLEWTRACK_TEST_CLIENT_PYTHON")
pytestmark = pytest.mark.skipif(PYTHON is None, reason="run it by .ci/with-client-generator")

# What a user of the client would write.
PLANNING = """
import json, sys
from generated import Client
from generated.api.plans import get_plan, post_plans
from generated.models import PlanRequest

client = Client(sys.argv[1], raise_on_unexpected_status=True)
request = PlanRequest.from_dict(json.load(sys.stdin))
made = post_plans.sync(client=client, body=request)
kept = get_plan.sync(id=made.id, client=client)
request.sessions[0].target.latitude_deg = 91.0
refused = post_plans.sync(client=client, body=request)
print(json.dumps({
    "passed": made.verification.passed,
    "alpha_deg": made.table["alpha_deg"],
    "elevation_deg": made.pointing[0].elevation_min_deg,
    "kept": kept.to_dict() == made.to_dict(),
    "at_fault": refused.errors[0].field,
}))
"""


@pytest.fixture(scope="module")
def generated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("client")
    document = create_app().openapi()
    (folder / "openapi.json").write_text(json.dumps(document))
    made = subprocess.run(
        [Path(PYTHON).with_name("openapi-python-client"), "generate", "--path", "openapi.json",
         "--output-path", "generated", "--meta", "none", "--fail-on-warning"],
        cwd=folder, env=os.environ | {"PATH": f"{Path(PYTHON).parent}:{os.environ['PATH']}"},
        capture_output=True, text=True,
    )  # fmt: skip
    assert made.returncode == 0, made.stdout + made.stderr
    return folder, document


def test_every_operation_is_generated(generated):
    folder, document = generated
    operations = {
        operation["operationId"]
        for path in document["paths"].values()
        for operation in path.values()
    }
    files = {file.stem for file in (folder / "generated/api").glob("*/*.py")} - {"__init__"}
    assert files == operations
    for file in (folder / "generated/api").glob("*/*_*.py"):
        answer = re.search(r"^def _parse_response.*-> (.*):$", file.read_text(), re.MULTILINE)
        assert answer is None or answer[1] != "Any | None", file


def test_it_plans_las_vegas(generated, tmp_path):
    folder, _ = generated
    with live_service(tmp_path) as service:
        ran = subprocess.run(
            [PYTHON, "-c", PLANNING, service.address],
            cwd=folder, input=json.dumps(LAS_VEGAS), capture_output=True, text=True,
        )  # fmt: skip
    assert ran.returncode == 0, ran.stderr
    told = json.loads(ran.stdout)
    assert told["passed"]
    assert len(told["alpha_deg"]) == 1151  # 230 s at 0.2 s, both ends
    assert told["elevation_deg"] == pytest.approx(35.95, abs=0.01)  # as docs and README tell
    assert told["kept"]
    assert told["at_fault"] == "sessions.0.target.latitude_deg"
