"""Plans of the two-axis platform over HTTP."""

from app.answers.plan import DryRunResponse, PlanResponse
from app.answers.view import PlanViewResponse
from app.http.routes.end_of_plan import from_end_of_plan
from app.http.routes.plan_routes import plan_routes
from app.http.routes.resources import PlanResource
from app.jobs.kinds import PLAN
from app.requests.examples import PLAN_EXAMPLES
from app.requests.listings import listing_of_scenario
from app.requests.plan import read_plan_request
from app.work.plan import stored_table_file, stored_table_json, try_plan
from app.work.view import DRAWN, stored_plan_view
from planner.output.export import EXPORTERS
from planner.output.view import VIEW_EXPORTERS

PLANS = PlanResource(
    kind=PLAN.name,
    path="/v1/plans",
    tag="plans",
    what="sessions of a two-axis platform",
    about="""Computes slews and tracks for every session, and a row of angles and rates every 0.2 s.

    An independent verification checks the table before it is returned.  A session that can't be
    flown is refused with the axis, the limit and the earliest start that works.
    """,
    request_schema="PlanRequest",
    listing=listing_of_scenario,
    examples=PLAN_EXAMPLES,
    response=PlanResponse,
    read=read_plan_request,
    dry_run=try_plan,
    dry_run_response=DryRunResponse,
    exporters=EXPORTERS,
    table_json=stored_table_json,
    table_file=stored_table_file,
    view_response=PlanViewResponse,
    view_exporters=VIEW_EXPORTERS | DRAWN,
    view_file=stored_plan_view,
    file_stem="plan",
    takes_pixel=True,
    in_campaigns=True,
    fill_in=from_end_of_plan,
)

router = plan_routes(PLANS)
