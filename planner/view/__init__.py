"""What there is to see of a plan, and the formats that hold all of it."""

from planner.export import Exporter
from planner.view.netcdf import write_view_netcdf
from planner.view.view import PlanView, view_plan

VIEW_EXPORTERS: dict[str, Exporter[PlanView]] = {
    "netcdf": Exporter(
        "the same columns (CF-1.12)", "application/x-netcdf", ".nc", write_view_netcdf
    ),
}

__all__ = ["VIEW_EXPORTERS", "PlanView", "view_plan"]
