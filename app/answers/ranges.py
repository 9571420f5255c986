"""The ranges of numbers in answers, for the schema: answers are made, not validated."""

from typing import Annotated

from pydantic import Field

Count = Annotated[int, Field(ge=0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Share = Annotated[float, Field(ge=0.0, le=1.0)]
DirectionPart = Annotated[float, Field(ge=-1.0, le=1.0)]
TurnDeg = Annotated[float, Field(ge=0.0, le=360.0)]
HalfTurnDeg = Annotated[float, Field(ge=0.0, le=180.0)]
ElevationDeg = Annotated[float, Field(ge=-90.0, le=90.0)]
ElevationOrLimbDeg = Annotated[float, Field(ge=-90.0, le=180.0)]
Signed = Annotated[float, Field(json_schema_extra={"x-range": "any, of either sign"})]
