"""A child's work for an imaging session, and the reading of its stored table."""

import zlib
from dataclasses import asdict
from datetime import UTC, datetime

from app.answers.members import ProvenanceOut, provenance
from app.answers.spacecraft import (
    attitude_table_json,
    spacecraft_document,
    spacecraft_dry_run_json,
)
from app.requests.listings import listing_of_imaging
from app.requests.spacecraft import read_kept_spacecraft_request, read_spacecraft_request
from app.store.packed import PackedColumns, pack, unpack
from app.work.progress import report
from app.work.result import Result
from planner.spacecraft.export import IMAGING_EXPORTERS, SessionTable
from planner.spacecraft.requests import ImagingPlanRequest
from planner.spacecraft.table import AttitudeTable, ImagingWindow
from planner.world.frames.time_scales import utc_from_text, utc_text

_COLUMNS = (
    "eci_from_body_xyzw",
    "omega_body_rad_s",
    "alpha_body_rad_s2",
    "gimbal_rad",
    "gimbal_rate_rad_s",
)


def plan_and_pack_session(body: bytes, request: ImagingPlanRequest | None = None) -> Result:
    """Read unless that is done, plan, judge, fly and pack; raises a Refusal."""
    from planner.spacecraft.plan import plan_imaging

    now_utc = datetime.now(UTC)
    plan = plan_imaging(request or read_spacecraft_request(body), report)
    document = zlib.compress(spacecraft_document(plan, provenance(now_utc, body)))
    return Result(
        content=(document, pack(_pack(plan.table))),
        listing=listing_of_imaging(plan.request),
    )


def try_session(request: ImagingPlanRequest, provenance: ProvenanceOut) -> bytes:
    """The answer to a dry run: planned, judged and flown, nothing kept; raises a Refusal."""
    from planner.spacecraft.plan import plan_imaging

    return spacecraft_dry_run_json(plan_imaging(request), provenance)


def stored_session_json(table_columns: bytes) -> bytes:
    """The table as the answer holds it."""
    return attitude_table_json(_table(unpack(table_columns)))


def stored_session_file(
    request: bytes, table_columns: bytes, format_name: str, created_utc: datetime
) -> bytes:
    """The table by itself."""
    session = stored_session(request, table_columns)
    return IMAGING_EXPORTERS[format_name].write(session, created_utc)


def stored_session(request: bytes, table_columns: bytes) -> SessionTable:
    """What was asked, and the table as it was stored; raises KeptUnreadable."""
    return SessionTable(
        request=read_kept_spacecraft_request(request), table=_table(unpack(table_columns))
    )


def _pack(table: AttitudeTable) -> PackedColumns:
    return PackedColumns(
        columns={name: getattr(table, name) for name in _COLUMNS},
        facts={
            "epoch": utc_text(table.epoch_utc, 6),
            "windows": [asdict(window) for window in table.windows],
        },
    )


def _table(packed: PackedColumns) -> AttitudeTable:
    return AttitudeTable(
        epoch_utc=utc_from_text(packed.facts["epoch"]),
        **{name: packed.columns[name] for name in _COLUMNS},
        windows=tuple(ImagingWindow(**window) for window in packed.facts["windows"]),
    )
