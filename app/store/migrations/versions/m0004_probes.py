"""What readiness writes and removes."""

import sqlalchemy as sa
from alembic import op

from app.store.columns import UtcDateTime

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    """Make the table."""
    op.create_table(
        "probes",
        sa.Column("id", sa.String(36), nullable=False),
        sa.Column("at_utc", UtcDateTime(), nullable=False),
        sa.Column("content", sa.LargeBinary(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_probes"),
    )
