"""Imaging sessions of the spacecraft over HTTP."""

from app.answers.spacecraft import SpacecraftDryRunResponse, SpacecraftPlanResponse
from app.answers.spacecraft_view import SpacecraftViewResponse
from app.http.routes.plan_routes import plan_routes
from app.http.routes.resources import PlanResource
from app.jobs.kinds import SPACECRAFT_PLAN
from app.requests.examples import SPACECRAFT_EXAMPLES
from app.requests.listings import listing_of_imaging
from app.requests.spacecraft import read_spacecraft_request
from app.work.spacecraft import stored_session_file, stored_session_json, try_session
from app.work.view import DRAWN_SESSION, stored_session_view
from planner.spacecraft.export import IMAGING_EXPORTERS

_PLANS = PlanResource(
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
    request_schema="ImagingPlanRequest",
    listing=listing_of_imaging,
    examples=SPACECRAFT_EXAMPLES,
    response=SpacecraftPlanResponse,
    read=read_spacecraft_request,
    dry_run=try_session,
    dry_run_response=SpacecraftDryRunResponse,
    exporters=IMAGING_EXPORTERS,
    table_json=stored_session_json,
    table_file=stored_session_file,
    view_response=SpacecraftViewResponse,
    view_exporters=DRAWN_SESSION,
    view_file=stored_session_view,
    file_stem="session",
)

router = plan_routes(_PLANS)
