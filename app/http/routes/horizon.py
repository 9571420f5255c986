"""The horizon over HTTP: estimates, predictions and pictures."""

import hashlib
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Annotated, Any, TypeVar

import anyio.to_thread
from fastapi import APIRouter, Depends, Request, Response
from pydantic import TypeAdapter

from app.answers.horizon import EstimateResponse, PredictionResponse
from app.answers.members import provenance
from app.http.blocking import in_child
from app.http.horizon_upload import MULTIPART, HorizonUpload, horizon_upload
from app.http.negotiation import JSON, accepts_json, json_body, preferred_type
from app.http.openapi.schema import REF, request_body
from app.jobs.child import Bounds
from app.jobs.disposable import ChildDied
from app.requests.examples.horizon import ESTIMATE_EXAMPLE, PICTURE_EXAMPLES, PREDICTION_EXAMPLES
from app.requests.horizon import (
    read_estimate_request,
    read_picture_request,
    read_prediction_request,
)
from app.work.horizon import PictureOut, estimate_json, picture, picture_with_truth
from app.work.horizon_views import prediction_json
from estimator.errors import InvalidImage
from estimator.request import HorizonRequest
from planner.frames.time_scales import utc_text

router = APIRouter(tags=["horizon"])

PNG = "image/png"
# Decoders of images have had holes: what a stranger's picture did to one must end with it.
ESTIMATE_BOUNDS = Bounds(deadline_s=20.0, memory_mib=500, alone=True)
# A picture of 4 megapixels took 1.6 GB and 14 s on a busy core.
PREDICTION_BOUNDS = Bounds(deadline_s=60.0, memory_mib=1000)
PICTURE_BOUNDS = Bounds(deadline_s=60.0, memory_mib=2000)

T = TypeVar("T")

_MULTIPART_BODY: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {
            MULTIPART: {
                "schema": {
                    "type": "object",
                    "required": ["request", "images"],
                    "properties": {
                        "request": {"$ref": REF.format(model="HorizonRequest")},
                        "images": {
                            "type": "array",
                            "description": "One PNG, JPEG or TIFF of 8 or 16 bit per camera, in "
                            "the cameras' order, as read out: rotation by EXIF is ignored.",
                            "items": {"type": "string", "contentMediaType": "image/*"},
                        },
                    },
                },
                "encoding": {"request": {"contentType": JSON}},
                "example": {"request": ESTIMATE_EXAMPLE},
            }
        },
    }
}


@router.post(
    "/v1/horizon/estimates",
    summary="Where is the local vertical in these images, and does the attitude agree?",
    response_model=EstimateResponse,
    dependencies=[Depends(accepts_json)],
    openapi_extra=_MULTIPART_BODY,
)
async def post_estimate(
    request: Request, upload: Annotated[HorizonUpload, Depends(horizon_upload)]
) -> Response:
    """Nadir in body axes from images of the horizon, with its covariance.

    Frames that show no usable horizon are the answer `not_observable` with a reason, not a
    refusal; files that are no images are refused.
    """
    now_utc = datetime.now(UTC)
    asked, digest = await anyio.to_thread.run_sync(_read_estimate, upload)
    made = provenance(digest, now_utc)
    answer = await of_images(request, ESTIMATE_BOUNDS, estimate_json, asked, upload.images, made)
    return Response(answer, media_type=JSON)


@router.post(
    "/v1/horizon/predictions",
    summary="What will each horizon camera see, and will it be of use?",
    response_model=PredictionResponse,
    dependencies=[Depends(accepts_json)],
    openapi_extra=request_body("PredictionRequest", PREDICTION_EXAMPLES),
)
async def post_prediction(request: Request, body: Annotated[bytes, Depends(json_body)]) -> Response:
    """Per instant and camera the limb's line in pixels, its arc and light, and the expected
    1-sigma of the nadir, or why the frame will be of no use.

    A plan's sessions are looked ahead to by `horizon_cameras` in its request.
    """
    now_utc = datetime.now(UTC)
    asked = await anyio.to_thread.run_sync(read_prediction_request, body)

    made = provenance(hashlib.sha256(body).hexdigest(), now_utc)
    answer = await in_child(request, PREDICTION_BOUNDS, prediction_json, asked, made)
    return Response(answer, media_type=JSON)


@router.post(
    "/v1/horizon/images",
    summary="A rendered picture of the horizon, as a camera would take it",
    response_model=PictureOut,
    responses={200: {"content": {PNG: {}}, "description": "The picture; as JSON with its truth"}},
    openapi_extra=request_body("PictureRequest", PICTURE_EXAMPLES),
)
async def post_picture(request: Request, body: Annotated[bytes, Depends(json_body)]) -> Response:
    """Earth, air, clouds, Sun and sensor, with the truth an estimate should find on request.

    Send `Accept: application/json` for the truth beside the picture.
    """
    kind = preferred_type(request, (PNG, JSON))
    asked = await anyio.to_thread.run_sync(read_picture_request, body)
    if kind == PNG:
        return Response(await in_child(request, PICTURE_BOUNDS, picture, asked), media_type=PNG)
    told = await in_child(request, PICTURE_BOUNDS, picture_with_truth, asked, utc_text(asked.at))
    return Response(TypeAdapter(PictureOut).dump_json(told), media_type=JSON)


def _read_estimate(upload: HorizonUpload) -> tuple[HorizonRequest, str]:
    """What is asked, and the digest of up to 64 MB."""
    return read_estimate_request(upload.request), upload.sha256


async def of_images(request: Request, bounds: Bounds, work: Callable[..., T], *given: object) -> T:
    """`in_child`; a child that dies died of its images."""
    try:
        return await in_child(request, bounds, work, *given)
    except ChildDied:
        raise InvalidImage(
            "reading these images brought the reader down; save them anew with another program",
            field="images",
        ) from None
