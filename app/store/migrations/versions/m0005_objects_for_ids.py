"""What campaigns chose as objects where ids were kept, and requests without a field now gone."""

import json
import zlib
from collections.abc import Callable
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    """Rewrite them, one at a time; `request_sha256` stays that of the bytes that were sent."""
    _rewrite("campaigns", "document", _name_targets)
    _rewrite("jobs", "request", _drop_lead)


def _name_targets(choice: dict[str, Any]) -> bool:
    """`unseen` and `left_out` were ids."""
    were_ids = False
    for name in ("unseen", "left_out"):
        were_ids |= any(isinstance(one, str) for one in choice[name])
        choice[name] = [{"target": one} if isinstance(one, str) else one for one in choice[name]]
    return were_ids


def _drop_lead(request: dict[str, Any]) -> bool:
    """The attitude law `harmonic` took `lead_s`; since, the plan says how far ahead it is."""
    attitude = request.get("attitude")
    return isinstance(attitude, dict) and attitude.pop("lead_s", None) is not None


def _rewrite(table: str, column: str, change: Callable[[dict[str, Any]], bool]) -> None:
    """Every JSON object of a column of packed ones that `change` changes."""
    rows = sa.table(table, sa.column("id"), sa.column(column, sa.LargeBinary()))
    connection = op.get_bind()
    for row_id in connection.scalars(sa.select(rows.c.id)).all():
        this = rows.c.id == row_id
        packed = connection.scalars(sa.select(rows.c[column]).where(this)).one()
        found = json.loads(zlib.decompress(packed))
        if change(found):
            changed = {column: zlib.compress(json.dumps(found).encode())}
            connection.execute(sa.update(rows).where(this).values(changed))
