"""The orbit and attitude messages of the example requests, all of the pass of `LAS_VEGAS`.

The OEM, OMM and OPM hold the orbit of its TLE: by SGP4, rotated to EME2000 and GCRF.  In the AEMs
the carrier swings about LVLH once an orbit, as the ISS does.
"""

from pathlib import Path

_DATA = Path(__file__).parent / "data"

OEM = (_DATA / "orbit.oem").read_text("utf-8")
OMM = (_DATA / "elements.json").read_text("utf-8")
OPM = (_DATA / "state.opm").read_text("utf-8")
ATTITUDE = (_DATA / "attitude.aem").read_text("utf-8")
ATTITUDE_HISTORY = (_DATA / "attitude_history.aem").read_text("utf-8")
