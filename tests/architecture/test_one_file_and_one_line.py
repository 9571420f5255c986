"""A new target mode, export format and orbit source are one file and one registration each.

A copy of the product gets one of each, and everything that knows modes, formats or sources must
have picked it up: plan, judge, budget, advice, opportunities, campaign, export, schema and pages.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
from numba.core.caching import _CacheLocator

from planner.base import compiled

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
    return "".join("\\t".join(map(repr, row)) + "\\n" for row in plan.table.position).encode()


TAB = Exporter(title="angles", media_type="text/tab-separated-values", suffix="tab", write=_write)
'''
ORBIT = '''
"""A circle through a position, with the velocity there."""

from dataclasses import dataclass
from datetime import datetime
from typing import ClassVar, Literal

import numpy as np

from planner.base.spec import spec
from planner.world.orbits.accuracy import OrbitSigma
from planner.world.orbits.ephemeris import CarrierName, Ephemeris, OrbitSource, OrbitStates


@spec
class CircleOrbit(OrbitSource):
    search_horizon_s: ClassVar[float] = 700.0
    source: Literal["circle"] = "circle"
    epoch: datetime
    r_eci_m: tuple[float, float, float]
    v_eci_m_s: tuple[float, float, float]

    @property
    def carrier_name(self):
        return CarrierName("ROUND\\n1")

    def ephemeris(self, start_utc, stop_utc):
        return CircleEphemeris(
            epoch_utc=self.epoch, start_utc=start_utc, stop_utc=stop_utc, warnings=(), orbit=self
        )


@dataclass(frozen=True, eq=False, kw_only=True)
class CircleEphemeris(Ephemeris):
    orbit: CircleOrbit

    def interpolate(self, instants):
        r_m, v_m_s = np.array(self.orbit.r_eci_m), np.array(self.orbit.v_eci_m_s)
        rate_rad_s = np.linalg.norm(v_m_s) / np.linalg.norm(r_m)
        phase_rad = rate_rad_s * instants.since_s(self.epoch_utc)[:, None]
        c, s = np.cos(phase_rad), np.sin(phase_rad)
        return OrbitStates(c * r_m + s * v_m_s / rate_rad_s, c * v_m_s - s * r_m * rate_rad_s)

    def sigma(self, instants):
        one = np.ones(len(instants))
        return OrbitSigma(
            radial_m=one, along_m=7.0 * one, cross_m=one, basis="assumed round", better="an ellipse"
        )
'''
REGISTRATIONS = (
    ("planner/world/targets/__init__.py", "    | BenchMotionTarget,\n",
     "    | BenchMotionTarget | ItrfTarget,\n",
     "from planner.world.targets.itrf import ItrfTarget\n"),
    ("planner/output/export/__init__.py", "] = {\n", '] = {\n    "tab": TAB,\n',
     "from planner.output.export.tab import TAB\n"),
    ("planner/world/orbits/__init__.py",
     "    TleOrbit | OmmOrbit | OemOrbit | OpmOrbit | StateVectorOrbit,\n",
     "    TleOrbit | OmmOrbit | OemOrbit | OpmOrbit | StateVectorOrbit | CircleOrbit,\n",
     "from planner.world.orbits.circle import CircleOrbit\n"),
)  # fmt: skip
USE = """
import json, sys, time
from pathlib import Path
from fastapi.testclient import TestClient
import slewtrack
from app.http.app import create_app
from app.requests.plan import read_plan_request
from planner.world.frames.geodesy import itrf_from_geodetic
from planner.world.frames.time_scales import Instants, utc_from_text
import math
import numpy as np

EXAMPLES = Path(sys.argv[1])
EPOCH = utc_from_text("2015-02-27T17:37:00Z")
x, y, z = itrf_from_geodetic(math.radians(36.1147), math.radians(-115.1728), 610.0).tolist()
target = {"mode": "itrf", "x_m": x, "y_m": y, "z_m": z}
request = json.loads((EXAMPLES / "las_vegas_2015.json").read_text())
at_ground = slewtrack.plan(request)
request["sessions"][0]["target"] = target
plan = slewtrack.plan(request)
assert plan.passed, plan["verification"]["findings"]
assert "target" in plan["verification"]["taken_as_given"]
for axis in ("alpha_deg", "beta_deg"):
    assert abs(plan.table[axis] - at_ground.table[axis]).max() < 3e-7  # 1 mas

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
    assert len(table.text.splitlines()) == len(plan.table.t_s)
    unknown = request["sessions"][0]["target"] | {"mode": "nowhere"}
    request["sessions"][0]["target"] = unknown
    assert "itrf" in client.post("/v1/plans", json=request).json()["detail"]

    request["sessions"][0]["target"] = target
    orbit = read_plan_request(json.dumps(request).encode()).orbit
    states = orbit.ephemeris(EPOCH, EPOCH).states(Instants(EPOCH, np.zeros(1)))
    request["orbit"] = {
        "source": "circle",
        "epoch": "2015-02-27T17:37:00Z",
        "r_eci_m": states.r_sat_eci_m[0].tolist(),
        "v_eci_m_s": states.v_sat_eci_m_s[0].tolist(),
    }
    answer = client.post("/v1/plans", json=request)
    assert answer.status_code == 201, answer.text
    assert answer.json()["verification"]["passed"]
    assert "assumed round" in answer.text and "an ellipse" in answer.text
    named = client.get(answer.headers["location"] + "/table", params={"format": "oem"}).text
    assert "OBJECT_NAME = ROUND 1\\n" in named
    # Far from any pass: another start is sought within the source's horizon, and no farther.
    request["sessions"][0] |= {"start": "2015-02-27T18:10:00Z", "stop": "2015-02-27T18:11:00Z"}
    refusal = client.post("/v1/plans", json=request).json()["detail"]
    assert "2015-02-27T18:21:40.0Z" in refusal, refusal  # 700 s later
"""


def take_kernels_along(tmp_path):
    """What is compiled already, for the same sources in their new place: 40 s of a processor.

    Nothing that is added is compiled in: else Python would look elsewhere, and compile.
    """
    kept = Path(numba.config.CACHE_DIR)  # as the planner sets it
    assert kept.parent == compiled._CACHE
    for folder in {path.parent for path in (ROOT / "planner").rglob("*.py")}:
        there, here = (
            root / _CacheLocator.get_suitable_cache_subpath(str(place / "any.py"))
            for root, place in (
                (kept, folder),
                (tmp_path / "kernels" / kept.name, tmp_path / folder.relative_to(ROOT)),
            )
        )
        if there.is_dir():
            in_the_making = shutil.ignore_patterns("*.tmp.*")  # by a test beside this one
            shutil.copytree(there, here, ignore=in_the_making)


def test_a_mode_a_format_and_an_orbit_source_get_everywhere(tmp_path):
    for package in ("slewtrack", "app", "planner", "estimator"):
        leave_out = shutil.ignore_patterns("__pycache__", "page")  # which may be built meanwhile
        shutil.copytree(ROOT / package, tmp_path / package, ignore=leave_out)
    take_kernels_along(tmp_path)
    (tmp_path / "planner/world/targets/itrf.py").write_text(MODE.lstrip())
    (tmp_path / "planner/output/export/tab.py").write_text(FORMAT.lstrip())
    (tmp_path / "planner/world/orbits/circle.py").write_text(ORBIT.lstrip())
    for path, before, after, import_line in REGISTRATIONS:
        text = (tmp_path / path).read_text()
        assert text.count(before) == 1
        first_import = text.index("from planner")
        text = text.replace(before, after)
        (tmp_path / path).write_text(text[:first_import] + import_line + text[first_import:])
    environment = os.environ | {
        "PYTHONPATH": str(tmp_path),
        "SLEWTRACK_DATA_DIR": str(tmp_path / "data"),
        "NUMBA_CACHE_DIR": str(tmp_path / "kernels"),
    }
    done = subprocess.run(
        [sys.executable, "-c", USE, str(ROOT / "examples")],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=1200,
    )
    assert done.returncode == 0, done.stderr
