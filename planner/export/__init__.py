"""The formats a plan can be exported in."""

from planner.export.ccsds import write_aem, write_oem
from planner.export.csv import write_csv
from planner.export.czml import write_czml
from planner.export.exporter import Exporter, FlightPlan, Segment, SegmentKind
from planner.export.json import write_json
from planner.export.netcdf import write_netcdf
from planner.export.stk import write_stk_attitude, write_stk_sensor

EXPORTERS: dict[str, Exporter[FlightPlan]] = {
    "csv": Exporter(title="command table", media_type="text/csv", suffix=".csv", write=write_csv),
    "json": Exporter(
        title="command table", media_type="application/json", suffix=".json", write=write_json
    ),
    "netcdf": Exporter(
        title="command table, attitude, orbit and ground track (CF-1.12)",
        media_type="application/x-netcdf",
        suffix=".nc",
        write=write_netcdf,
    ),
    "aem": Exporter(
        title="attitude of the payload (CCSDS AEM 2.0, KVN)",
        media_type="text/x-ccsds-aem",
        suffix=".aem",
        write=write_aem,
    ),
    "oem": Exporter(
        title="orbit of the carrier (CCSDS OEM 2.0, KVN)",
        media_type="text/x-ccsds-oem",
        suffix=".oem",
        write=write_oem,
    ),
    "stk": Exporter(
        title="pointing of the payload on the carrier (STK sensor pointing)",
        media_type="text/x-stk-sensor-pointing",
        suffix=".sp",
        write=write_stk_sensor,
    ),
    "stk-attitude": Exporter(
        title="attitude of the carrier (STK attitude)",
        media_type="text/x-stk-attitude",
        suffix=".a",
        write=write_stk_attitude,
    ),
    "czml": Exporter(
        title="orbit, boresight, footprint and targets for Cesium",
        media_type="application/x-czml+json",
        suffix=".czml",
        write=write_czml,
    ),
}

__all__ = ["EXPORTERS", "Exporter", "FlightPlan", "Segment", "SegmentKind"]
