"""The horizon over HTTP: estimates, predictions and pictures."""

from datetime import UTC, datetime
from typing import Annotated, Any

import anyio.to_thread
from fastapi import APIRouter, Depends, Request, Response

from app.answers.horizon import EstimateResponse, PictureOut, PredictionResponse
from app.answers.members import provenance
from app.http.blocking import answer_in_child, in_child
from app.http.horizon_upload import MULTIPART, HorizonUpload, horizon_upload
from app.http.negotiation import JSON, accepts_json, json_body, preferred_type
from app.http.openapi.schema import REF, request_body
from app.jobs.child import Bounds
from app.jobs.worker_process import ChildDied
from app.requests.examples.horizon import ESTIMATE_EXAMPLE, PICTURE_EXAMPLES, PREDICTION_EXAMPLES
from app.requests.horizon import (
    read_estimate_request,
    read_picture_request,
    read_prediction_request,
)
from app.work.horizon import estimate_json, picture, picture_json
from app.work.horizon_views import prediction_json
from estimator.errors import InvalidImage

router = APIRouter(tags=["horizon"])

PNG = "image/png"
# Decoders of images have had holes: what a stranger's picture did to one must end with it.
ESTIMATE_BOUNDS = Bounds(deadline_s=20.0, memory_mib=500, alone=True)
# A picture of 4 megapixels took 1.6 GB and 14 s on a busy core.
PREDICTION_BOUNDS = Bounds(deadline_s=60.0, memory_mib=1000)
PICTURE_BOUNDS = Bounds(deadline_s=60.0, memory_mib=2000)

_MULTIPART_BODY: dict[str, Any] = {
    "requestBody": {
        "required": True,
        "content": {
            MULTIPART: {
                "schema": {
                    "type": "object",
                    "required": ["request", "images"],
                    "properties": {
                        "request": {
                            "$ref": REF.format(model="HorizonRequest"),
                            "examples": [ESTIMATE_EXAMPLE],
                        },
                        "images": {
                            "type": "array",
                            "description": "One PNG, JPEG or TIFF of 8 or 16 bit per camera, in "
                            "the cameras' order, as read out: rotation by EXIF is ignored.",
                            "items": {"type": "string", "format": "binary"},
                        },
                    },
                },
                "encoding": {"request": {"contentType": JSON}},
            }
        },
    }
}

# The picture first, so that pages which try it out ask for it and show it.
_PICTURE_ANSWERS: dict[str, Any] = {
    "model": PictureOut,
    "description": "The picture; as JSON with its truth",
    "content": {PNG: {"schema": {"type": "string", "format": "binary"}}, JSON: {}},
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
    now_utc, images = datetime.now(UTC), upload.images
    spec = await anyio.to_thread.run_sync(read_estimate_request, upload.request)
    origin = await anyio.to_thread.run_sync(provenance, now_utc, upload.request, *images)
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
    return await answer_in_child(
        request, body, read_prediction_request, PREDICTION_BOUNDS, prediction_json
    )


@router.post(
    "/v1/horizon/images",
    summary="A rendered picture of the horizon, as a camera would take it",
    response_class=Response,
    responses={200: _PICTURE_ANSWERS},
    openapi_extra=request_body("PictureRequest", PICTURE_EXAMPLES),
)
async def post_picture(request: Request, body: Annotated[bytes, Depends(json_body)]) -> Response:
    """Earth, air, clouds, Sun and sensor, with the truth an estimate should find on request.

    Send `Accept: application/json` for the truth beside the picture.
    """
    kind = preferred_type(request, (PNG, JSON))
    spec = await anyio.to_thread.run_sync(read_picture_request, body)
    work = picture if kind == PNG else picture_json
    return Response(await in_child(request, PICTURE_BOUNDS, work, spec), media_type=kind)
