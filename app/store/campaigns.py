"""What was chosen for each campaign, and how far it is planned."""

import json
import zlib
from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection, insert, select

from app.store.models import CampaignRow


def store(connection: Connection, job_id: str, document: bytes) -> None:
    """document: JSON, zlib."""
    connection.execute(insert(CampaignRow).values(id=job_id, document=document))


def choice_of(connection: Connection, job_id: str) -> Mapping[str, Any] | None:
    """The document; None before anything was chosen."""
    found = connection.scalar(select(CampaignRow.document).where(CampaignRow.id == job_id))
    if found is None:
        return None
    told: Mapping[str, Any] = json.loads(zlib.decompress(found))
    return told
