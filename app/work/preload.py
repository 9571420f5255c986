"""The modules and solvers that children find ready, loaded once by the server that forks them.

Importing it loads what work loads when it is done, and plans the worked example: solvers are
built, ephemerides read and tables of Earth orientation interpolated before the first fork, so that
no child does it again.
"""

import gc
import json
import os
from importlib import import_module

from app.requests.examples import LAS_VEGAS
from app.work.plan import plan_and_pack
from planner.motion.slew.ocp import make_solvers
from planner.motion.slew.smoothest import SIZES

# Beyond what a plan needs.
_LOADED = (
    "scipy.interpolate",
    "scipy.io",
    "scipy.ndimage",
    "scipy.optimize",
    "app.work.campaign",
    "app.work.flights",
    "app.work.horizon",
    "app.work.searches",
    "app.work.spacecraft",
    "app.work.telemetry",
    "app.work.view",
    "estimator.overlay",
    "estimator.pipeline",
    "estimator.prediction",
    "estimator.rendering.scene",
    "estimator.series",
    "planner.planning.campaigns.campaign",
    "planner.inflight.flights.nominal",
    "planner.inflight.flights.runs",
    "planner.planning.opportunities.search",
    "planner.spacecraft.plan",
    "planner.inflight.telemetry.compare",
    "planner.output.view.netcdf",
    "planner.output.view.view",
)
SERVER_PID = os.getpid()
_REQUEST = json.dumps(LAS_VEGAS).encode()


def preload() -> None:
    """Plan the worked example, and make the solvers that nine slews in ten ask for."""
    make_solvers(SIZES[:5])
    plan_and_pack(_REQUEST)


gc.disable()  # nothing that is loaded is garbage
for name in _LOADED:
    import_module(name)
preload()
gc.enable()
gc.collect()
gc.freeze()  # no collection touches, and so copies, the pages children share
