"""Plans over HTTP: of either kind of platform, and imaging sessions of the spacecraft."""

from app.http.routes.end_of_plan import from_end_of_plan, may_go_on_after
from app.http.routes.parameters import PlanListQuery
from app.http.routes.plan_routes import PlanResource
from app.jobs.kinds import PLAN, SPACECRAFT_PLAN
from app.requests.examples import PLAN_EXAMPLES, SPACECRAFT_EXAMPLES
from app.requests.plan import PLAN_READER
from app.requests.spacecraft import SPACECRAFT_READER
from app.work.plan import (
    DryRunResponse,
    PlanResponse,
    listing_of_scenario,
    stored_table_json,
    try_plan,
)
from app.work.spacecraft import (
    SpacecraftDryRunResponse,
    SpacecraftPlanResponse,
    listing_of_imaging,
    stored_session_json,
    try_session,
)

PLANS = PlanResource(
    kind=PLAN.name,
    also=frozenset({SPACECRAFT_PLAN.name}),
    path="/v1/plans",
    tag="plans",
    what="sessions of a platform",
    about="""Computes slews and tracks for every session, and a row of angles and rates every 0.2 s.

    An independent verification checks the table before it is returned.  A session that can't be
    flown is refused with the axis, the limit and the earliest start that works.
    """,
    requests=PLAN_READER,
    listing=listing_of_scenario,
    list_query=PlanListQuery,
    examples=PLAN_EXAMPLES,
    response=PlanResponse,
    dry_run=try_plan,
    dry_run_response=DryRunResponse,
    table_json=stored_table_json,
    file_stem="plan",
    lacks=may_go_on_after,
    fill_in=from_end_of_plan,
)
SPACECRAFT_PLANS = PlanResource(
    kind=SPACECRAFT_PLAN.name,
    path="/v1/spacecraft/plans",
    tag="spacecraft",
    what="an imaging session of the CMG spacecraft",
    about="""Chooses and orders the requests that fit, slews between scans, and simulates the
    table in closed loop.

    An independent verification checks every table before it is returned.  Requests that don't
    fit are listed in `left_out` with the reason; when none fits, the session is refused with
    the nearest way out.
    """,
    requests=SPACECRAFT_READER,
    listing=listing_of_imaging,
    examples=SPACECRAFT_EXAMPLES,
    response=SpacecraftPlanResponse,
    dry_run=try_session,
    dry_run_response=SpacecraftDryRunResponse,
    table_json=stored_session_json,
    document="session_document",
    file_stem="session",
)

router = PLANS.routes()
of_spacecraft = SPACECRAFT_PLANS.routes()
