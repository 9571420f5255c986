"""The ranges of numbers in answers, for the schema: answers are made, not validated."""

from typing import Annotated

from pydantic import Field

Count = Annotated[int, Field(json_schema_extra={"minimum": 0})]
NotNegative = Annotated[float, Field(json_schema_extra={"minimum": 0.0})]
Share = Annotated[float, Field(json_schema_extra={"minimum": 0.0, "maximum": 1.0})]
DirectionPart = Annotated[float, Field(json_schema_extra={"minimum": -1.0, "maximum": 1.0})]
TurnDeg = Annotated[float, Field(json_schema_extra={"minimum": 0.0, "maximum": 360.0})]
HalfTurnDeg = Annotated[float, Field(json_schema_extra={"minimum": 0.0, "maximum": 180.0})]
ElevationDeg = Annotated[float, Field(json_schema_extra={"minimum": -90.0, "maximum": 90.0})]
ElevationOrLimbDeg = Annotated[float, Field(json_schema_extra={"minimum": -90.0, "maximum": 180.0})]
Signed = Annotated[float, Field(json_schema_extra={"x-range": "any, of either sign"})]
LatitudeDeg = ElevationDeg
LongitudeDeg = Annotated[float, Field(json_schema_extra={"minimum": -180.0, "maximum": 180.0})]
