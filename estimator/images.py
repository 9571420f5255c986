"""Image files, and the frames the estimator takes from them.

Decoding trusts nothing: the kind is known by the file's first bytes, the size by its header,
and both are checked before a decoder sees the file.  `decode_image` is meant to run in a
process of its own, ended afterwards.  EXIF rotation is ignored on purpose: the camera model
describes the sensor's pixels as they were read out, whichever way up somebody looks at them.
"""

import struct
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from estimator import MAX_IMAGE_PIXELS
from estimator.camera import HorizonCamera
from estimator.errors import InvalidImage
from planner.base.arrays import Array

MAX_IMAGE_BYTES = 64_000_000

Grey = NDArray[np.float32]
Pixels = NDArray[np.uint8] | NDArray[np.uint16]

_KINDS = "PNG, JPEG or TIFF of 8 or 16 bit"
# Independent noise in two channels differs by 1.4 times that of one and more; in a JPEG by
# 0.3-1.3.  Clouds and coasts, alike in all channels, are left out: noise tells where it is quiet.
_SHARP_COLOUR = 1.38
_QUIET_SHARE = 0.5
_QUIET_PX = 15
_FULL = 0.975  # of the largest value: noise and JPEG move it
# Start-of-frame markers; C4, C8, CC are tables.
_JPEG_FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}


@dataclass(frozen=True)
class Frame:
    """grey: brightness 0..1, (h, w).  usable: False where masked or transparent.

    step: the smallest difference of brightness that tells.  pixels: the image itself.
    blue: grey is its blue channel, not the mean of all.  table: brightness of each stored level.
    decoded: it undoes a tone curve.
    """

    grey: Grey
    usable: NDArray[np.bool_]
    step: float
    pixels: Pixels
    blue: bool
    table: Grey
    decoded: bool = False

    def is_saturated(self, xy_px: Array) -> NDArray[np.bool_]:
        """Whether any channel is full at pixels (..., 2), those beyond the edge on it; (...)."""
        height, width = self.grey.shape
        inside = np.nan_to_num(np.rint(xy_px))
        x = np.clip(inside[..., 0], 0, width - 1).astype(int)
        y = np.clip(inside[..., 1], 0, height - 1).astype(int)
        return self.is_full(self.pixels[y, x].reshape(*x.shape, -1)[..., :3].max(axis=-1))

    def is_full(self, level: NDArray[Any]) -> NDArray[np.bool_]:
        """Whether stored levels (...) are the largest there is."""
        return np.asarray(level >= _FULL * full_scale(self.pixels))


def full_scale(pixels: Pixels) -> float:
    return 65535.0 if pixels.dtype == np.uint16 else 255.0


def brightness(levels: NDArray[np.float32], blue: bool) -> Grey:
    """Grey (h, w) of levels (h, w) or (h, w, channels), alpha left out."""
    if levels.ndim == 3 and levels.shape[2] > 2:
        weights = [[1.0, 0.0, 0.0]] if blue else [[1.0 / 3.0] * 3]
        return np.asarray(cv2.transform(np.ascontiguousarray(levels[..., :3]), np.array(weights)))
    return levels.reshape(levels.shape[:2])


def decode_image(
    content: bytes, field: str = "images", camera: HorizonCamera | None = None
) -> Pixels:
    """Pixels (h, w), (h, w, 3) or (h, w, 4), BGR order, 8 or 16 bit, not rotated.

    Raises InvalidImage(field) for anything but a whole PNG, JPEG or TIFF within the caps and,
    where the camera is told, of its size.
    """
    if len(content) > MAX_IMAGE_BYTES:
        raise InvalidImage(
            f"the file has {len(content)} bytes; at most {MAX_IMAGE_BYTES} are read", field=field
        )
    width, height = _header_size(content, field)
    if width * height > MAX_IMAGE_PIXELS or width < 1 or height < 1:
        raise InvalidImage(
            f"the image is {width} x {height} pixels; at most {MAX_IMAGE_PIXELS} are read",
            field=field,
        )
    if camera is not None:
        _require_size(width, height, camera, field)
    try:
        pixels = cv2.imdecode(np.frombuffer(content, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        pixels = None
    if pixels is None:
        raise InvalidImage("the image is damaged or incomplete; send the whole file", field=field)
    if pixels.dtype not in (np.uint8, np.uint16) or pixels.shape[:2] != (height, width):
        raise InvalidImage(f"the image must be a {_KINDS}, not {pixels.dtype}", field=field)
    return pixels.astype(np.uint16) if pixels.dtype == np.uint16 else pixels.astype(np.uint8)


def prepare(pixels: Pixels, camera: HorizonCamera, field: str, blue: bool) -> Frame:
    """Brightness of an image for a camera.  Raises InvalidImage when sizes differ.

    blue: take the blue channel of a colour image, else the mean of all.
    """
    height, width = pixels.shape[:2]
    _require_size(width, height, camera, field)
    full = full_scale(pixels)
    usable = np.ones(pixels.shape[:2], dtype=np.uint8)
    if pixels.ndim == 3 and pixels.shape[2] == 4:
        usable[pixels[..., 3] < 0.5 * full] = 0
    for polygon in camera.mask:
        cv2.fillPoly(usable, [np.rint(np.array(polygon)).astype(np.int32)], 0)
    return Frame(
        grey=brightness(pixels.astype(np.float32), blue) / np.float32(full),
        usable=usable.astype(bool),
        step=1.0 / full,
        pixels=pixels,
        blue=blue,
        table=np.arange(full + 1.0, dtype=np.float32) / np.float32(full),
    )


def _require_size(width: int, height: int, camera: HorizonCamera, field: str) -> None:
    if (width, height) != (camera.width_px, camera.height_px):
        raise InvalidImage(
            f"the image is {width} x {height} pixels but camera {camera.name!r} has "
            f"{camera.width_px} x {camera.height_px}; send the sensor's own pixels, unrotated",
            field=field,
        )


def blue_is_sharp(pixels: Pixels) -> bool:
    """Whether a colour image's blue channel has been kept pixel by pixel.

    JPEG files keep colour at half resolution: then the fine detail of blue is that of grey,
    and the limb in blue is smeared over 8-pixel blocks.
    """
    if pixels.ndim != 3 or pixels.shape[2] < 3:
        return False
    rows = pixels[4::9, :, :2].astype(np.int32)
    fine = np.diff(rows, n=2, axis=1)
    unrest = cv2.blur(np.abs(fine.sum(axis=2)).astype(np.float32), (_QUIET_PX, 1))
    varied = unrest > 0.0
    if not varied.any():
        return False
    quiet = varied & (unrest <= np.quantile(unrest[varied], _QUIET_SHARE))
    colour = float(np.mean(np.abs(fine[..., 0] - fine[..., 1])[quiet]))
    return colour > _SHARP_COLOUR * float(np.mean(np.abs(fine[..., 1][quiet]))) > 0.0


def _header_size(content: bytes, field: str) -> tuple[int, int]:
    """Width and height that the file's header claims."""
    size = None
    if content[:8] == b"\x89PNG\r\n\x1a\n":
        if len(content) >= 24 and content[12:16] == b"IHDR":
            size = struct.unpack(">II", content[16:24])
    elif content[:3] == b"\xff\xd8\xff":
        size = _jpeg_size(content, field)
    elif content[:4] in (b"II*\0", b"MM\0*"):
        size = _tiff_size(content)
    else:
        raise InvalidImage(f"this is no image we read; send a {_KINDS}", field=field)
    if size is None:
        raise InvalidImage("the image's header is damaged; send the whole file", field=field)
    return size


def _jpeg_size(content: bytes, field: str) -> tuple[int, int] | None:
    at = 2
    while at + 9 < len(content):
        if content[at] != 0xFF:
            return None
        marker = content[at + 1]
        if marker == 0xFF or 0xD0 <= marker <= 0xD7:
            at += 1 if marker == 0xFF else 2
            continue
        length = int.from_bytes(content[at + 2 : at + 4], "big")
        if marker in _JPEG_FRAMES:
            height, width, components = struct.unpack(">HHB", content[at + 5 : at + 10])
            if components not in (1, 3):
                raise InvalidImage(
                    f"the JPEG has {components} components, as CMYK for printing has; send grey "
                    "or RGB",
                    field=field,
                )
            return width, height
        if length < 2:
            return None
        at += 2 + length
    return None


def _tiff_size(content: bytes) -> tuple[int, int] | None:
    order = "<" if content[:2] == b"II" else ">"
    if len(content) < 8:
        return None
    start = struct.unpack(order + "I", content[4:8])[0]
    if start + 2 > len(content):
        return None
    found = {}
    entries = struct.unpack(order + "H", content[start : start + 2])[0]
    for k in range(min(entries, 512)):
        entry = content[start + 2 + 12 * k : start + 14 + 12 * k]
        if len(entry) < 12:
            return None
        tag, kind = struct.unpack(order + "HH", entry[:4])
        if tag in (256, 257) and kind in (3, 4):
            form = "H" if kind == 3 else "I"
            found[tag] = struct.unpack(order + form, entry[8 : 8 + struct.calcsize(form)])[0]
    return (found[256], found[257]) if len(found) == 2 else None
