"""A client of a service in this process, for each file; a database for each test."""

import pytest
from databases import fresh_database, own_settings
from waiting import PatientClient

from app.http.app import create_app


@pytest.fixture(scope="module")
def client(tmp_path_factory):
    with PatientClient(create_app(own_settings(tmp_path_factory.mktemp("service")))) as client:
        yield client


@pytest.fixture
def database(tmp_path):
    with fresh_database(tmp_path) as database:
        yield database
