"""placeholder"""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, kw_only=True)
class SlewComparisonOut:
    session: int


def comparison_out(session: int, comparison: Any) -> SlewComparisonOut:
    return SlewComparisonOut(session=session)
