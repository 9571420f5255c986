"""What does the disposable child do for an imaging session?"""

from datetime import datetime

from app.api.provenance import ProvenanceOut
from app.api.spacecraft_response import spacecraft_plan_json
from planner.spacecraft.export import IMAGING_EXPORTERS
from planner.spacecraft.plan import plan_imaging
from planner.spacecraft.requests import ImagingPlanRequest


def session_json(request: ImagingPlanRequest, provenance: ProvenanceOut) -> bytes:
    """The whole answer as UTF-8 JSON."""
    return spacecraft_plan_json(plan_imaging(request), provenance)


def session_file(request: ImagingPlanRequest, format_name: str, created_utc: datetime) -> bytes:
    """The table by itself."""
    return IMAGING_EXPORTERS[format_name].write(plan_imaging(request), created_utc)
