"""A new target mode and a new export format are one file and one registration each.

A copy of the product gets one of each, and everything that knows modes or formats must have
picked it up: plan, judge, opportunities, campaign, export, schema and pages.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]

MODE = '''
"""A place given in ITRF."""

from typing import ClassVar, Literal

import numpy as np

from planner.base.spec import spec
from planner.world.targets.earth_fixed import EarthFixedTarget, ElevationDeg
from planner.world.targets.refraction import Refraction


@spec
class ItrfTarget(EarthFixedTarget):
    rests_on_earth: ClassVar[bool] = True
    mode: Literal["itrf"] = "itrf"
    x_m: float
    y_m: float
    z_m: float
    min_elevation_deg: ElevationDeg = 0.0
    refraction: Refraction = "none"

    def r_target_itrf_m(self, instants):
        return np.broadcast_to([self.x_m, self.y_m, self.z_m], (len(instants.t_s), 3))
'''
FORMAT = '''
"""Tab-separated angles."""

from planner.output.export.exporter import Exporter


def _write(plan, created_utc):
    return "".join("\\t".join(map(repr, row)) + "\\n" for row in plan.table.angle_rad).encode()


TAB = Exporter(title="angles", media_type="text/tab-separated-values", suffix="tab", write=_write)
'''
REGISTRATIONS = (
    (
        "planner/world/targets/__init__.py",
        "    | BenchMotionTarget,\n",
        "    | BenchMotionTarget | ItrfTarget,\n",
        "from planner.world.targets.itrf import ItrfTarget\n",
    ),
    (
        "planner/output/export/__init__.py",
        "] = {\n",
        '] = {\n    "tab": TAB,\n',
        "from planner.output.export.tab import TAB\n",
    ),
)
USE = """
import json, sys, time
from pathlib import Path
from fastapi.testclient import TestClient
import slewtrack
from app.http.app import create_app
from planner.world.frames.geodesy import itrf_from_geodetic
import math

EXAMPLES = Path(sys.argv[1])
x, y, z = itrf_from_geodetic(math.radians(36.1147), math.radians(-115.1728), 610.0).tolist()
target = {"mode": "itrf", "x_m": x, "y_m": y, "z_m": z}
request = json.loads((EXAMPLES / "las_vegas_2015.json").read_text())
at_ground = slewtrack.plan(request)
request["sessions"][0]["target"] = target
plan = slewtrack.plan(request)
assert plan.verification.passed, plan.verification.findings
assert "target" in plan.verification.taken_as_given
assert abs(plan.table.angle_rad - at_ground.table.angle_rad).max() < 5e-9  # 1 mas

campaign = json.loads((EXAMPLES / "campaign_cities.json").read_text())
campaign["targets"] = [campaign["targets"][0] | {"target": target}]
shared = ("orbit", "attitude", "platform", "start", "stop")
asked = {name: campaign[name] for name in shared if name in campaign}
windows = slewtrack.opportunities(asked | {"targets": [{"id": "there", "target": target}]}).windows
assert windows
assert slewtrack.campaign(campaign).passes

with TestClient(create_app()) as client:
    schema = client.get("/openapi.json").text
    assert schema.count("ItrfTarget") >= 3
    assert "text/tab-separated-values" in schema
    assert client.get("/docs").status_code == 200
    answer = client.post("/v1/plans", json=request)
    assert answer.status_code == 201, answer.text
    table = client.get(answer.headers["location"] + "/table", params={"format": "tab"})
    assert len(table.text.splitlines()) == len(plan.table.angle_rad)
    unknown = request["sessions"][0]["target"] | {"mode": "nowhere"}
    request["sessions"][0]["target"] = unknown
    assert "itrf" in client.post("/v1/plans", json=request).json()["detail"]
"""


def test_a_mode_and_a_format_get_everywhere(tmp_path):
    for package in ("slewtrack", "app", "planner", "estimator"):
        leave_out = shutil.ignore_patterns("__pycache__", "page")  # which may be built meanwhile
        shutil.copytree(ROOT / package, tmp_path / package, ignore=leave_out)
    (tmp_path / "planner/world/targets/itrf.py").write_text(MODE.lstrip())
    (tmp_path / "planner/output/export/tab.py").write_text(FORMAT.lstrip())
    for path, before, after, import_line in REGISTRATIONS:
        text = (tmp_path / path).read_text()
        assert text.count(before) == 1
        first_import = text.index("from planner")
        text = text.replace(before, after)
        (tmp_path / path).write_text(text[:first_import] + import_line + text[first_import:])
    environment = os.environ | {
        "PYTHONPATH": str(tmp_path),
        "SLEWTRACK_DATA_DIR": str(tmp_path / "data"),
    }
    done = subprocess.run(
        [sys.executable, "-c", USE, str(ROOT / "examples")],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
