"""Orekit's reading of our AEM and OEM; run by `make oracles`, needs Java.

Writes tests/data/exports_by_orekit.json, which test_export_readers.py compares with the plan.
"""

import json
import tempfile
from importlib.metadata import version
from pathlib import Path

import erfa
import numpy as np
import orekit_jpype
from export_cases import CREATED_UTC, case
from jpype import JProxy

from planner.output.export import EXPORTERS

GOLDEN = Path(__file__).parents[1] / "data" / "exports_by_orekit.json"
SAMPLES_S = [0.0, 0.1, 7.3, 20.0, 33.34, 47.9, 59.9, 60.0]  # on rows and between them
MONTHS = ["JAN", "FEB", "MAR", "APR", "MAY", "JUN", "JUL", "AUG", "SEP", "OCT", "NOV", "DEC"]

orekit_jpype.initVM()

from java.io import File  # noqa: E402  (Java packages exist once its machine runs)
from org.hipparchus.geometry.euclidean.threed import Vector3D  # noqa: E402
from org.orekit.bodies import CelestialBodyFactory  # noqa: E402
from org.orekit.data import DataContext, DataSource, DirectoryCrawler  # noqa: E402
from org.orekit.files.ccsds.ndm import ParserBuilder  # noqa: E402
from org.orekit.frames import FramesFactory  # noqa: E402


def give_leap_seconds(folder):
    """ERFA's leap seconds in the layout of USNO's tai-utc.dat."""
    with (Path(folder) / "tai-utc.dat").open("w") as file:
        for year, month, tai_utc_s in erfa.leap_seconds.get():
            if year >= 1972:
                jd = sum(erfa.cal2jd(int(year), int(month), 1))
                file.write(
                    f" {year} {MONTHS[month - 1]}  1 =JD {jd:.1f}  TAI-UTC= {tai_utc_s:10.7f} S "
                    "+ (MJD - 41317.) X 0.0      S\n"
                )
    DataContext.getDefault().getDataProvidersManager().addProvider(DirectoryCrawler(File(folder)))


def give_earth():
    """CENTER_NAME = EARTH makes Orekit ask for a planetary ephemeris; a named body is enough."""
    earth = JProxy(
        "org.orekit.bodies.CelestialBody",
        dict={
            "getName": lambda: "Earth",
            "getGM": lambda: 3.986004418e14,
            "getInertiallyOrientedFrame": FramesFactory.getGCRF,
        },
    )
    loader = JProxy(
        "org.orekit.bodies.CelestialBodyLoader", dict={"loadCelestialBody": lambda _name: earth}
    )
    CelestialBodyFactory.addCelestialBodyLoader("Earth", loader)


def read(folder, plan):
    """Both messages, and everything at SAMPLES_S by Orekit's own interpolation."""
    for name in ("aem", "oem"):
        (Path(folder) / f"plan.{name}").write_bytes(EXPORTERS[name].write(plan, CREATED_UTC))
    parsers = ParserBuilder()
    aem = parsers.buildAemParser().parseMessage(DataSource(f"{folder}/plan.aem"))
    oem = parsers.buildOemParser().parseMessage(DataSource(f"{folder}/plan.oem"))
    (attitudes,), (satellite,) = aem.getSegments(), oem.getSatellites().values()
    orbit, gcrf = satellite.getPropagator(), FramesFactory.getGCRF()
    start = attitudes.getStart()
    rows = []
    for t_s in SAMPLES_S:
        date = start.shiftedBy(t_s)
        attitude = attitudes.getAttitudeProvider().getAttitude(orbit, date, gcrf)
        rotation, state = attitude.getRotation(), orbit.getPVCoordinates(date, gcrf)
        rows.append(
            {
                "t_s": t_s,
                "x_payload_gcrf": list(rotation.applyInverseTo(Vector3D.PLUS_I).toArray()),
                "z_payload_gcrf": list(rotation.applyInverseTo(Vector3D.PLUS_K).toArray()),
                "spin_payload_rad_s": list(attitude.getSpin().toArray()),
                "r_sat_gcrf_m": list(state.getPosition().toArray()),
                "v_sat_gcrf_m_s": list(state.getVelocity().toArray()),
            }
        )
    metadata = attitudes.getMetadata()
    endpoints = metadata.getEndpoints()
    return {
        "attitude_from": str(endpoints.getFrameA().getName()),
        "attitude_to": str(endpoints.getFrameB().getName()),
        "attitude_type": str(metadata.getAttitudeType()),
        "object_id": str(metadata.getObjectID()),
        "start": str(start.toString()),
        "orbit_stop": str(satellite.getStop().toString()),
        "samples": rows,
    }


def main():
    with tempfile.TemporaryDirectory() as folder:
        give_leap_seconds(folder)
        give_earth()
        found = read(folder, case())
    provenance = (
        f"Orekit by orekit-jpype {version('orekit-jpype')}, from the AEM and OEM exported for "
        "export_cases.case(), interpolated as the messages ask; made by exports_by_orekit.py"
    )
    GOLDEN.write_text(json.dumps({"provenance": provenance, **found}, indent=1) + "\n")
    longest = max(np.linalg.norm(row["spin_payload_rad_s"]) for row in found["samples"])
    print(
        f"{GOLDEN.name}: {len(found['samples'])} samples, fastest {np.degrees(longest):.2f} deg/s"
    )


if __name__ == "__main__":
    main()
