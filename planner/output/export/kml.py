"""A plan's map as KML.  Source: OGC 12-007r2, KML 2.3."""

from datetime import datetime
from typing import Any

from lxml import etree

from planner.base.arrays import Array
from planner.output.export.map_features import FeatureKind, MapFeature, PlanMap
from planner.output.export.map_shapes import Areas, Lines, Point, Shape
from planner.output.export.plan_map import map_of
from planner.world.frames.time_scales import utc_text
from planner.world.plan import FlightPlan

_SPACE = "http://www.opengis.net/kml/2.2"
_NAMESPACES: Any = {None: _SPACE}  # the default one, which lxml's stubs don't know
# Opacity, blue, green, red; widths in pixels.
_STYLES: dict[FeatureKind, tuple[str, int]] = {
    "track": ("ffffaa5a", 2),
    "boresight": ("ff00a0ff", 2),
    "swath": ("805adc00", 1),
    "footprint": ("ff5adc00", 1),
    "target": ("ff3c3cff", 2),
}
_AREA_OPACITY = "50"


def write_kml(plan: FlightPlan, created_utc: datetime) -> bytes:
    """The ground track, where the boresight went, each session's swath, footprints and target."""
    return kml_of(map_of(plan, created_utc))


def kml_of(shown: PlanMap) -> bytes:
    """A document with a folder per kind of feature."""
    notes = "\n".join(map(_plain, shown.notes))
    document = _element("Document", _text("name", _plain(shown.name)), _text("description", notes))
    for kind, (colour, width) in _STYLES.items():
        style = _element(
            "Style",
            _element("LineStyle", _text("color", colour), _text("width", str(width))),
            _element("PolyStyle", _text("color", _AREA_OPACITY + colour[2:])),
        )
        style.set("id", kind)
        document.append(style)
    for kind in _STYLES:
        features = [feature for feature in shown.features if feature.kind == kind]
        if features:
            document.append(_element("Folder", _text("name", kind), *map(_placemark, features)))
    whole = _element("kml", document)
    return etree.tostring(whole, xml_declaration=True, encoding="UTF-8", pretty_print=True)


def _placemark(feature: MapFeature) -> etree._Element:
    facts = "\n".join(_plain(f"{name}: {value}") for name, value in feature.facts.items())
    placemark = _element(
        "Placemark", _text("name", _plain(feature.name)), _text("description", facts)
    )
    if feature.start_utc is not None and feature.stop_utc is not None:
        begin, end = map(_moment, (feature.start_utc, feature.stop_utc))
        placemark.append(_element("TimeSpan", _text("begin", begin), _text("end", end)))
    placemark.append(_text("styleUrl", f"#{feature.kind}"))
    placemark.append(_geometry(feature.shape))
    return placemark


def _geometry(shape: Shape) -> etree._Element:
    if isinstance(shape, Point):
        place = f"{shape.longitude_deg:.6f},{shape.latitude_deg:.6f},{shape.height_m:.1f}"
        return _element("Point", _text("coordinates", place))
    if isinstance(shape, Lines):
        parts = [
            _element("LineString", _text("tessellate", "1"), _coordinates(part))
            for part in shape.parts_deg
        ]
    else:
        assert isinstance(shape, Areas)
        parts = [_polygon(ring) for ring in shape.rings_deg]
    return parts[0] if len(parts) == 1 else _element("MultiGeometry", *parts)


def _polygon(ring_deg: Array) -> etree._Element:
    around = _element("outerBoundaryIs", _element("LinearRing", _coordinates(ring_deg)))
    return _element("Polygon", _text("tessellate", "1"), around)


def _coordinates(place_deg: Array) -> etree._Element:
    return _text("coordinates", " ".join(f"{x:.6f},{y:.6f}" for x, y in place_deg.tolist()))


def _element(tag: str, *inside: etree._Element) -> etree._Element:
    element = etree.Element(f"{{{_SPACE}}}{tag}", nsmap=_NAMESPACES)
    element.extend(inside)
    return element


def _text(tag: str, text: str) -> etree._Element:
    element = _element(tag)
    element.text = text
    return element


def _moment(moment_utc: datetime) -> str:
    """XML knows no leap second: it reads as the second before."""
    return utc_text(moment_utc).replace(":60.", ":59.")


def _plain(text: str) -> str:
    """On one line, without what XML can't hold."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())
