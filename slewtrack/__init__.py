"""slewtrack from Python: the functions of the HTTP service and the command.

`Client` and `AsyncClient` ask a running service; the functions here do the same in this process,
where nothing is kept, and return the planner's own values, in radians.

A request is the JSON that the service takes, as bytes or as the dictionary it holds, or the
value that reading it gives.  Each function loads what it needs when it is first called.  A
request that can't be read or fulfilled raises a `planner.base.errors.Refusal`, which names the
field, the reason and the way out.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING, TypeVar

from slewtrack.client import (
    AsyncClient,
    BadAnswer,
    Cancelled,
    Client,
    Columns,
    Job,
    Json,
    NoAnswer,
    NotFinished,
    OnProgress,
    Problem,
    Progress,
    Refused,
    ServiceError,
    columns_of,
)

if TYPE_CHECKING:
    from app.requests.plan import PlanRequest
    from estimator.images import Pixels
    from estimator.pipeline import VerticalEstimate
    from estimator.request import HorizonRequest
    from planner.inflight.flights.summary import PlanFlights
    from planner.inflight.telemetry.compare import Comparison
    from planner.planning.campaigns import Campaign, CampaignRequest
    from planner.planning.opportunities import Opportunities, OpportunityRequest
    from planner.planning.sessions.plan import Plan
    from planner.spacecraft.plan import ImagingPlan
    from planner.spacecraft.requests import ImagingPlanRequest
    from planner.world.plan import FlightPlan
    from planner.world.scenario import Scenario

__all__ = [
    "AsyncClient",
    "BadAnswer",
    "Cancelled",
    "Client",
    "Columns",
    "Job",
    "NoAnswer",
    "NotFinished",
    "Problem",
    "Progress",
    "Refused",
    "ServiceError",
    "campaign",
    "compare",
    "estimate_vertical",
    "export",
    "fly",
    "opportunities",
    "plan",
    "plan_imaging",
    "read_request",
    "view",
]

Request = TypeVar("Request")


def read_request(request: Json) -> "PlanRequest":
    """The request for a plan, every field checked; a `Scenario`, with its horizon cameras."""
    from app.requests.plan import read_plan_request

    return _value_of(request, read_plan_request)


def plan(request: "Scenario | Json", *, progress: OnProgress | None = None) -> "Plan":
    """Slews and tracks for every session, as a verified command table; degrees in, radians out."""
    from planner.planning.sessions.pipeline import make_plan

    scenario = read_request(request) if isinstance(request, bytes | Mapping) else request
    return make_plan(scenario, _on_stage(progress))


def view(plan: "Plan", *, step_s: float | None = None) -> Columns:
    """What there is to see along a plan, in the columns of `Client.view`: degrees and metres."""
    from app.answers.view import view_json
    from planner.output.view import view_plan

    seen = view_plan(plan, step_s, plan.scenario.platform.camera.pixel_arcsec)
    told = view_json(seen, "", verified=plan.verification.passed)
    return columns_of(json.loads(told))


def export(plan: "Plan", format_name: str) -> bytes:
    """Its table as a file, as `Client.export` has it; raises Unverified, InvalidInput."""
    from app.answers.plan import require_verified
    from planner.base.errors import InvalidInput
    from planner.output.export import EXPORTERS

    if format_name not in EXPORTERS:
        raise InvalidInput(f"must be one of {', '.join(EXPORTERS)}", field="format_name")
    require_verified(plan.verification.findings)
    return EXPORTERS[format_name].write(plan, datetime.now(UTC))


def fly(
    plan: "Plan", *, runs: int = 400, seed: int = 0, progress: OnProgress | None = None
) -> "PlanFlights":
    """The plan flown many times with errors drawn anew: what its camera holds, and how sharply."""
    from planner.inflight.flights.pipeline import fly_plan

    tell = _on_stage(progress)
    return fly_plan(plan, runs, seed, lambda done: tell("runs", done, runs))


def opportunities(request: "OpportunityRequest | Json") -> "Opportunities":
    """When each target can be seen, without planning anything."""
    from app.requests.opportunities import read_opportunity_request
    from planner.planning.opportunities import find_opportunities

    return find_opportunities(_value_of(request, read_opportunity_request))


def campaign(
    request: "CampaignRequest | Json", *, progress: OnProgress | None = None
) -> "Campaign":
    """Which of many targets to look at and in what order; its passes are planned one by one."""
    from app.requests.campaign import read_campaign_request
    from planner.planning.campaigns import choose_campaign

    on_stage = _on_stage(progress)
    return choose_campaign(_value_of(request, read_campaign_request), on_stage)


def estimate_vertical(
    images: "Sequence[bytes | Pixels]", request: "HorizonRequest | Json"
) -> "VerticalEstimate":
    """The nadir in body axes from one image per camera, files' bytes or arrays of pixels."""
    from app.requests.horizon import read_estimate_request
    from estimator.images import decode_image
    from estimator.pipeline import estimate_vertical as estimate

    pixels = [decode_image(image) if isinstance(image, bytes) else image for image in images]
    return estimate(pixels, _value_of(request, read_estimate_request))


def compare(
    plan: "FlightPlan",
    csv: bytes,
    *,
    epoch: datetime | None = None,
    columns: Mapping[str, str] | None = None,
) -> "Comparison":
    """What flew beside a plan: telemetry as CSV; epoch: from which its t_s counts, the plan's.

    columns: what the file calls its columns, by names such as t_s, alpha_deg, beta_rate_deg_s.
    """
    from planner.inflight.telemetry.compare import compare as compare_samples
    from planner.inflight.telemetry.samples import read_csv

    names = plan.scenario.platform.axis_names
    return compare_samples(plan, read_csv(csv, names, epoch, plan.table.epoch_utc, columns))


def plan_imaging(
    request: "ImagingPlanRequest | Json", *, progress: OnProgress | None = None
) -> "ImagingPlan":
    """An imaging session of the spacecraft with four gyros: a verified attitude table."""
    from app.requests.spacecraft import read_spacecraft_request
    from planner.spacecraft.plan import plan_imaging as make

    return make(_value_of(request, read_spacecraft_request), _on_stage(progress))


def _on_stage(progress: OnProgress | None) -> Callable[..., None]:
    """What the planner tells of itself, as a service would."""

    def tell(stage: str, done: int | None = None, of: int | None = None) -> None:
        if progress is not None:
            progress(Progress(state="running", stage=stage, done=done, of=of))

    return tell


def _value_of(request: Request | Json, read: Callable[[bytes], Request]) -> Request:
    if isinstance(request, bytes):
        return read(request)
    if isinstance(request, Mapping):
        return read(json.dumps(request).encode())
    return request
