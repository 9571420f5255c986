"""Finds a stored plan and answers with it, whole or its table by itself."""

import re
from http import HTTPStatus

import anyio.to_thread
from fastapi import Request, Response
from sqlalchemy import Connection

from app.answers.members import PlanHead, fill, whole_answer
from app.http.blocking import in_child, read
from app.http.negotiation import JSON, weak_tag
from app.http.routes.jobs import job_of
from app.http.routes.resources import PlanResource
from app.jobs.child import Bounds
from app.store import jobs, plans
from app.store.jobs import Job
from app.store.plans import StoredPlan
from app.versions import VERSION

# Enough for many times a pass; the longest table there is covers a day.
EXPORT_BOUNDS = Bounds(deadline_s=120.0, memory_mib=2000)
# Turning more than this of a packed table into JSON would hold the interpreter for long.
_PACKED_MAX_BYTES = 200_000
_NAME_MAX = 60

REVALIDATE = {"Cache-Control": "private, no-cache", "Vary": "Accept"}
UNCHANGED = {"description": "Unchanged since the ETag that If-None-Match names"}


def not_modified(tag: str) -> Response:
    """Of what the client has already."""
    return Response(status_code=HTTPStatus.NOT_MODIFIED, headers=REVALIDATE | {"ETag": tag})


async def find(
    request: Request, resource: PlanResource, plan_id: str
) -> tuple[Job, StoredPlan | None]:
    """A job of a resource, with its plan where there is one; raises 404."""

    def reading(connection: Connection) -> tuple[Job, StoredPlan | None]:
        job = job_of(connection, resource, plan_id)
        is_made = job.state in ("done", "failed")
        return job, plans.get(connection, job) if is_made else None

    return await read(request, reading)


def immutable_tag(plan: StoredPlan, form: str = "json") -> str:
    """The ETag of a plan in one form: it never changes, the program that writes it may."""
    return weak_tag(f"{plan.id}-{form}-{VERSION}")


async def whole_json(request: Request, resource: PlanResource, plan: StoredPlan) -> bytes:
    """The answer to the request it was planned for."""
    if len(plan.table_columns) > _PACKED_MAX_BYTES:
        table = await in_child(request, EXPORT_BOUNDS, resource.table_json, plan.table_columns)
    else:
        table = await anyio.to_thread.run_sync(resource.table_json, plan.table_columns)
    return whole_answer(fill(PlanHead, plan), plan.document, table)


async def table_answer(
    request: Request,
    resource: PlanResource,
    plan: StoredPlan,
    format_name: str | None,
    status: HTTPStatus,
    headers: dict[str, str],
) -> Response:
    """The table by itself, without a format as the whole answer holds it.

    Raises Unverified, OutsideCoverage.
    """
    if format_name is None:
        table = await in_child(request, EXPORT_BOUNDS, resource.table_json, plan.table_columns)
        return Response(table, status, headers, JSON)
    exporter = resource.exporters[format_name]
    body = await read(request, lambda connection: jobs.request_of(connection, plan.id))
    content = await in_child(
        request,
        EXPORT_BOUNDS,
        resource.table_file,
        body or b"",
        plan.table_columns,
        format_name,
        plan.planned_utc,
    )
    headers |= saved_as(plan.name, resource.file_stem, exporter.suffix)
    return Response(content, status, headers, exporter.media_type)


def saved_as(name: str, otherwise: str, suffix: str, shown_as: str | None = None) -> dict[str, str]:
    """The header of a file to save, named in letters, digits and hyphens after what it is of.

    shown_as: its media type, where a browser may show it: pictures are.
    """
    words = re.findall(r"[A-Za-z0-9]+", name)
    file = ("-".join(words)[:_NAME_MAX] or otherwise) + suffix
    how = "inline" if shown_as is not None and shown_as.startswith("image/") else "attachment"
    return {"Content-Disposition": f'{how}; filename="{file}"'}
