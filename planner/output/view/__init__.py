"""The view of a plan, and the formats that hold all of it."""

from datetime import datetime
from typing import TYPE_CHECKING

from planner.base.on_first_use import on_first_use
from planner.output.export import Exporter
from planner.output.view.columns import PlanView

if TYPE_CHECKING:
    from planner.output.view.view import view_plan
else:
    __getattr__ = on_first_use(view_plan="planner.output.view.view")


def _write_netcdf(view: PlanView, created_utc: datetime) -> bytes:
    from planner.output.view.netcdf import write_view_netcdf

    return write_view_netcdf(view, created_utc)


VIEW_EXPORTERS: dict[str, Exporter[PlanView]] = {
    "netcdf": Exporter("the same columns (CF-1.12)", "application/x-netcdf", ".nc", _write_netcdf),
}

__all__ = ["VIEW_EXPORTERS", "PlanView", "view_plan"]
