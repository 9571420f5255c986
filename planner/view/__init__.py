"""What there is to see of a plan, and the formats that hold all of it."""

from datetime import datetime
from typing import TYPE_CHECKING

from planner.export import Exporter
from planner.on_first_use import on_first_use

if TYPE_CHECKING:
    from planner.view.view import PlanView, view_plan
else:
    __getattr__ = on_first_use(PlanView="planner.view.view", view_plan="planner.view.view")


def _write_netcdf(view: "PlanView", created_utc: datetime) -> bytes:
    from planner.view.netcdf import write_view_netcdf

    return write_view_netcdf(view, created_utc)


VIEW_EXPORTERS: dict[str, "Exporter[PlanView]"] = {
    "netcdf": Exporter("the same columns (CF-1.12)", "application/x-netcdf", ".nc", _write_netcdf),
}

__all__ = ["VIEW_EXPORTERS", "PlanView", "view_plan"]
