"""What flights of plans found, and of which plan they are."""

import sqlalchemy as sa
from alembic import op

revision = "0007"
down_revision = "0006"


def upgrade() -> None:
    """Add the plan a job belongs to, which takes it with it, and make the table."""
    op.add_column("jobs", sa.Column("plan_id", sa.String(36)))
    op.create_index("ix_jobs_plan_id_id", "jobs", ["plan_id", "id"])
    op.create_table(
        "flights",
        sa.Column("id", sa.String(36), nullable=False),
        sa.Column("document", sa.LargeBinary(), nullable=False),
        sa.ForeignKeyConstraint(["id"], ["jobs.id"], name="fk_flights_id", ondelete="CASCADE"),
        sa.PrimaryKeyConstraint("id", name="pk_flights"),
    )
