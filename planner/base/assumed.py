"""Assumptions: fields a request left out, and the value taken for each."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Assumed:
    """One thing that was looked up or filled in.

    field: of the request, dotted. E.g. `"sessions.0.target.name"`.
    detail: the value that was taken, in words. E.g. `"Ljubljana, SI (GeoNames 3196359)"`.
    members: members of a request that say the same in full. E.g. `{"latitude_deg": 46.05108,
    "longitude_deg": 14.50513, "height_m": 343.0}`.
    """

    field: str
    detail: str
    members: Mapping[str, Any]
