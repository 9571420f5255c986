"""Which program, from which request, made an answer."""

from dataclasses import dataclass
from datetime import datetime

from app.versions import versions
from planner.frames.time_scales import utc_text


@dataclass(frozen=True, kw_only=True)
class ProvenanceOut:
    """SHA-256 of the request's bytes, when it was worked on, versions at work."""

    input_sha256: str
    planned_at: str
    versions: dict[str, str]


def provenance(input_sha256: str, planned_at_utc: datetime) -> ProvenanceOut:
    """Of an answer to the request with this digest."""
    return ProvenanceOut(
        input_sha256=input_sha256, planned_at=utc_text(planned_at_utc), versions=versions()
    )
