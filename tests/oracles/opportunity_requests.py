"""Requests for opportunities that the tests share."""

import json
from datetime import UTC, datetime, timedelta
from pathlib import Path

from planner.planning.opportunities import OpportunityRequest, OpportunityTarget
from planner.world.orbits import TleOrbit
from planner.world.platforms import PLATFORMS
from planner.world.targets import GroundTarget

ROOT = Path(__file__).parents[2]
START = datetime(2015, 2, 27, 6, 0, 0, 250_000, tzinfo=UTC)
# ISS, of the day before; the same as in the README's example
ISS = TleOrbit(
    line1="1 25544U 98067A   15058.48161588  .00023857  00000-0  35618-3 0  9991",
    line2="2 25544  51.6478 271.9610 0008043  54.4849  18.6646 15.54887163930964",
)


def oco3_targets(every: int = 1) -> tuple[OpportunityTarget, ...]:
    """Real targets of OCO-3 on the ISS, each `every`th."""
    listed = json.loads((ROOT / "tests" / "data" / "oco3_targets.json").read_text())
    return tuple(
        OpportunityTarget(
            id=number, target=GroundTarget(latitude_deg=latitude, longitude_deg=longitude)
        )
        for number, _, latitude, longitude in listed["targets"][::every]
    )


def iss_request(days: float, **fields: object) -> OpportunityRequest:
    """From START, with the HRC's platform and LVLH attitude unless said otherwise."""
    return OpportunityRequest(
        **{
            "orbit": ISS,
            "platform": PLATFORMS["iss-hrc"],
            "start": START,
            "stop": START + timedelta(days=days),
            **fields,
        }
    )
