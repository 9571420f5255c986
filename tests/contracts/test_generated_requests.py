"""The service keeps to its own OpenAPI document, whatever is sent, in whatever order.

Schemathesis makes requests from the document, valid ones and broken ones, and follows ids from
answers to further requests.  SLEWTRACK_EXAMPLES=1000 looks longer.
"""

import os

import pytest
import schemathesis
from api_document import api_document
from hypothesis import HealthCheck, Phase, settings
from live_service import live_service
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    allow_header_conformance,
    content_type_conformance,
    response_headers_conformance,
    response_schema_conformance,
    status_code_conformance,
    unsupported_method,
    use_after_free,
)

from app.requests.examples import CAMPAIGN_EXAMPLES, LAS_VEGAS

CHECKS = [
    not_a_server_error,
    status_code_conformance,
    content_type_conformance,
    response_headers_conformance,
    response_schema_conformance,
    allow_header_conformance,
    unsupported_method,
    use_after_free,
]
CITIES = CAMPAIGN_EXAMPLES["cities"][1]
WORKED = {"/v1/plans": LAS_VEGAS, "/v1/campaigns": {**CITIES, "targets": CITIES["targets"][:1]}}
BRIEF = 12  # of each operation, some 550 in all
EXAMPLES = int(os.environ.get("SLEWTRACK_EXAMPLES", BRIEF))
BOUNDED = {
    "max_examples": EXAMPLES,
    "deadline": None,
    "derandomize": EXAMPLES == BRIEF,
    "suppress_health_check": list(HealthCheck),
    "database": None,
    "phases": [Phase.generate] if EXAMPLES == BRIEF else [Phase.explicit, Phase.generate],
}
ROUNDS = 8
STATEFUL = BOUNDED | {"max_examples": EXAMPLES // 2, "stateful_step_count": 8}


def the_document():
    """Worked examples are planned by tests of their own; here each would cost seconds."""
    document = schemathesis.openapi.from_dict(api_document())
    document.config.phases.examples.enabled = False
    document.config.phases.coverage.enabled = EXAMPLES > BRIEF
    document.config.update(request_timeout=300.0)
    return document


document = the_document()


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    with live_service(tmp_path_factory.mktemp("generated")) as service:
        yield service.address


def checks_of(case):
    may_fail = case.path == "/readyz"  # a machine that is busy enough isn't ready, and says so
    return [check for check in CHECKS if not (may_fail and check is not_a_server_error)]


@document.parametrize()
@settings(**BOUNDED)
def test_one_by_one(case, address):
    case.call_and_validate(base_url=address, checks=checks_of(case))


class _Sessions(document.as_state_machine()):
    """Follows ids from answers; what would plan is a worked example, since chance makes none."""

    def before_call(self, case):
        if case.method == "POST" and case.path in WORKED:
            case.body = WORKED[case.path]
            case.media_type = "application/json"
            if case.path == "/v1/plans":  # a busy machine plans for longer than it waits unasked
                case.headers["Prefer"] = "wait=60"

    def get_call_kwargs(self, case):
        return {"base_url": self.address}

    def validate_response(self, response, case, **_):
        self.seen.add((case.method, case.path, response.status_code))
        case.validate_response(response, checks=checks_of(case))


# It really goes on: a plan is made, something of it read, and one deleted; a campaign is begun, and
# found again.
TO_BE_MET = {
    *(("GET", "{id}", 200), ("DELETE", "{id}", 204)),
    *(("POST", "/v1/plans", 201), ("POST", "/v1/campaigns", 202), ("", "/v1/campaigns/{id}", 200)),
}


def test_one_after_the_other(address):
    _Sessions.address, _Sessions.seen = address, set()
    # What the first draws hangs on the modules that are loaded: others follow until all was met.
    for number in range(ROUNDS):
        chance = {"derandomize": STATEFUL["derandomize"] and number == 0}
        _Sessions.run(settings=settings(**STATEFUL | chance))
        met = set(_Sessions.seen)
        for method, path, code in _Sessions.seen:
            if "{id}" in path:
                met |= {(method, "{id}", code), ("", path, 200 if code < 300 else code)}
        if met >= TO_BE_MET:
            break
    assert met >= TO_BE_MET
