"""The tables of the first release, and what the database itself refuses to change in them.

Constraints are named by the convention of `app.store.models.Base`.
"""

import sqlalchemy as sa
from alembic import op

revision = "1"
down_revision = None

_UTC = sa.DateTime(timezone=True)
_ID = sa.String(36)


def upgrade() -> None:
    _jobs()
    _keys_and_audit()
    op.create_table(
        "probes",
        sa.Column("id", _ID, primary_key=True),
        sa.Column("at_utc", _UTC, nullable=False),
        sa.Column("content", sa.LargeBinary(), nullable=False),
    )
    _refuse("UPDATE", "results", "results are immutable")
    _refuse("UPDATE", "audit", "the audit log is only added to")
    _refuse("DELETE", "audit", "the audit log is only added to")


def _of_job() -> sa.ForeignKey:
    return sa.ForeignKey("jobs.id", ondelete="CASCADE")


def _jobs() -> None:
    op.create_table(
        "jobs",
        sa.Column("id", _ID, primary_key=True),
        sa.Column("kind", sa.String(32), nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("name", sa.Text(), nullable=False),
        sa.Column("request", sa.LargeBinary(), nullable=False),
        sa.Column("request_sha256", sa.String(64), nullable=False),
        sa.Column("options", sa.JSON(), nullable=False),
        sa.Column("key_id", sa.String(64), nullable=True),
        sa.Column("idempotency", sa.String(64), unique=True, nullable=True),
        sa.Column("parent_id", _ID, _of_job(), nullable=True),
        sa.Column("plan_id", _ID, nullable=True),
        sa.Column("revises", _ID, nullable=True),
        sa.Column("series", _ID, nullable=True),
        sa.Column("revision", sa.Integer(), nullable=True),
        sa.Column("rank", sa.Integer(), nullable=False),
        sa.Column("attempts", sa.Integer(), nullable=False),
        sa.Column("lease_token", sa.String(32), nullable=True),
        sa.Column("lease_until_s", sa.Double(), nullable=True),
        sa.Column("deadline_s", sa.Double(), nullable=False),
        sa.Column("created_utc", _UTC, nullable=False),
        sa.Column("started_utc", _UTC, nullable=True),
        sa.Column("finished_utc", _UTC, nullable=True),
        sa.Column("cancel_requested", sa.Boolean(), nullable=False),
        sa.Column("problem", sa.JSON(), nullable=True),
        sa.Column("platform", sa.Text(), nullable=True),
        sa.Column("start_utc", _UTC, nullable=True),
        sa.Column("stop_utc", _UTC, nullable=True),
        sa.Column("targets", sa.JSON(), nullable=True),
        sa.Column("target_count", sa.Integer(), nullable=True),
        sa.Column("probability_in_frame", sa.Double(), nullable=True),
        sa.Column("words", sa.Text(), nullable=True),
        sa.Column("target_words", sa.Text(), nullable=True),
        sa.CheckConstraint(
            "state IN ('queued', 'running', 'done', 'refused', 'failed', 'cancelled')",
            name="state",
        ),
        sa.UniqueConstraint("series", "revision"),
    )
    for columns in (
        ["state", "rank", "id"],
        ["kind", "id"],
        ["parent_id", "state"],
        ["plan_id", "id"],
        ["lease_token"],
        ["finished_utc"],
    ):
        op.create_index(f"ix_jobs_{'_'.join(columns)}", "jobs", columns)
    op.create_table(
        "events",
        sa.Column("job_id", _ID, _of_job(), primary_key=True),
        sa.Column("seq", sa.Integer(), autoincrement=False, primary_key=True),
        sa.Column("at_utc", _UTC, nullable=False),
        sa.Column("kind", sa.String(32), nullable=False),
        sa.Column("data", sa.JSON(), nullable=False),
    )
    op.create_table(
        "results",
        sa.Column("job_id", _ID, _of_job(), primary_key=True),
        sa.Column("part", sa.Integer(), autoincrement=False, primary_key=True),
        sa.Column("content", sa.LargeBinary(), nullable=False),
    )


def _keys_and_audit() -> None:
    op.create_table(
        "keys",
        sa.Column("id", sa.String(64), primary_key=True),
        sa.Column("name", sa.Text(), nullable=False),
        sa.Column("secret_sha256", sa.String(64), nullable=False),
        sa.Column("scopes", sa.JSON(), nullable=False),
        sa.Column("created_utc", _UTC, nullable=False),
        sa.Column("revoked_utc", _UTC, nullable=True),
        sa.Column("rate_per_minute", sa.Integer(), nullable=True),
        sa.Column("concurrency", sa.Integer(), nullable=True),
    )
    op.create_table(
        "audit",
        sa.Column("id", sa.Integer(), autoincrement=True, primary_key=True),
        sa.Column("at_utc", _UTC, nullable=False),
        sa.Column("key_id", sa.String(64), nullable=True),
        sa.Column("action", sa.String(32), nullable=False),
        sa.Column("subject", sa.String(64), nullable=False),
        sa.Column("detail", sa.Text(), nullable=False),
    )
    op.create_index("ix_audit_subject", "audit", ["subject"])


def _refuse(deed: str, table: str, why: str) -> None:
    name = f"{table}_refuses_{deed.lower()}"
    if op.get_bind().dialect.name == "sqlite":
        op.execute(
            f"CREATE TRIGGER {name} BEFORE {deed} ON {table} "
            f"BEGIN SELECT RAISE(ABORT, '{why}'); END"
        )
        return
    op.execute(
        f"CREATE FUNCTION {name}() RETURNS trigger LANGUAGE plpgsql AS "
        f"$$ BEGIN RAISE EXCEPTION '{why}'; END $$"
    )
    op.execute(
        f"CREATE TRIGGER {name} BEFORE {deed} ON {table} FOR EACH ROW EXECUTE FUNCTION {name}()"
    )
