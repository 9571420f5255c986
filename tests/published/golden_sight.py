"""Lines of sight by Orekit 13.1.9 and Skyfield 1.55, each checked against a third tool."""

import json
import math
from pathlib import Path

from planner.world.orbits import OemOrbit, TleOrbit

DATA = Path(__file__).parents[1] / "data"
GOLDEN = json.loads((DATA / "golden_los.json").read_text())  # conventions in the file
ARCSEC_RAD = math.pi / 648000.0


def orbit_of(source):
    if source["type"] == "TLE":
        return TleOrbit(line1=source["line1"], line2=source["line2"])
    name = source["file"].removeprefix("oem/ISS.OEM_J2K_EPH_").removesuffix(".xml.gz")
    return OemOrbit(content=(DATA / f"iss_oem_{name}_excerpt.xml").read_text())
