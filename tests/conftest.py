"""Fixtures and settings of all tests."""

import atexit
import os
import tempfile
import uuid

# As the service's children have it: on few cores BLAS's threads only wait for each other, which
# costs a fifth more of a processor, and nearly twice as much beside another test.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from databases import own_postgresql
from hypothesis import settings
from live_service import live_service

# The user's own data is no business of tests.
_data = tempfile.TemporaryDirectory(prefix="slewtrack-tests-")
atexit.register(_data.cleanup)
os.environ["SLEWTRACK_DATA_DIR"] = _data.name
# Every service under test, in this process or its own, then stores in PostgreSQL.
os.environ["SLEWTRACK_DATABASE_URL"] = own_postgresql(os.environ.get("PYTEST_XDIST_WORKER", "one"))
# Starlette's test client calls itself "testserver".
os.environ["SLEWTRACK_ALLOWED_HOSTS"] = "localhost,127.0.0.1,[::1],testserver"

# A loaded machine is slow; slowness is measured in bench/, not asserted here.
settings.register_profile("slewtrack", deadline=None)
settings.load_profile("slewtrack")


@pytest.fixture(scope="session")
def service(tmp_path_factory):
    """One that runs, with a store of its own, for all who only ask: to start one takes 7 s."""
    own = own_postgresql(uuid.uuid4().hex)
    with live_service(tmp_path_factory.mktemp("service"), SLEWTRACK_DATABASE_URL=own) as running:
        yield running


@pytest.fixture
def patient_store(monkeypatch):
    """On a loaded machine others write for longer than a service waits; to be asked for first."""
    monkeypatch.setattr("app.store.database.PATIENCE_S", 60.0)
