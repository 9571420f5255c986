"""Files that nobody wants to decode, each with the camera size it claims to be of."""

import io
import struct
import zlib

import cv2
import numpy as np
from PIL import Image

WIDTH, HEIGHT = 640, 480


def coded(extension: str, picture: np.ndarray, *parameters: int) -> bytes:
    done, content = cv2.imencode(extension, picture, list(parameters))
    assert done
    return content.tobytes()


def chunk(kind: bytes, content: bytes) -> bytes:
    checked = kind + content
    return struct.pack(">I", len(content)) + checked + struct.pack(">I", zlib.crc32(checked))


def deflated_zeros(width: int, rows: int) -> bytes:
    """A zlib stream of many equal rows, of which only one is compressed."""
    squeezer = zlib.compressobj(9, wbits=-zlib.MAX_WBITS)  # header and check value: ours, below
    row = squeezer.compress(bytes(width)) + squeezer.flush(zlib.Z_FULL_FLUSH)
    check = (width * rows) % 65521 << 16 | 1  # Adler-32 of zeros: RFC 1950, 8.2
    return b"\x78\xda" + row * rows + squeezer.flush() + struct.pack(">I", check)


def png(width: int, height: int, *chunks: bytes, rows: int | None = None) -> bytes:
    """A grey PNG of zeros, whatever its header claims."""
    data = deflated_zeros(1 + width, height if rows is None else rows)
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"".join(
        [
            b"\x89PNG\r\n\x1a\n",
            chunk(b"IHDR", header),
            *chunks,
            chunk(b"IDAT", data),
            chunk(b"IEND", b""),
        ]
    )


def cmyk_jpeg() -> bytes:
    """As a printer wants it, by another library."""
    content = io.BytesIO()
    Image.fromarray(noise()).convert("CMYK").save(content, "JPEG")
    return content.getvalue()


def noise() -> np.ndarray:
    return np.random.default_rng(7).integers(0, 256, (HEIGHT, WIDTH), dtype=np.uint8)


NOISE = noise()
NOISE_16 = NOISE.astype(np.uint16) * 257
BOMB = deflated_zeros(1_000_000, 100)  # 100 MB in 100 kB

REFUSED: dict[str, bytes] = {
    "nothing": b"",
    "zeros": bytes(5000),
    "text": b"These are words, not pixels.\n" * 50,
    "PNG's first bytes only": b"\x89PNG\r\n\x1a\n",
    "JPEG's first bytes only": b"\xff\xd8\xff\xe0",
    "TIFF's first bytes only": b"II*\0",
    "truncated PNG": coded(".png", NOISE)[:-5000],
    "truncated PNG of 16 bit": coded(".png", NOISE_16)[:100_000],
    "truncated JPEG": coded(".jpg", NOISE)[:-5000],
    "truncated TIFF": coded(".tiff", NOISE)[:-5000],
    "PNG with a flipped byte": coded(".png", NOISE)[:50_000] + b"?" + coded(".png", NOISE)[50_001:],
    "PNG of 900 megapixels": png(30_000, 30_000),
    "PNG that claims 4 gigapixels": png(65_535, 65_535, rows=1),
    "PNG of no width": png(0, 480, rows=0),
    "PNG of another size": png(WIDTH + 1, HEIGHT),
    "GIF": b"GIF89a" + struct.pack("<HHBBB", WIDTH, HEIGHT, 0xF0, 0, 0) + bytes(2000),
    "SVG": b"<svg xmlns='http://www.w3.org/2000/svg'><script>alert(1)</script></svg>",
    "BMP": coded(".bmp", NOISE),
    "WebP": coded(".webp", NOISE),
    "TIFF that points at itself": b"II*\0" + struct.pack("<I", 8) + struct.pack("<H", 65535),
    "TIFF of 32-bit floats": coded(".tiff", NOISE.astype(np.float32)),
    "CMYK JPEG": cmyk_jpeg(),
    "PDF": b"%PDF-1.7\n" + bytes(1000),
}
# Read, or refused: but never a crash.
ANSWERED: dict[str, bytes] = {
    "PNG of 16 bit": coded(".png", NOISE_16),
    "PNG with a text bomb": png(WIDTH, HEIGHT, chunk(b"zTXt", b"Comment\0\0" + BOMB)),
    "PNG with a colour profile bomb": png(WIDTH, HEIGHT, chunk(b"iCCP", b"icc\0\0" + BOMB)),
    "PNG with more rows than said": png(WIDTH, HEIGHT, rows=100_000),
    "PNG with an alpha": coded(".png", np.dstack([NOISE] * 4)),
    "JPEG with bytes after its end": coded(".jpg", NOISE) + bytes(100_000),
}
