"""A child's work on images of the horizon.

Bytes in, bytes out: what comes from outside is decoded nowhere else.
"""

import base64
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from app.answers.horizon import PictureOut, estimate_out
from app.answers.members import ProvenanceOut, to_json
from app.requests.horizon import PictureRequest
from app.work.horizon_views import attitudes_at, surroundings
from estimator.camera import HorizonCamera
from estimator.errors import InvalidCamera
from estimator.request import Body, HorizonRequest
from estimator.surroundings import Surroundings
from planner.base.rotation import Rotation

if TYPE_CHECKING:
    from estimator.images import Pixels
    from estimator.pipeline import VerticalEstimate

# Decoded and measured within a second and 500 MB.
PIXELS_MAX = 25_000_000


@contextmanager
def _report_out_of_memory() -> Iterator[None]:
    """OpenCV has an error of its own for a lack of memory."""
    import cv2

    try:
        yield
    except cv2.error as error:
        if error.code == cv2.Error.StsNoMem:
            raise MemoryError(error.err) from None
        raise


@_report_out_of_memory()
def measure(
    request: HorizonRequest, images: Sequence[bytes], *, draw: bool
) -> tuple["VerticalEstimate", tuple[bytes, ...]]:
    """The estimate and, if wanted, the annotated frames as PNG files.

    Raises InvalidImage, InvalidCamera.
    """
    from estimator.images import decode_image
    from estimator.pipeline import estimate_vertical

    if len(images) != len(request.cameras):
        raise InvalidCamera(
            f"{len(images)} images for {len(request.cameras)} cameras; send one per camera, in "
            "the cameras' order",
            field="images",
        )
    total = sum(camera.width_px * camera.height_px for camera in request.cameras)
    if total > PIXELS_MAX:
        raise InvalidCamera(
            f"the frames come to {total} pixels together; {PIXELS_MAX} are read at a time: send "
            "fewer, or bin them",
            field="cameras",
        )
    pixels = [
        decode_image(content, f"images.{k}", camera)
        for k, (content, camera) in enumerate(zip(images, request.cameras, strict=True))
    ]
    estimate = estimate_vertical(pixels, request)
    return estimate, _overlays(request, pixels, estimate) if draw else ()


def estimate_json(
    request: HorizonRequest, images: Sequence[bytes], provenance: ProvenanceOut
) -> bytes:
    """The whole answer as UTF-8 JSON."""
    estimate, overlays = measure(request, images, draw=request.overlay)
    return to_json(estimate_out(estimate, request.epoch, overlays, provenance))


@_report_out_of_memory()
def picture(request: PictureRequest) -> bytes:
    """The rendered picture as a PNG file."""
    from estimator.overlay import encode_png
    from estimator.rendering.scene import HorizonRenderer

    around, c_body_from_itrf = _surroundings(request)
    horizon = HorizonRenderer(
        around.limb.r_itrf_m, c_body_from_itrf, around.sun_itrf, request.scene, request.seed
    )
    return encode_png(horizon.picture(request.camera, request.sensor))


def picture_json(request: PictureRequest) -> bytes:
    """The rendered picture and what an estimate should find in it, as UTF-8 JSON."""
    around, c_body_from_itrf = _surroundings(request)
    q = Rotation.from_matrix(c_body_from_itrf @ around.c_itrf_from_eci)
    answer = PictureOut(
        image_png=base64.b64encode(picture(request)).decode("ascii"),
        at_utc=request.at,
        position_itrf_m=around.limb.r_itrf_m,
        q_body_from_eci_xyzw=q.as_quat(),
        nadir_body=c_body_from_itrf @ around.limb.nadir_itrf,
        nadir_geodetic_body=c_body_from_itrf @ around.limb.nadir_geodetic_itrf,
    )
    return to_json(answer)


def _surroundings(request: PictureRequest) -> tuple[Surroundings, np.ndarray]:
    [r_m], [q], _ = attitudes_at(request.orbit, request.attitude.q_body_from_eci, [request.at])
    around = surroundings(request.at, r_m, (request.camera,), Body())
    return around, q.as_matrix() @ around.c_itrf_from_eci.T


def _overlays(
    request: HorizonRequest, images: Sequence["Pixels"], estimate: "VerticalEstimate"
) -> tuple[bytes, ...]:
    from estimator.overlay import draw_overlay, encode_png

    frames = zip(images, request.cameras, estimate.cameras, strict=True)
    return tuple(
        encode_png(draw_overlay(pixels, camera, report, estimate, _expected_px(request, camera)))
        for pixels, camera, report in frames
    )


def _expected_px(request: HorizonRequest, camera: HorizonCamera) -> np.ndarray | None:
    if request.predicted is None:
        return None
    from estimator.prediction import predict_horizon

    around = Surroundings(request.epoch, request.position, request.body)
    q_body_from_eci = Rotation.from_quat(request.predicted.q_body_from_eci_xyzw)
    return predict_horizon(camera, around, q_body_from_eci).limb_px
