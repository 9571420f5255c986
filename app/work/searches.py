"""The windows of a search as JSON, GeoJSON or CSV."""

import json
from collections.abc import Callable, Mapping, Sequence

from app.answers.opportunities_geojson import features_json
from app.answers.target_sky import pass_table_csv

GEOJSON, CSV = "application/geo+json", "text/csv"


def _csv(windows: Sequence[Mapping[str, object]], members: Mapping[str, object]) -> bytes:
    return pass_table_csv(windows)


def _geojson(windows: Sequence[Mapping[str, object]], members: Mapping[str, object]) -> bytes:
    return features_json(windows, **members)


# By media type: of windows and what else is told with them.
FORMS: dict[str, Callable[[Sequence[Mapping[str, object]], Mapping[str, object]], bytes]] = {
    GEOJSON: _geojson,
    CSV: _csv,
}


def windows_in_form(
    media_type: str, windows: Sequence[bytes], members: Mapping[str, object]
) -> bytes:
    """windows: as they are stored."""
    return FORMS[media_type]([json.loads(window) for window in windows], members)
