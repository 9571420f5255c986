"""The values that a place on the ground can take."""

from typing import Annotated

from planner.spec import Within

LatitudeDeg = Annotated[float, Within(-90.0, 90.0)]
LongitudeDeg = Annotated[float, Within(-180.0, 360.0)]
HeightM = Annotated[float, Within(-1000.0, 100e3)]
ElevationDeg = Annotated[float, Within(0.0, 90.0)]
GrazingAltitudeKm = Annotated[float, Within(0.0, 300.0)]
