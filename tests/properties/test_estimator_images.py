"""Every hostile or odd upload is refused clearly, before it costs anything."""

import contextlib
import struct
import subprocess
import sys
import zlib

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from estimator.camera import HorizonCamera
from estimator.check import Verdict
from estimator.errors import InvalidImage
from estimator.found import CameraReport, VerticalEstimate
from estimator.images import decode_image, prepare
from estimator.overlay import draw_overlay

PICTURE = np.random.default_rng(0).integers(0, 255, (48, 64, 3), dtype=np.uint8)


def camera_of(width_px, height_px, focal_px, **more):
    """Its optical axis in the middle of the frame, along the body's Z."""
    middle_px = {"cx_px": 0.5 * (width_px - 1), "cy_px": 0.5 * (height_px - 1)}
    focal = {"fx_px": focal_px, "fy_px": focal_px, "q_camera_from_body_xyzw": (0.0, 0.0, 0.0, 1.0)}
    size = {"width_px": width_px, "height_px": height_px}
    return HorizonCamera(name="c", **size, **focal, **middle_px, **more)


def coded(extension, picture=PICTURE):
    _, content = cv2.imencode(extension, picture)
    return content.tobytes()


def png_chunk(kind, data):
    crc = struct.pack(">I", zlib.crc32(kind + data))
    return struct.pack(">I", len(data)) + kind + data + crc


def png_claiming(width, height):
    """A PNG that claims so many grey pixels and holds a million."""
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    content = b"\x89PNG\r\n\x1a\n" + png_chunk(b"IHDR", header)
    return content + png_chunk(b"IDAT", zlib.compress(bytes(10**6))) + png_chunk(b"IEND", b"")


def exif_rotated(content):
    """The JPEG with an EXIF block that asks for a quarter turn (orientation 6)."""
    tiff = b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0"
    data = b"Exif\0\0" + tiff
    return content[:2] + b"\xff\xe1" + struct.pack(">H", len(data) + 2) + data + content[2:]


def test_a_large_frame_is_annotated_at_reduced_size():
    """In full size 20.7 megapixels would take more memory than a measurement has."""
    camera = camera_of(5568, 3712, 5000.0)
    limb_px = np.array([[2784.0, 1856.0]])
    report = CameraReport(
        name="c",
        used=True,
        reason=None,
        explanation=None,
        arc_deg=30.0,
        residual_px=0.2,
        limb_px=limb_px,
    )
    estimate = VerticalEstimate(verdict=Verdict.NOT_OBSERVABLE, cameras=(report,))
    picture = draw_overlay(np.zeros((3712, 5568), dtype=np.uint8), camera, report, estimate)
    assert picture.shape == (1067, 1600, 3)
    assert picture[533, 800, 1] == 255  # green, in the middle


@pytest.mark.parametrize("extension", [".png", ".jpg", ".tiff"])
@pytest.mark.parametrize(
    "picture",
    [PICTURE, PICTURE[..., 0], PICTURE.astype(np.uint16) * 257],
    ids=["colour", "grey", "16 bit"],
)
def test_what_opencv_wrote_is_read(extension, picture):
    if extension == ".jpg" and picture.dtype == np.uint16:
        picture = picture.astype(np.uint8)
    read = decode_image(coded(extension, picture))
    assert read.shape == picture.shape
    if extension != ".jpg":
        np.testing.assert_array_equal(read, picture)


def test_exif_rotation_is_ignored():
    assert decode_image(exif_rotated(coded(".jpg"))).shape == PICTURE.shape


def test_alpha_masks():
    picture = np.dstack([PICTURE, np.full((48, 64), 255, np.uint8)])
    picture[:10, :, 3] = 0
    below = ((0.0, 40.0), (63.0, 40.0), (63.0, 47.0), (0.0, 47.0))
    camera = camera_of(64, 48, 50.0, mask=(below,))
    usable = prepare(decode_image(coded(".png", picture)), camera, "images.0", blue=False).usable
    assert not usable[:10].any()
    assert not usable[40:].any()
    assert usable[10:40].all()


HOSTILE = {
    "900 Mpx PNG": lambda: png_claiming(30000, 30000),
    "cut PNG of 49 Mpx": lambda: png_claiming(7000, 7000),
    "no bytes": lambda: b"",
    "text": lambda: b"not an image" * 1000,
}


@pytest.mark.parametrize("kind", HOSTILE)
def test_a_refusal_costs_less_than_a_second_and_500_megabytes(kind):
    """In a process of its own, as the service runs it, capped by the kernel: CPU and memory."""
    code = (
        "import resource, sys\n"
        "from estimator.images import decode_image\n"
        "from estimator.errors import InvalidImage\n"
        "content = sys.stdin.buffer.read()\n"
        "used = resource.getrusage(resource.RUSAGE_SELF)\n"
        "spent = used.ru_utime + used.ru_stime\n"
        "resource.setrlimit(resource.RLIMIT_CPU, (int(spent) + 2, int(spent) + 2))\n"
        "try:\n    decode_image(content)\nexcept InvalidImage:\n"
        "    used = resource.getrusage(resource.RUSAGE_SELF)\n"
        # VmHWM begins anew with the process; ru_maxrss would carry the test runner's own peak.
        "    status = open('/proc/self/status').read()\n"
        "    peak_kb = int(status.split('VmHWM:')[1].split()[0])\n"
        "    print(used.ru_utime + used.ru_stime - spent, peak_kb / 1024.0)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], input=HOSTILE[kind](), capture_output=True, check=True
    )
    cpu_s, peak_mb = map(float, done.stdout.split())
    # Issue 4's bounds; CPU time, which a busy machine doesn't stretch.
    assert cpu_s < 1.0
    assert peak_mb < 500.0


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_bytes_turned_over_never_do_worse_than_a_refusal(data):
    content = bytearray(coded(data.draw(st.sampled_from([".png", ".jpg", ".tiff"]))))
    for _ in range(data.draw(st.integers(1, 12))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    with contextlib.suppress(InvalidImage):
        assert decode_image(bytes(content)).size > 0
