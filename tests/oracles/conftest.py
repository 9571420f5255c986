"""Skyfield's sky and a judged table, made once for all files here that ask for them."""

from importlib.resources import files

import pytest
from judged_tables import scenario_of, table_of
from opportunity_requests import ISS
from skyfield.api import EarthSatellite, Loader
from skyfield.data import iers


@pytest.fixture(scope="session")
def skyfield():
    """Time scale with the Earth's orientation of IERS, DE421, and the ISS."""
    load = Loader(str(files("skyfield_data") / "data"))
    timescale = load.timescale(builtin=False)
    with load.open("finals2000A.all") as lines:
        iers.install_polar_motion_table(timescale, iers.parse_x_y_dut1_from_finals_all(lines))
    return timescale, load("de421.bsp"), EarthSatellite(ISS.line1, ISS.line2, ts=timescale)


@pytest.fixture(scope="session")
def scenario():
    return scenario_of()


@pytest.fixture(scope="session")
def table(scenario):
    return table_of(scenario)
