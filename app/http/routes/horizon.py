"""The horizon over HTTP: estimates, predictions and pictures."""

from datetime import UTC, datetime
from typing import Annotated, Any

import anyio.to_thread
from fastapi import APIRouter, Depends, Request, Response

from app.answers.members import provenance
from app.http.blocking import answer_in_child, in_child
from app.http.negotiation import (
    JSON,
    MAX_REQUEST_BYTES,
    MULTIPART,
    ONLY_JSON,
    FormPart,
    json_body,
    media_type_of,
    preferred_type,
    read_parts,
    unsupported,
    whole_body,
)
from app.http.openapi.schema import form_body_of, json_body_of, schema_of
from app.jobs.child import Bounds
from app.jobs.worker_process import ChildDied
from app.requests.examples import ESTIMATE_EXAMPLE, PICTURE_EXAMPLES, PREDICTION_EXAMPLES
from app.work.horizon import (
    ESTIMATE_READER,
    PICTURE_READER,
    PREDICTION_READER,
    EstimateResponse,
    PredictionResponse,
    estimate_json,
    picture,
    picture_json,
    prediction_json,
)
from estimator.errors import InvalidImage
from estimator.found import PictureOut
from estimator.request import MAX_CAMERAS

router = APIRouter(tags=["horizon"])

PNG = "image/png"
# Decoders of images have had holes: what a stranger's picture did to one must end with it.
ESTIMATE_BOUNDS = Bounds(deadline_s=20.0, memory_mib=500, alone=True)
# A picture of 4 megapixels took 1.6 GB and 14 s on a busy core.
PREDICTION_BOUNDS = Bounds(deadline_s=60.0, memory_mib=1000)
PICTURE_BOUNDS = Bounds(deadline_s=60.0, memory_mib=2000)

_PARTS = (
    FormPart("request", "is needed: JSON with the cameras", 1, MAX_REQUEST_BYTES),
    FormPart("images", "are needed, one part per camera in the cameras' order", MAX_CAMERAS),
)
_UPLOAD_BODY = form_body_of(
    schema_of(ESTIMATE_READER) | {"examples": [ESTIMATE_EXAMPLE]},
    {
        "images": {
            "type": "array",
            "description": "One PNG, JPEG or TIFF of 8 or 16 bit per camera, in the cameras' "
            "order, as read out: rotation by EXIF is ignored.",
            "items": {"type": "string", "format": "binary"},
        }
    },
)

# The picture first, so that pages which try it out ask for it and show it.
_PICTURE_ANSWERS: dict[str, Any] = {
    "model": PictureOut,
    "description": "The picture; as JSON with its truth",
    "content": {PNG: {"schema": {"type": "string", "format": "binary"}}, JSON: {}},
}


async def _upload(request: Request) -> dict[str, list[bytes]]:
    """The parts `request` and `images`; refused when others are sent, or some are missing."""
    if media_type_of(request) != MULTIPART:
        way_out = f"{MULTIPART} (its part `request` holds JSON, its parts `images` one file each)"
        raise unsupported(request, way_out)
    body = await whole_body(request, request.app.state.settings.max_upload_bytes)
    return await read_parts(request, body, _PARTS)


@router.post(
    "/v1/horizon/estimates",
    summary="Estimate the local vertical from images of the horizon",
    response_model=EstimateResponse,
    dependencies=ONLY_JSON,
    openapi_extra=_UPLOAD_BODY,
)
async def post_estimate(
    request: Request, upload: Annotated[dict[str, list[bytes]], Depends(_upload)]
) -> Response:
    """Measures the nadir in body axes with its covariance, and checks an attitude against it.

    Frames that show no usable horizon get the answer `not_observable` with a reason, not a
    refusal; files that are no images are refused.
    """
    now_utc, [head], images = datetime.now(UTC), upload["request"], tuple(upload["images"])
    spec = await anyio.to_thread.run_sync(ESTIMATE_READER.read, head)
    origin = await anyio.to_thread.run_sync(provenance, now_utc, head, *images)
    try:
        answer = await in_child(request, ESTIMATE_BOUNDS, estimate_json, spec, images, origin)
    except ChildDied:  # of its images
        raise InvalidImage(
            "reading these images brought the reader down; save them anew with another program",
            field="images",
        ) from None
    return Response(answer, media_type=JSON)


@router.post(
    "/v1/horizon/predictions",
    summary="Predict the views of horizon cameras",
    response_model=PredictionResponse,
    dependencies=ONLY_JSON,
    openapi_extra=json_body_of(PREDICTION_READER, PREDICTION_EXAMPLES),
)
async def post_prediction(request: Request, body: Annotated[bytes, Depends(json_body)]) -> Response:
    """For each instant and camera the answer has the limb in pixels, its arc and light, and the
    expected 1-sigma of the nadir, or the reason for which the frame will be of no use.

    `horizon_cameras` in a plan's request asks for the same at its sessions.
    """
    return await answer_in_child(
        request, body, PREDICTION_READER.read, PREDICTION_BOUNDS, prediction_json
    )


@router.post(
    "/v1/horizon/images",
    summary="Render a picture of the horizon",
    response_class=Response,
    responses={200: _PICTURE_ANSWERS},
    openapi_extra=json_body_of(PICTURE_READER, PICTURE_EXAMPLES),
)
async def post_picture(request: Request, body: Annotated[bytes, Depends(json_body)]) -> Response:
    """The picture shows Earth, air, clouds and Sun as a camera would take it.

    Send `Accept: application/json` for the picture with the true vertical that an estimate
    should find.
    """
    kind = preferred_type(request, (PNG, JSON))
    spec = await anyio.to_thread.run_sync(PICTURE_READER.read, body)
    work = picture if kind == PNG else picture_json
    return Response(await in_child(request, PICTURE_BOUNDS, work, spec), media_type=kind)
