"""Skyfield's sky and a judged table, made once for all files here that ask for them."""

from importlib.resources import files

import pytest
from judged_tables import scenario_of, table_of
from opportunity_requests import ISS
from skyfield.api import EarthSatellite, Loader
from skyfield.data import iers

LOAD = Loader(str(files("skyfield_data") / "data"))


@pytest.fixture(scope="session")
def timescale():
    """With the Earth's orientation of IERS."""
    timescale = LOAD.timescale(builtin=False)
    with LOAD.open("finals2000A.all") as lines:
        iers.install_polar_motion_table(timescale, iers.parse_x_y_dut1_from_finals_all(lines))
    return timescale


@pytest.fixture(scope="session")
def skyfield(timescale):
    """Time scale, DE421, and the ISS."""
    return timescale, LOAD("de421.bsp"), EarthSatellite(ISS.line1, ISS.line2, ts=timescale)


@pytest.fixture(scope="session")
def scenario():
    return scenario_of()


@pytest.fixture(scope="session")
def table(scenario):
    return table_of(scenario)
