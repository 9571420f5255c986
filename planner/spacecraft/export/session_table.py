"""The imaging session as every export format is given it."""

from dataclasses import dataclass

from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.table import AttitudeTable
from planner.spacecraft.vehicle.definition import AgileSpacecraft


@dataclass(frozen=True, kw_only=True)
class SessionTable:
    """What was asked, and the table that does it."""

    request: ImagingPlanRequest
    table: AttitudeTable

    @property
    def spacecraft(self) -> AgileSpacecraft:
        return self.request.definition()
