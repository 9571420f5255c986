"""Plans of the two-axis platform over HTTP."""

from app.answers.members import ProvenanceOut
from app.answers.plan import DryRunResponse, PlanResponse
from app.http.routes.end_of_plan import from_end_of_plan
from app.http.routes.plan_routes import plan_routes
from app.http.routes.resources import PlanResource
from app.jobs.kinds import PLAN
from app.requests.examples.plan import PLAN_EXAMPLES
from app.requests.plan import PlanRequest, read_plan_request
from app.work.plan import stored_table_file, stored_table_json
from planner.export import EXPORTERS


def _dry_run(spec: PlanRequest, provenance: ProvenanceOut) -> DryRunResponse:
    return DryRunResponse(
        valid=True,
        name=spec.name,
        platform=spec.platform.name,
        sessions=len(spec.sessions),
        provenance=provenance,
    )


PLANS = PlanResource(
    kind=PLAN,
    path="/v1/plans",
    tag="plans",
    what="sessions: a verified command table",
    about="""Slews and tracks for every session, one row of angles and rates per 0.2 s.

    The plan is checked by a verification of its own before it is returned.  What can't be
    flown is refused with the axis, the limit and the earliest start that works.
    """,
    request_schema="PlanRequest",
    examples=PLAN_EXAMPLES,
    response=PlanResponse,
    read=read_plan_request,
    dry_run=_dry_run,
    dry_run_response=DryRunResponse,
    exporters=EXPORTERS,
    table_json=stored_table_json,
    table_file=stored_table_file,
    file_stem="plan",
    in_campaigns=True,
    fill_in=from_end_of_plan,
)

router = plan_routes(PLANS)
