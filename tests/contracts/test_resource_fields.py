"""Resources that make no sense are refused by field; view and NetCDF have their levels."""

import io
import json
from datetime import UTC, datetime

import numpy as np
import pytest
from random_resources import PLATFORM, asked, plans
from scipy.io import netcdf_file

from app.requests.examples import LAS_VEGAS
from app.requests.plan import read_plan_request
from planner.base.errors import InvalidRequest
from planner.output.view import VIEW_EXPORTERS, view_plan

BATTERY = {"capacity_wh": 180.0, "start_wh": 160.0, "least_wh": 110.0, "idle_w": 38.0}
PANEL = {"normal_body": [0.0, 0.0, -1.0], "power_w": 150.0}
STATION = {"id": "matera", "latitude_deg": 40.65, "longitude_deg": 16.7}
WHEELS = {"capacity_n_m_s": [0.9, 0.9, 0.9]}
VARIABLES = (
    "battery_wh",
    "memory_gbit",
    "momentum_x_n_m_s",
    "momentum_y_n_m_s",
    "momentum_z_n_m_s",
)
MEMORY = {"capacity_gbit": 512.0, "imaging_gbit_s": 1.6, "stations": [STATION]}


@pytest.mark.parametrize(
    ("resources", "told"),
    [
        ({}, "battery, memory or momentum is required"),
        ({"battery": BATTERY | {"least_wh": 181.0}}, "least_wh: must be capacity_wh, 180, or less"),
        ({"battery": BATTERY | {"start_wh": 100.0}}, "start_wh: must lie between least_wh"),
        ({"battery": BATTERY | {"panels": [PANEL] * 17}}, "panels: must hold at most 16"),
        ({"battery": BATTERY | {"panels": [PANEL], "sunlight_w": 9.0}}, "sunlight_w: must be left"),
        ({"battery": BATTERY | {"panels": [PANEL | {"normal_body": [0, 0, 0]}]}}, "normal_body: "),
        ({"memory": MEMORY | {"start_gbit": 513.0}}, "start_gbit: must be capacity_gbit, 512"),
        ({"memory": MEMORY | {"stations": [STATION] * 2}}, "stations.1.id: must be a name"),
        ({"memory": MEMORY | {"stations": [STATION | {"id": ""}]}}, "stations.0.id: must be"),
        ({"momentum": WHEELS | {"start_n_m_s": [0, 1, 0]}}, "start_n_m_s.1: must lie within"),
        ({"momentum": WHEELS}, "resources.momentum: must be left out for iss-hrc: only a body"),
    ],
)  # fmt: skip
def test_what_makes_no_sense_is_refused_by_field(resources, told):
    with pytest.raises(InvalidRequest, match=told):
        read_plan_request(json.dumps(LAS_VEGAS | {"resources": resources}).encode())


@pytest.fixture(scope="module")
def of_body():
    """A request with wheels, and its plan."""
    ((request, plan),) = plans(seed=5, count=1, of="body")
    return request, plan


@pytest.mark.parametrize(
    ("platform", "told"),
    [("agile-cmg", "gyros turn it"), (PLATFORM | {"inertia_kg_m2": None}, "or its inertia_kg_m2")],
)
def test_wheels_are_refused_where_nothing_says_what_they_turn(of_body, platform, told):
    request, _ = of_body
    with pytest.raises(InvalidRequest, match="resources.momentum: must be left out .*" + told):
        asked(request | {"platform": platform})


def test_the_view_and_its_file_hold_all_levels(of_body):
    _, plan = of_body
    view = view_plan(plan, None, 0.678)
    written = VIEW_EXPORTERS["netcdf"].write(view, datetime(2026, 6, 1, tzinfo=UTC))
    with netcdf_file(io.BytesIO(written)) as file:
        for one, name in zip(view.resources, VARIABLES, strict=True):
            np.testing.assert_array_equal(file.variables[name][:], one.level)
            assert len(one.level) == len(view.t_s)
            margin = next(m for m in plan.verification.resources if m.name == one.name)
            assert margin.unit == one.unit
            away = np.abs(one.level - (one.limit if one.name == "battery" else 0.0))
            nearest = one.level[away.argmin() if one.name == "battery" else away.argmax()]
            # Rows of the view may pass by the nearest instant, by up to a row's worth.
            assert abs(nearest - margin.extreme) <= 0.02 * one.capacity
