"""The tables as the first release has them; `app.store.migrate` makes them."""

revision = "0004"
down_revision = None


def upgrade() -> None:
    """Nothing: a database that lacks tables gets them as the models say."""
