"""The formats that an imaging session's table is exported in."""

from planner.output.export.exporter import Exporter
from planner.spacecraft.export.czml import write_czml
from planner.spacecraft.export.figure import write_png, write_svg
from planner.spacecraft.export.map import write_geojson, write_kml
from planner.spacecraft.export.session_table import SessionTable
from planner.spacecraft.export.tables import write_aem, write_csv, write_netcdf

IMAGING_EXPORTERS: dict[str, Exporter[SessionTable]] = {
    "csv": Exporter("attitude, rates and gimbals", "text/csv", ".csv", write_csv),
    "netcdf": Exporter(
        "attitude, rates and gimbals (CF-1.12)", "application/x-netcdf", ".nc", write_netcdf
    ),
    "aem": Exporter(
        "attitude of the body (CCSDS AEM 2.0, KVN)", "text/x-ccsds-aem", ".aem", write_aem
    ),
    "czml": Exporter(
        "orbit, attitude, optical axis and swaths for Cesium",
        "application/x-czml+json", ".czml", write_czml, shows=True,
    ),
    "geojson": Exporter(
        "map: ground track, swaths and requests",
        "application/geo+json", ".geojson", write_geojson, shows=True,
    ),
    "kml": Exporter(
        "the same map for Google Earth",
        "application/vnd.google-earth.kml+xml", ".kml", write_kml, shows=True,
    ),
    "png": Exporter("plot of body rates and gimbals", "image/png", ".png", write_png, shows=True),
    "svg": Exporter("the same plot in vectors", "image/svg+xml", ".svg", write_svg, shows=True),
}  # fmt: skip

__all__ = ["IMAGING_EXPORTERS", "SessionTable"]
