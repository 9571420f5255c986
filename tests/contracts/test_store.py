"""Stored values are kept to the bit, never changed, and handed to one worker at a time."""

import io
import shutil
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from child_work import made
from databases import empty_database
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from job_cases import KINDS as TRIED
from job_cases import new_job
from sqlalchemy import String, Text, select, text, update
from sqlalchemy.exc import DatabaseError

from app.ids import is_id, new_id
from app.jobs.job_completion import settle
from app.store import audit, events, jobs, migrate, models, plans, results
from app.store.database import open_database
from app.store.keys import KeyStore
from app.store.migrate import open_migrated, upgrade
from app.store.models import JobRow, PlainString, ResultRow
from app.store.packed import PackedColumns, pack, unpack
from app.store.unavailable import StoreDamaged, StoreUnavailable
from app.work.campaign import campaign_json
from planner.base.errors import InvalidInput

KINDS, NOTE = ("note",), TRIED["note"]


def accepted(database, tmp_path, lease_s=None, **members):
    new = new_job("note", tmp_path / "notes", **members)
    with database.writing() as connection:
        token = jobs.accept(connection, new, lease_s)
    return new.id, token


def test_migrations_lead_to_the_models(tmp_path):
    with empty_database(tmp_path) as database:
        upgrade(database)
        with database.reading() as connection:
            context = MigrationContext.configure(connection, opts={"compare_type": True})
            assert compare_metadata(context, models.Base.metadata) == []
            assert context.get_current_revision() == database.revision  # by its file's name


NEXT = """
import sqlalchemy as sa
from alembic import op

revision = "2"
down_revision = "1"


def upgrade():
    op.add_column("jobs", sa.Column("colour", sa.Text()))
    op.execute("UPDATE jobs SET colour = 'blue'")
"""


@pytest.fixture
def next_version(tmp_path, monkeypatch):
    """`upgrade` as the next version has it, whose migration is one more file in the folder."""
    folder = tmp_path / "migrations"
    shutil.copytree(migrate._FOLDER, folder)
    (folder / "versions" / "m0002_colours.py").write_text(NEXT)

    def upgrade_next(database):
        with monkeypatch.context() as patch:
            patch.setattr(migrate, "_FOLDER", folder)
            upgrade(database)

    return upgrade_next


def test_the_next_version_migrates_what_is_stored_once(database, tmp_path, next_version):
    job_id, _ = accepted(database, tmp_path)
    next_version(database)
    with database.writing() as connection:
        [row] = connection.execute(text("SELECT id, colour FROM jobs"))
        assert tuple(row) == (job_id, "blue")
        connection.execute(text("UPDATE jobs SET colour = 'red'"))
    next_version(database)
    with database.reading() as connection:
        assert connection.scalar(text("SELECT colour FROM jobs")) == "red"
    with pytest.raises(InvalidInput, match=r"revision '2'.* knows up to '1'"):
        upgrade(database)


def test_what_this_version_left_is_not_written_to_by_it(database, tmp_path, next_version):
    """It is told once it has read that, and reads on: somebody may still wait for its answers."""
    with second(database, tmp_path) as newer:
        told = []
        database.when_outdated = lambda: told.append("ended")
        accepted(database, tmp_path)
        assert told == []
        next_version(newer)
        with pytest.raises(StoreUnavailable, match="migrated by another version"):
            accepted(database, tmp_path)
        assert told == ["ended"]
        assert len(latest(database)) == len(latest(newer)) == 1
        accepted(newer, tmp_path)
        assert len(latest(database)) == 2


def test_nobody_migrates_under_who_writes(database, tmp_path, next_version):
    """What it writes is among what is migrated, or refused."""
    with second(database, tmp_path) as newer, ThreadPoolExecutor(1) as threads:
        with database.writing() as connection:
            migrated = threads.submit(next_version, newer)
            with pytest.raises(TimeoutError):
                migrated.result(timeout=0.5)
            jobs.accept(connection, new_job("note", tmp_path / "notes"))
        migrated.result()
        with newer.reading() as connection:
            assert connection.scalar(text("SELECT colour FROM jobs")) == "blue"


def finish(database, token):
    """As work ends that made a plan."""
    done = Future()
    done.set_result(made())
    with database.writing() as connection:
        settle(connection, jobs.job_of_lease(connection, token), NOTE, done, 3)


@contextmanager
def second(database, tmp_path):
    """Another service's way to it."""
    url = database.url.render_as_string(hide_password=False)
    other = open_database(url, tmp_path)
    yield other
    other.close()


def latest(database):
    with database.reading() as connection:
        return jobs.latest(connection, "note", 9)


@pytest.mark.usefixtures("patient_store")
def test_services_that_start_together_migrate_once(tmp_path):
    with empty_database(tmp_path) as database:
        with ThreadPoolExecutor(4) as threads:
            list(threads.map(upgrade, [database] * 4))
        accepted(database, tmp_path)


@pytest.mark.parametrize("revision", ["9999", "0007"])
def test_a_database_of_another_version_is_left_alone(database, revision):
    """Of a later one, or of one from before the first release, whose numbers had four digits."""
    with database.writing() as connection:
        connection.execute(text(f"UPDATE alembic_version SET version_num = '{revision}'"))
    with pytest.raises(InvalidInput, match=f"{revision}.* later version .* before the first"):
        upgrade(database)


def test_a_database_that_doesnt_answer_is_named(tmp_path):
    nobody = open_database("postgresql+psycopg://nobody@127.0.0.1:1/none", tmp_path)
    with pytest.raises(InvalidInput, match="can't be used"):
        upgrade(nobody)


def test_ids_sort_by_time():
    ids = [new_id() for _ in range(3)]
    assert all(is_id(one) for one in ids)
    assert [one[14] for one in ids] == ["7"] * 3  # the version, RFC 9562
    assert not is_id("../etc/passwd")
    assert not is_id(ids[0].upper())


SHAPES = st.tuples(st.integers(0, 30), st.integers(1, 4))
ANY_DOUBLE = st.floats(allow_nan=True, allow_infinity=True, allow_subnormal=True)


@given(hnp.arrays(np.float64, SHAPES, elements=ANY_DOUBLE))
def test_tables_come_back_to_the_bit(values):
    facts = {"epoch": "2015-02-27T17:34:00Z"}
    back = unpack(pack(PackedColumns(columns={"a": values, "b": values[:, 0]}, facts=facts)))
    assert back.facts == facts
    for name, given_values in (("a", values), ("b", values[:, 0])):
        assert back.columns[name].shape == given_values.shape
        assert back.columns[name].tobytes() == np.ascontiguousarray(given_values).tobytes()


CUT_OFF = pack(PackedColumns(columns={}, facts={}))[:-9]


@pytest.mark.parametrize("kept", [b"", b"\xa5" * 99, CUT_OFF], ids=["none", "other", "cut off"])
def test_what_can_no_longer_be_unpacked_is_damaged(database, tmp_path, kept):
    """SQLite doesn't look into what it keeps."""
    with pytest.raises(StoreDamaged):
        unpack(kept)
    job_id, _ = accepted(database, tmp_path, lease_s=60.0)
    with database.writing() as connection:
        results.store(connection, job_id, [kept])
        connection.execute(update(JobRow).values(request=kept))
        with pytest.raises(StoreDamaged):
            jobs.request_of(connection, job_id)
        job = jobs.get(connection, job_id)
        with pytest.raises(StoreDamaged):
            campaign_json(job, results.document(connection, job_id), [])


def test_a_smooth_table_takes_less_than_half_of_npz():
    t_s = np.arange(1151) / 5.0
    columns = {"angle_rad": np.sin(t_s[:, None] / [40.0, 55.0]), "rate_rad_s": np.zeros((1151, 2))}
    npz = io.BytesIO()
    np.savez_compressed(npz, **columns)
    assert len(pack(PackedColumns(columns=columns, facts={}))) < len(npz.getvalue()) / 2


def test_only_what_can_be_made_again_does_not_wait_for_the_disk(tmp_path):
    """SQLite's own words: 2 waits at each commit, 1 does not; whatever was written before."""
    with open_migrated("", tmp_path) as database:
        found = []
        for lasting in (True, False, True):
            with database.writing(lasting=lasting) as connection:
                found.append(connection.exec_driver_sql("PRAGMA synchronous").scalar())
        assert found == [2, 1, 2]


def test_the_database_refuses_to_change_a_result(database, tmp_path):
    """Of any kind of work, and all that belongs to it."""
    job_id, _ = accepted(database, tmp_path, lease_s=60.0)
    with database.writing() as connection:
        results.store(connection, job_id, [b"document", b"table", b"more"])
    for part in range(3):
        changed = update(ResultRow).where(ResultRow.part == part).values(content=b"other")
        with pytest.raises(DatabaseError, match="immutable"), database.writing() as connection:
            connection.execute(changed)
    with database.reading() as connection:
        assert results.get(connection, job_id) == [b"document", b"table", b"more"]
        assert results.document(connection, job_id) == b"document"


@pytest.mark.usefixtures("patient_store")
def test_each_job_is_claimed_once(database, tmp_path):
    ids = {accepted(database, tmp_path)[0] for _ in range(30)}

    def claim_all(_):
        found = []
        while True:
            with database.writing() as connection:
                claimed = jobs.claim(connection, KINDS, 60.0)
            if claimed is None:
                return found
            found.append(claimed.job.id)

    with ThreadPoolExecutor(4) as threads:
        claimed = [one for found in threads.map(claim_all, range(4)) for one in found]
    assert len(claimed) == 30
    assert set(claimed) == ids


def test_the_first_in_rank_goes_first_then_the_oldest(database, tmp_path):
    later = [accepted(database, tmp_path, rank=5)[0] for _ in range(2)]
    first = accepted(database, tmp_path, rank=0)[0]
    with database.writing() as connection:
        order = [jobs.claim(connection, KINDS, 60.0).job.id for _ in range(3)]
    assert order[0] == first
    assert set(order[1:]) == set(later)


def test_kinds_nobody_here_knows_are_left_to_others(database, tmp_path):
    accepted(database, tmp_path)
    with database.writing() as connection:
        assert jobs.claim(connection, ("plan",), 60.0) is None
        assert not jobs.is_work_waiting(connection, ("plan",))


def test_a_lease_that_ran_out_is_lost(database, tmp_path):
    job_id, token = accepted(database, tmp_path, lease_s=-1.0)
    with database.writing() as connection:
        claimed = jobs.claim(connection, KINDS, 60.0)
    assert (claimed.job.id, claimed.job.attempts) == (job_id, 1)
    assert claimed.request.decode() == str(tmp_path / "notes")
    with database.writing() as connection:
        assert jobs.job_of_lease(connection, token) is None
        assert jobs.job_of_lease(connection, claimed.token).attempts == 2
        assert jobs.extend(connection, (token, claimed.token), 60.0) == {token}
        assert jobs.claim(connection, KINDS, 60.0) is None


def test_a_cancelled_lease_is_unwanted(database, tmp_path):
    job_id, token = accepted(database, tmp_path, lease_s=60.0)
    with database.writing() as connection:
        assert jobs.leases_to_end(connection, (token,)) == frozenset()
        assert jobs.cancel(connection, job_id).state == "running"
        assert jobs.leases_to_end(connection, (token,)) == {token}


@pytest.mark.usefixtures("patient_store")
def test_revisions_count_up_however_many_come_at_once(database, tmp_path):
    first, token = accepted(database, tmp_path, lease_s=60.0)
    finish(database, token)
    new = [accepted(database, tmp_path, lease_s=60.0, revises=first) for _ in range(6)]
    with ThreadPoolExecutor(3) as threads:
        list(threads.map(lambda one: finish(database, one[1]), new))
    with database.reading() as connection:
        found = [jobs.get(connection, job_id) for job_id, _ in new]
    assert sorted(one.revision for one in found) == [2, 3, 4, 5, 6, 7]
    assert {(one.series, one.revises) for one in found} == {(first, first)}


def test_what_is_old_and_finished_goes_with_all_it_made(database, tmp_path):
    begun = [accepted(database, tmp_path, lease_s=60.0) for _ in range(2)]
    waiting, _ = accepted(database, tmp_path)
    for _, token in begun:
        finish(database, token)
    (old, _), (young, _) = begun
    with database.writing() as connection:
        long_ago = datetime.now(UTC) - timedelta(days=9)
        connection.execute(update(JobRow).where(JobRow.id == old).values(finished_utc=long_ago))
        before = datetime.now(UTC) - timedelta(days=8)
        assert jobs.remove_finished(connection, before, 100) == [old]
        assert results.get(connection, old) == []
        assert events.after(connection, old, 0) == []
        assert plans.get(connection, jobs.get(connection, young)).document == b"{}"
        assert not jobs.remove(connection, waiting)


def test_a_transaction_that_fails_leaves_nothing(database, tmp_path):
    new = new_job("note", tmp_path / "notes")

    def accept_and_fail():
        with database.writing() as connection:
            jobs.accept(connection, new)
            audit.record(connection, key_id=None, action="x", subject=new.id)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        accept_and_fail()
    with database.reading() as connection:
        assert jobs.get(connection, new.id) is None
        assert audit.entries(connection, limit=1, before=10**9) == []


@pytest.mark.parametrize("name", ["a\0b", "\0", "\ud800", "a\u202eb"])
def test_any_text_can_be_stored_and_looked_for(database, tmp_path, name):
    """PostgreSQL has no U+0000, and UTF-8 no lone surrogate."""
    job_id, _ = accepted(database, tmp_path, name=name)
    with database.writing() as connection:
        audit.record(connection, key_id=None, action="x", subject=job_id, detail=name)
        for filters in ({"name": name}, {"text": name}):
            assert [job.id for job in jobs.latest(connection, "note", 9, filters=filters)] == [
                job_id
            ]
    KeyStore(database).create(name, ["read"])


@pytest.mark.parametrize("strange", ["a\0b", "\ud800", "x" * 10_000])
def test_every_column_of_text_can_be_asked_for_any_text(database, strange):
    texts = [
        column
        for table in models.Base.metadata.tables.values()
        for column in table.columns
        if isinstance(column.type, String | Text | PlainString)
    ]
    with database.reading() as connection:
        for column in texts:
            assert connection.execute(select(column).where(column == strange)).all() == []
        assert connection.execute(select(JobRow.id).where(JobRow.id.in_([strange]))).all() == []


@pytest.mark.parametrize("strange", ["a\0b", "\ud800"])
def test_any_text_can_be_stored_beside_a_job(database, tmp_path, strange):
    job_id, _ = accepted(database, tmp_path, options={strange: strange})
    with database.writing() as connection:
        audit.record(connection, key_id=strange, action=strange, subject=strange)
        events.record(connection, job_id, "progress", {strange: strange})
        assert jobs.get(connection, job_id).options == {strange: strange}
