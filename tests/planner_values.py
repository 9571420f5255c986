"""The planner's own values of a request, in radians and SI; `slewtrack` answers in degrees."""

import json

from app.requests.plan import read_plan_request
from app.work.searches import read_opportunity_request
from planner.inflight.telemetry.compare import compare as compare_samples
from planner.inflight.telemetry.platforms.registry import sensors_of
from planner.inflight.telemetry.samples import read_csv
from planner.planning import opportunities
from planner.planning.campaigns import scenario_of
from planner.planning.sessions.pipeline import make_plan


def body_of(request):
    return request if isinstance(request, bytes) else json.dumps(request).encode()


def read_request(request):
    """A Scenario with its horizon cameras."""
    return read_plan_request(body_of(request))


def plan_of(request):
    """A Plan; request: JSON, or what `read_request` made of it."""
    is_read = not isinstance(request, bytes | dict)
    return make_plan(request if is_read else read_request(request))


def planned_passes(request, campaign):
    """Each pass of a campaign with its plan, which its judge has passed."""
    for number, flight in enumerate(campaign.passes):
        plan = make_plan(scenario_of(request, flight, number))
        assert plan.verification.passed
        yield flight, plan


def find_opportunities(request):
    """Windows and their targets."""
    return opportunities.find_opportunities(read_opportunity_request(body_of(request)))


def compare(plan, csv, *, epoch=None, columns=None):
    """What flew beside a plan: telemetry as CSV; epoch: from which its t_s counts, the plan's."""
    contract = sensors_of(plan).contract
    return compare_samples(plan, read_csv(csv, contract, epoch, plan.table.epoch_utc, columns))
