"""The route of a stored plan's view."""

from http import HTTPStatus
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from app.http.blocking import in_child, read
from app.http.negotiation import JSON, is_known_already, preferred_type
from app.http.routes.jobs import no_such
from app.http.routes.plan_queries import PathId, PlanViewQuery, ViewQuery, with_formats
from app.http.routes.resources import PlanResource
from app.http.routes.stored_plans import (
    EXPORT_BOUNDS,
    REVALIDATE,
    UNCHANGED,
    find,
    immutable_tag,
    not_modified,
    saved_as,
)
from app.http.view_cache import ViewCache
from app.jobs.refusals import Conflict
from app.store import jobs
from app.store.plans import StoredPlan
from app.work.view import AskedView
from planner.base.errors import Refusal

_JSON_FORMAT = "json"


def add_view(router: APIRouter, resource: PlanResource) -> None:
    """`GET {id}/view` of a resource that holds plans."""
    media_type_by_format = {_JSON_FORMAT: JSON} | {
        name: exporter.media_type for name, exporter in resource.view_exporters.items()
    }
    format_by_media_type = {media: name for name, media in media_type_by_format.items()}
    query_model = with_formats(
        PlanViewQuery if resource.takes_pixel else ViewQuery,
        "The view in this format",
        {_JSON_FORMAT: "columns over time"}
        | {name: exporter.title for name, exporter in resource.view_exporters.items()},
    )

    async def get_view(
        request: Request, plan_id: PathId, query: Annotated[ViewQuery, Query()]
    ) -> Response:
        """The view is computed from the table and the request of any kept plan.

        Columns have a number for each row and their unit in the name; null stands where nothing is
        defined.
        """
        form = (
            query.format
            or (format_by_media_type[preferred_type(request, tuple(format_by_media_type))])
        )
        job, plan = await find(request, resource, plan_id)
        if plan is None:
            raise Conflict(
                f"there is nothing to see yet: the plan's state is {job.state}; GET "
                f"{resource.path}/{job.id} tells more"
            )
        pixel_arcsec = query.pixel_arcsec if isinstance(query, PlanViewQuery) else None
        tag = immutable_tag(plan, f"view-{form}-{query.step_s}-{pixel_arcsec}")
        if is_known_already(request, tag):
            return not_modified(tag)
        cache: ViewCache = request.app.state.views
        content = cache.get(tag)
        if content is None:
            asked = AskedView(
                plan_id=plan.id,
                verified=plan.state == "done",
                format_name=None if form == _JSON_FORMAT else form,
                step_s=query.step_s,
                pixel_arcsec=pixel_arcsec,
                created_utc=plan.planned_utc,
            )
            content = await _view(request, resource, plan, asked)
            cache.keep(tag, content)
        headers = REVALIDATE | {"ETag": tag}
        if form != _JSON_FORMAT:
            exporter = resource.view_exporters[form]
            stem = resource.file_stem
            headers |= saved_as(plan.name, stem, exporter.suffix, exporter.media_type)
        return Response(content, HTTPStatus.OK, headers, media_type_by_format[form])

    get_view.__annotations__["query"] = Annotated[query_model, Query()]
    router.get(
        "/{id}/view",
        summary="View a plan as columns over time, map or plot",
        response_model=resource.view_response,
        responses={
            200: {
                "description": "The columns; or a file, as `format` or Accept asks",
                "content": {media: {} for media in format_by_media_type if media != JSON},
            },
            304: UNCHANGED,
            404: no_such(resource),
            409: {"description": "The plan was not made, or not yet"},
            422: {
                "description": "`step_s` fits neither the table nor an answer; or, but for JSON, "
                "the plan's verification failed"
            },
        },
    )(get_view)


async def _view(
    request: Request, resource: PlanResource, plan: StoredPlan, asked: AskedView
) -> bytes:
    """Raises a refusal of what was asked with the parameter's name."""
    body = await read(request, lambda connection: jobs.request_of(connection, plan.id))
    try:
        return await in_child(
            request, EXPORT_BOUNDS, resource.view_file, body or b"", plan.table_columns, asked
        )
    except Refusal as refusal:
        if refusal.field == "step_s":
            refusal.field = "query.step_s"
        raise
