"""The schema of windows as GeoJSON (RFC 7946), one Feature each."""

from typing import Any

from pydantic import BaseModel, ConfigDict, Field


class FeatureCollection(BaseModel):
    """GeoJSON: a Feature a window, a point or the request's own geometry, null in space.

    features: `properties` hold `target`, `datetime` (rise and set with a slash between, as STAC
    and STAPI have it), rise, set, session, the view at the closest approach, azimuths, local solar
    time and the Sun.
    """

    model_config = ConfigDict(extra="allow")

    type: str = Field(json_schema_extra={"const": "FeatureCollection"})
    features: list[dict[str, Any]]
