"""The command table as JSON."""

import json
from datetime import datetime

from planner.base.commands import COMMAND_STEP_S
from planner.base.header_text import one_line
from planner.output.export.description import TIME_SCALE
from planner.world.frames.time_scales import utc_text
from planner.world.plan import FlightPlan


def write_json(plan: FlightPlan, created_utc: datetime) -> bytes:
    """The answer's `table` with a `description` of frames, units, time scale and rotation."""
    table, platform, told = plan.table, plan.scenario.platform, plan.scenario.platform.described()
    document = {
        "name": plan.scenario.name,
        "epoch": utc_text(table.epoch_utc, 1),
        "step_s": COMMAND_STEP_S,
        "t_s": table.t_s.tolist(),
        **{one.name: value.tolist() for one, value in table.columns},
        "description": {
            "created": utc_text(created_utc),
            "platform": one_line(platform.name),
            "axes": list(table.dof_names),
            "time_scale": TIME_SCALE,
            "units": {"t_s": "s", **{one.name: one.unit for one in table.channels}},
            "rotation_order": told.rotation_order,
            "frames": f"{told.payload_axes}; {told.mount}",
            "interpolation": told.interpolation,
        },
    }
    return json.dumps(document, allow_nan=False, separators=(",", ":")).encode()
