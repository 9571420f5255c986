"""A client of a service in this process, with its defaults, for each file that asks for one."""

import pytest
from waiting import PatientClient

from app.http.app import create_app


@pytest.fixture(scope="module")
def client():
    with PatientClient(create_app()) as client:
        yield client
