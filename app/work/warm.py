"""What children find ready: imported once, by the server they are forked from.

Importing it plans the worked example: solvers are built, ephemerides read and tables of Earth
orientation interpolated before the first fork, so that no child does it again.
"""

import gc
import json
import os

import app.work.campaign
import app.work.horizon
import app.work.spacecraft
import app.work.telemetry
import app.work.view  # noqa: F401 (for the children to find)
from app.requests.examples.plan import LAS_VEGAS
from app.work.plan import plan_and_pack
from planner.slew.ocp import make_solvers
from planner.slew.smoothest import SIZES

SERVER_PID = os.getpid()
_REQUEST = json.dumps(LAS_VEGAS).encode()


def warm_up() -> None:
    """Plan the worked example, and make the solvers that nine slews in ten ask for."""
    make_solvers(SIZES[:5])
    plan_and_pack(_REQUEST)


warm_up()
gc.collect()
gc.freeze()  # no collection touches, and so copies, the pages children share
