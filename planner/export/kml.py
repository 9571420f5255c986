"""A plan's map as KML.  Source: OGC 12-007r2, KML 2.3."""

from collections.abc import Iterable
from datetime import datetime

from lxml import etree
from lxml.builder import ElementMaker

from planner.arrays import Array
from planner.export.exporter import FlightPlan
from planner.export.map_features import FeatureKind, MapFeature, PlanMap
from planner.export.map_shapes import Areas, Lines, Place, Shape
from planner.export.plan_map import map_of
from planner.frames.time_scales import utc_text

_SPACE = "http://www.opengis.net/kml/2.2"
_KML = ElementMaker(namespace=_SPACE, nsmap={None: _SPACE})
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
    document = _KML.Document(
        _KML.name(_plain(shown.name)), _KML.description("\n".join(map(_plain, shown.notes)))
    )
    for kind, (colour, width) in _STYLES.items():
        document.append(
            _KML.Style(
                _KML.LineStyle(_KML.color(colour), _KML.width(str(width))),
                _KML.PolyStyle(_KML.color(_AREA_OPACITY + colour[2:])),
                id=kind,
            )
        )
    for kind in _STYLES:
        features = [feature for feature in shown.features if feature.kind == kind]
        if features:
            document.append(_KML.Folder(_KML.name(kind), *map(_placemark, features)))
    kml = _KML.kml(document)
    return etree.tostring(kml, xml_declaration=True, encoding="UTF-8")


def _placemark(feature: MapFeature) -> etree._Element:
    facts = "\n".join(_plain(f"{name}: {value}") for name, value in feature.facts.items())
    placemark = _KML.Placemark(_KML.name(_plain(feature.name)), _KML.description(facts))
    if feature.start_utc is not None and feature.stop_utc is not None:
        begin, end = map(_moment, (feature.start_utc, feature.stop_utc))
        placemark.append(_KML.TimeSpan(_KML.begin(begin), _KML.end(end)))
    placemark.append(_KML.styleUrl(f"#{feature.kind}"))
    placemark.append(_geometry(feature.shape))
    return placemark


def _geometry(shape: Shape) -> etree._Element:
    if isinstance(shape, Place):
        place = f"{shape.longitude_deg:.6f},{shape.latitude_deg:.6f},{shape.height_m:.1f}"
        return _KML.Point(_KML.coordinates(place))
    if isinstance(shape, Lines):
        parts = [_KML.LineString(_KML.tessellate("1"), _coordinates(p)) for p in shape.parts]
    else:
        assert isinstance(shape, Areas)
        parts = [
            _KML.Polygon(
                _KML.tessellate("1"), _KML.outerBoundaryIs(_KML.LinearRing(_coordinates(ring)))
            )
            for ring in shape.rings
        ]
    return parts[0] if len(parts) == 1 else _KML.MultiGeometry(*parts)


def _coordinates(place_deg: Array) -> etree._Element:
    places: Iterable[tuple[float, float]] = map(tuple, place_deg.tolist())
    return _KML.coordinates(" ".join(f"{x:.6f},{y:.6f}" for x, y in places))


def _moment(moment_utc: datetime) -> str:
    """XML knows no leap second: it reads as the second before."""
    return utc_text(moment_utc).replace(":60.", ":59.")


def _plain(text: str) -> str:
    """On one line, without what XML can't hold."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())
