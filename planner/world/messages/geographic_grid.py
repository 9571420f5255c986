"""Grids of values in geographic coordinates (WGS84), from ESRI ASCII grids and GeoTIFF files."""

import io
import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array, Mask
from planner.base.errors import InvalidMessage


@dataclass(frozen=True, kw_only=True)
class GridOptions:
    """Bounds of a grid that is read, and what of a GeoTIFF is taken for what."""

    cells_most: int = 16_000_000  # 64 MB as they are held: a degree by arcseconds has 13 million
    tile_most: int = 16_384  # pixels a side: a tile is unpacked whole, however small the picture
    # EPSG numbers; ETRS89 and NAD83 are a metre or two off, less than a cell.
    geographic: frozenset[int] = frozenset({4326, 4979, 4258, 4937, 4269, 4955})
    above_ellipsoid: frozenset[int] = frozenset({4979, 4937, 4955, 5030})
    metres: int = 9001
    degrees: int = 9102


OPTIONS = GridOptions()
_CONVERT = "convert it, e.g. with `gdalwarp -t_srs EPSG:4326`"


@dataclass(frozen=True, kw_only=True, eq=False)
class GeographicGrid:
    """Values at cells' centres, bilinear between them.

    values: (rows, columns) from north to south and from west to east, NaN where there is none.
    north_deg, west_deg: of the first centre.  step_deg: southward and eastward, both positive.
    above_ellipsoid: what the file itself says of heights; None where it doesn't.
    """

    values: NDArray[np.float32]
    north_deg: float
    west_deg: float
    step_deg: tuple[float, float]
    above_ellipsoid: bool | None = None

    @property
    def reach_text(self) -> str:
        """Between which centres it reaches."""
        rows, columns = self.values.shape
        south_deg = self.north_deg - (rows - 1) * self.step_deg[0]
        east_deg = self.west_deg + (columns - 1) * self.step_deg[1]
        return (
            f"latitudes {south_deg:.5g} to {self.north_deg:.5g} and longitudes "
            f"{self.west_deg:.5g} to {east_deg:.5g} deg"
        )

    def at(self, latitude_deg: Array, longitude_deg: Array) -> Array:
        """Values (n,) at places (n,); raises ValueError where it doesn't reach or has none.

        Within half a cell beyond the outer centres the outer values stay.
        """
        found, outside = self._found(latitude_deg, longitude_deg)
        if outside.any():
            raise ValueError(
                f"doesn't reach {_place(latitude_deg, longitude_deg, outside)}, only "
                f"{self.reach_text}"
            )
        if (missing := np.isnan(found)).any():
            raise ValueError(f"has no value at {_place(latitude_deg, longitude_deg, missing)}")
        return found

    def known(self, latitude_deg: Array, longitude_deg: Array) -> Array:
        """The same, NaN where it doesn't reach or has none."""
        found, outside = self._found(latitude_deg, longitude_deg)
        return np.where(outside, np.nan, found)

    def _found(self, latitude_deg: Array, longitude_deg: Array) -> tuple[Array, Mask]:
        """Values, and whether a place is outside, (n,) each."""
        rows, columns = self.values.shape
        row = (self.north_deg - np.asarray(latitude_deg)) / self.step_deg[0]
        east_deg = (np.asarray(longitude_deg) - self.west_deg + 0.5 * self.step_deg[1]) % 360.0
        column = east_deg / self.step_deg[1] - 0.5
        edge = 0.5 + 1e-6  # of a cell: the rounding of its corner
        outside = (np.abs(row - 0.5 * (rows - 1)) > 0.5 * (rows - 1) + edge) | (
            column > columns - 1 + edge
        )
        row, column = np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)
        top, left = np.floor(row).astype(np.intp), np.floor(column).astype(np.intp)
        below, right = np.minimum(top + 1, rows - 1), np.minimum(left + 1, columns - 1)
        down, across = row - top, column - left
        found = np.zeros(np.shape(row))
        for at, weight in (
            ((top, left), (1.0 - down) * (1.0 - across)),
            ((top, right), (1.0 - down) * across),
            ((below, left), down * (1.0 - across)),
            ((below, right), down * across),
        ):
            found += np.where(weight > 0.0, weight * self.values[at], 0.0)
        return found, np.asarray(outside)


def _place(latitude_deg: Array, longitude_deg: Array, where: Mask) -> str:
    first = int(np.argmax(where))
    return f"{np.ravel(latitude_deg)[first]:.5f}, {np.ravel(longitude_deg)[first]:.5f}"


def read_ascii_grid(text: str) -> GeographicGrid:
    """An ESRI ASCII grid in degrees; raises InvalidMessage.

    Source: the format's description by Esri (header of five or six lines, rows from the north).
    """
    lines = text.splitlines()
    header: dict[str, float] = {}
    for line in lines:
        words = line.split()
        if len(words) != 2 or not words[0][:1].isalpha():
            break
        header[words[0].lower()] = _number(words[1], words[0])
    step_deg = tuple(header.get(name, header.get("cellsize", math.nan)) for name in ("dy", "dx"))
    rows, columns = (_count(header, name) for name in ("nrows", "ncols"))
    require_cells(rows, columns)
    try:
        values = np.fromstring("\n".join(lines[len(header) :]), sep=" ")
    except ValueError:
        raise _fault("the ASCII grid holds what is no number after its header") from None
    if len(values) != rows * columns:
        raise _fault(f"an ASCII grid of {rows} rows and {columns} columns has {len(values)} values")
    south_deg, west_deg = (
        header[f"{axis}llcenter"]
        if f"{axis}llcenter" in header
        else header.get(f"{axis}llcorner", math.nan) + 0.5 * step
        for axis, step in zip("yx", step_deg, strict=True)
    )
    return _grid(
        values.reshape(rows, columns),
        south_deg + (rows - 1) * step_deg[0],
        west_deg,
        (step_deg[0], step_deg[1]),
        header.get("nodata_value"),
    )


def _number(text: str, name: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise _fault(f"{name[:20]} of the ASCII grid is no number: {text[:20]!r}") from None


def _count(header: Mapping[str, float], name: str) -> int:
    count = header.get(name, 0.0)
    if not (count >= 1.0 and count.is_integer()):
        raise _fault(
            f"an ASCII grid begins with ncols, nrows, xllcorner, yllcorner and cellsize; {name} is "
            "missing or no whole number"
        )
    return int(count)


def read_geotiff(content: bytes) -> GeographicGrid:
    """The first image of a GeoTIFF of one band, by OpenCV; raises InvalidMessage.

    Source: OGC 19-008r4 (GeoTIFF 1.1); nodata as GDAL writes it.
    """
    tags = _tags(content)
    keys = _geo_keys(tags)
    _require_geographic(keys)
    rows, columns = int(tags.get(257, 0)), int(tags.get(256, 0))
    require_cells(rows, columns)
    if tags.get(277, 1) != 1 or tags.get(262, 1) != 1:
        raise _fault("the GeoTIFF must hold one band of values, no colours")
    if max(int(tags.get(tag, 1)) for tag in (322, 323)) > OPTIONS.tile_most:
        raise _fault(f"a tile of the GeoTIFF has more than {OPTIONS.tile_most} pixels a side")
    scale, tie = tags.get(33550), tags.get(33922)
    if scale is None or tie is None or len(scale) < 2 or len(tie) != 6 or 34264 in tags:
        raise _fault(
            "the GeoTIFF doesn't say by one tie point and a scale where it lies, north up; "
            + _CONVERT
        )
    # A pixel is its area, whose corner is tied, unless it is a point.
    half = 0.0 if keys.get(1025) == 2 else 0.5
    return _grid(
        _pixels(content, rows, columns),
        tie[4] + (tie[1] - half) * scale[1],
        tie[3] - (tie[0] - half) * scale[0],
        (scale[1], scale[0]),
        _nodata(tags.get(42113)),
        above_ellipsoid=_says_above_ellipsoid(keys),
    )


def _tags(content: bytes) -> Mapping[int, Any]:
    from PIL.TiffImagePlugin import ImageFileDirectory_v2

    try:
        is_big = content[2:4] in (b"+\0", b"\0+")
        directory = ImageFileDirectory_v2(content[:16] if is_big else content[:8])
        file = io.BytesIO(content)
        file.seek(directory.next)
        with warnings.catch_warnings(action="ignore"):  # of damage, which is refused by what lacks
            directory.load(file)
            return dict(directory)
    except Exception as error:  # noqa: BLE001 (Pillow's, of damaged files)
        raise _fault(f"content is no TIFF that can be read ({str(error)[:60]})") from None


def _geo_keys(tags: Mapping[int, Any]) -> dict[int, int]:
    """Those whose values stand in the directory itself."""
    directory = tuple(tags.get(34735, ()))
    keys = np.array(directory[4 : len(directory) // 4 * 4], dtype=np.int64).reshape(-1, 4)
    return {int(key): int(value) for key, place, _, value in keys if place == 0}


def _require_geographic(keys: Mapping[int, int]) -> None:
    if keys.get(1024) != 2 or keys.get(2048) not in OPTIONS.geographic:
        which = keys.get(3072) or keys.get(2048)
        raise _fault(
            "the GeoTIFF must be in geographic coordinates of WGS84 (EPSG:4326), not "
            f"{f'EPSG:{which}' if which else 'without any that it names'}: {_CONVERT}"
        )
    for key, wanted, name in ((2054, OPTIONS.degrees, "degrees"), (4099, OPTIONS.metres, "metres")):
        if keys.get(key, wanted) != wanted:
            raise _fault(
                f"the GeoTIFF must be in {name}, not in EPSG's unit {keys[key]}: {_CONVERT}"
            )


def _says_above_ellipsoid(keys: Mapping[int, int]) -> bool | None:
    vertical = keys.get(4096)
    if vertical is None:
        return True if keys[2048] in OPTIONS.above_ellipsoid else None
    return vertical in OPTIONS.above_ellipsoid


def _nodata(text: object) -> float | None:
    return None if text is None else _number(str(text).strip("\0 "), "nodata")


def _pixels(content: bytes, rows: int, columns: int) -> Array:
    # Half a second to load, which only a grid should pay.
    import cv2

    # Each tag that OpenCV doesn't know would be told on stderr, and those that say where are such.
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        pixels = cv2.imdecode(np.frombuffer(content, dtype=np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        pixels = None
    if pixels is None or pixels.shape != (rows, columns):
        raise _fault(
            "the GeoTIFF's values can't be unpacked; write it anew, e.g. with "
            "`gdal_translate -co COMPRESS=DEFLATE`"
        )
    return np.asarray(pixels)


def _grid(
    image: Array,
    north_deg: float,
    west_deg: float,
    step_deg: tuple[float, float],
    nodata_value: float | None,
    *,
    above_ellipsoid: bool | None = None,
) -> GeographicGrid:
    rows, columns = image.shape
    south_deg = north_deg - (rows - 1) * step_deg[0]
    edge_deg = 1e-6 + 0.5 * step_deg[0]  # some have their centres on the poles
    if not (
        min(step_deg) > 0.0
        and -90.0 - edge_deg <= south_deg <= north_deg <= 90.0 + edge_deg
        and -360.0 <= west_deg <= 360.0
        and (columns - 1) * step_deg[1] <= 360.0
    ):
        raise _fault(
            f"the grid of {rows} rows and {columns} columns from {north_deg:.5g} north, "
            f"{west_deg:.5g} east in steps of {step_deg[0]:.5g} and {step_deg[1]:.5g} deg is no "
            f"part of the Earth in degrees: {_CONVERT}"
        )
    held = image.astype(np.float32)
    if nodata_value is not None:
        with np.errstate(over="ignore"):  # of 64 bits, beside values of 32
            held[image == nodata_value] = np.nan
    held[~np.isfinite(held)] = np.nan
    return GeographicGrid(
        values=held,
        north_deg=float(north_deg),
        west_deg=float(west_deg),
        step_deg=(float(step_deg[0]), float(step_deg[1])),
        above_ellipsoid=above_ellipsoid,
    )


def require_cells(rows: int, columns: int) -> None:
    if not 0 < rows * columns <= OPTIONS.cells_most or min(rows, columns) < 1:
        raise _fault(
            f"a grid has 1 to {OPTIONS.cells_most} cells, not {rows} x {columns}: cut out what is "
            "needed, or take wider cells"
        )


def _fault(detail: str) -> InvalidMessage:
    return InvalidMessage(detail)
