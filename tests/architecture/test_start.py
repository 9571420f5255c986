"""Modules that only work needs are loaded only when work is done."""

import json
import subprocess
import sys

# Each takes a part of the second in which the service is to listen.
LOADED_BY_WORK = {
    "alembic": "changes tables",
    "casadi": "solves slews",
    "numba": "runs kernels",
    "llvmlite": "compiles kernels",
    "scipy.optimize": "chooses, and searches for windows",
    "scipy.interpolate": "interpolates orbits",
    "scipy.io": "writes NetCDF",
    "scipy.ndimage": "reads telemetry",
    "scipy.signal": "reads telemetry",
    "scipy.linalg": "is what all of these begin with",
    "scipy.spatial": "turns",
    "scipy.special": "judges and searches",
    "matplotlib": "draws",
    "cv2": "reads and draws pictures",
    "planner.planning.sessions.pipeline": "plans",
    "planner.motion.baseline": "plans",
    "planner.motion.slew": "plans",
    "planner.verification.judge": "judges",
    "planner.planning.campaigns.campaign": "chooses",
    "planner.inflight.flights.runs": "flies",
    "planner.spacecraft.plan": "plans",
    "planner.inflight.telemetry.compare": "compares",
    "planner.output.view.view": "looks at plans",
    "estimator.pipeline": "measures",
    "app.work.preload": "is the children's",
    "stapi_pydantic": "answers where an operator has products",
}


def loaded_by(code: str) -> set[str]:
    told = subprocess.run(
        [sys.executable, "-c", f"{code}\nimport json, sys; print(json.dumps([*sys.modules]))"],
        check=True,
        capture_output=True,
        text=True,
    )
    return set(json.loads(told.stdout))


def test_nothing_is_loaded_that_only_work_needs() -> None:
    """By none of the doors: the library, the command, the service."""
    begun = "import slewtrack, app.cli, app.http.serving; app.http.serving.create_app()"
    assert not LOADED_BY_WORK.keys() & loaded_by(begun)


def test_all_that_work_needs_is_loaded_before_children_are_forked() -> None:
    # Pictures are drawn and filters made rarely: these wait until one is asked for.
    rare = {"alembic", "matplotlib", "scipy.signal", "stapi_pydantic"}
    assert LOADED_BY_WORK.keys() - rare <= loaded_by("import app.work.preload")
