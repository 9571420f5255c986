"""The formats a plan can be exported in."""

from planner.output.export.ccsds import write_aem, write_oem
from planner.output.export.csv import write_csv
from planner.output.export.czml import write_czml
from planner.output.export.exporter import Exporter
from planner.output.export.figure import write_png, write_svg
from planner.output.export.geojson import write_geojson
from planner.output.export.ics import write_ics
from planner.output.export.json import write_json
from planner.output.export.kml import write_kml
from planner.output.export.netcdf import write_netcdf
from planner.output.export.stk import write_stk_attitude, write_stk_sensor
from planner.world.plan import FlightPlan

EXPORTERS: dict[str, Exporter[FlightPlan]] = {
    "csv": Exporter("command table", "text/csv", ".csv", write_csv),
    "json": Exporter("command table", "application/json", ".json", write_json),
    "netcdf": Exporter(
        "command table, attitude, orbit and ground track (CF-1.12)",
        "application/x-netcdf", ".nc", write_netcdf,
    ),
    "aem": Exporter(
        "attitude of the payload (CCSDS AEM 2.0, KVN)", "text/x-ccsds-aem", ".aem", write_aem
    ),
    "oem": Exporter(
        "orbit of the carrier (CCSDS OEM 2.0, KVN)", "text/x-ccsds-oem", ".oem", write_oem
    ),
    "stk": Exporter(
        "pointing of the payload on the carrier (STK sensor pointing)",
        "text/x-stk-sensor-pointing", ".sp", write_stk_sensor,
    ),
    "stk-attitude": Exporter(
        "attitude of the carrier (STK attitude)", "text/x-stk-attitude", ".a", write_stk_attitude
    ),
    "czml": Exporter(
        "orbit, boresight, footprint and targets for Cesium",
        "application/x-czml+json", ".czml", write_czml, shows=True,
    ),
    "geojson": Exporter(
        "map: ground track, boresight, swaths, footprints and targets",
        "application/geo+json", ".geojson", write_geojson, shows=True,
    ),
    "kml": Exporter(
        "the same map for Google Earth",
        "application/vnd.google-earth.kml+xml", ".kml", write_kml, shows=True,
    ),
    "ics": Exporter("sessions as events of a calendar", "text/calendar", ".ics", write_ics),
    "png": Exporter(
        "plot of angles, rates and accelerations", "image/png", ".png", write_png, shows=True
    ),
    "svg": Exporter(
        "the same plot in vectors", "image/svg+xml", ".svg", write_svg, shows=True
    ),
}  # fmt: skip

__all__ = ["EXPORTERS", "Exporter"]
