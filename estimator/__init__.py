"""The local vertical from images of the horizon.

OpenCV reads its cap on decoded pixels once, when it is loaded: it is set here, before any
module of the package can load it.
"""

import os

MAX_IMAGE_PIXELS = 50_000_000
os.environ.setdefault("OPENCV_IO_MAX_IMAGE_PIXELS", str(MAX_IMAGE_PIXELS))
