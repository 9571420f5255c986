"""Reads STAPI's requests, and the file of an operator's products."""

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import datetime
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import Field

from app.requests.campaign import CAMPAIGN_READER
from app.requests.json_reader import JsonReader, json_document, json_fields
from planner.base.errors import FieldError, InvalidInput, InvalidRequest, Refusal
from planner.base.spec import Within, spec
from planner.planning.campaigns import CampaignRequest
from planner.planning.opportunities import OpportunityConditions
from planner.world.attitude import Attitude
from planner.world.frames.time_scales import DAY_S, shifted_utc, utc_from_text, utc_text
from planner.world.orbits import Orbit
from planner.world.platforms import AnyPlatform
from planner.world.rules.registry import rules_of
from planner.world.targets.geojson import (
    GeoLineString,
    GeoMultiLineString,
    GeoMultiPolygon,
    GeoPolygon,
    Position,
)

SETTING = "SLEWTRACK_STAPI_PRODUCTS"
PAGE_MAX = 500  # opportunities, whose probabilities take 6 ms each
LOOK_S = (1.0, 21_000.0)
_ID, _URL = re.compile(r"[\w.-]{1,64}", re.ASCII), re.compile(r"https?://[^\s?#]+/")
_MODES = {"LineString": "corridor", "Polygon": "area"}
_MODES |= {f"Multi{kind}": mode for kind, mode in _MODES.items()}
GEOMETRIES = ("Point", *_MODES)
# Where an order says what its campaign's request has.
_SAID_AS = {
    "targets.0.session_s": "order_parameters.duration_s",
    "targets.0.target.geometry": "geometry",
    "targets": "geometry",
    "start": "datetime",
    "stop": "datetime",
    "conditions": "filter",
}


class Queryable(NamedTuple):
    """A property that a filter may bound, and the conditions that do it."""

    text: str
    at_most: str
    at_least: str = ""


QUERYABLES = {
    "view:off_nadir": Queryable(
        "Angle of the line of sight from the geocentric nadir, degrees: `<=`", "max_off_nadir_deg"
    ),
    "view:incidence_angle": Queryable(
        "Angle of the carrier from the target's zenith, degrees: `<=`", "min_elevation_deg"
    ),
    "view:sun_elevation": Queryable(
        "Elevation of the Sun's centre at the target, degrees: `<=`, `>=`",
        "sun_elevation_max_deg",
        "sun_elevation_min_deg",
    ),
    "gsd": Queryable(
        "Ground sample along the line of sight's lean, m: `<=`", "max_ground_sample_m"
    ),
}
_LEAST = ("min_elevation_deg", "sun_elevation_min_deg")  # of two the greater counts


@spec
class LookParameters:
    """Parameters of an order, beside its place and its time.

    name: your name for the order, shown in lists.
    duration_s: duration of a look at a point, the product's unless given; lines and areas are
    scanned at their own speed.
    """

    name: str = ""
    duration_s: Annotated[float, Within(*LOOK_S)] | None = None


@spec
class GeoPoint:
    """A GeoJSON point: longitude, latitude and, if given, height above the ellipsoid in metres."""

    type: Literal["Point"] = "Point"
    coordinates: Position

    def __post_init__(self) -> None:
        longitude_deg, latitude_deg, *_ = (*self.coordinates, 999.0, 999.0)
        if not (-180.0 <= longitude_deg <= 360.0 and -90.0 <= latitude_deg <= 90.0):
            raise ValueError(
                "coordinates must be [longitude, latitude] in degrees, within -180..360 and "
                f"-90..90, not {[*self.coordinates]}"
            )


Geometry = GeoPoint | GeoLineString | GeoMultiLineString | GeoPolygon | GeoMultiPolygon


@spec
class StapiOrder:
    """What an order is placed by."""

    datetime: str
    geometry: Annotated[Geometry, Field(discriminator="type")]
    filter: Mapping[str, Any] | None = None
    order_parameters: LookParameters = LookParameters()


@spec
class StapiSearch(StapiOrder):
    """What opportunities are asked for by: the order that is to follow, and the page."""

    next: str | None = None
    limit: Annotated[int, Within(1, PAGE_MAX)] = 10


@spec
class StapiProduct:
    """A carrier whose looks can be ordered.

    duration_s: of a look at a point, unless the order says another.
    open_days: length of an interval that has one end.
    conditions: those of every look, which an order's filter may make narrower.
    """

    id: str
    title: str = ""
    description: str
    license: str = "proprietary"
    keywords: tuple[str, ...] = ()
    platform: AnyPlatform
    orbit: Orbit
    attitude: Attitude | None = None
    duration_s: Annotated[float, Within(*LOOK_S)] = 10.0
    open_days: Annotated[float, Within(1.0, 31.0)] = 7.0
    conditions: OpportunityConditions = OpportunityConditions()

    def __post_init__(self) -> None:
        if not _ID.fullmatch(self.id):
            raise ValueError(f"id must be 1 to 64 of A-Z, a-z, 0-9, `.`, `_`, `-`, not {self.id!r}")
        rules_of(self.platform).require_attitude(self.attitude)


@spec
class StapiProducts:
    """An operator's products.

    url: under which clients reach the service, where a proxy stands before it.
    """

    title: str = "slewtrack"
    description: str = "Looks of pointing instruments, planned and verified"
    url: str | None = None
    products: Annotated[tuple[StapiProduct, ...], Field(min_length=1, max_length=100)]

    def __post_init__(self) -> None:
        if self.url is not None and not _URL.fullmatch(self.url):
            raise ValueError(f"url must be like https://tasking.example/, not {self.url!r}")
        ids = [product.id for product in self.products]
        for number, one in enumerate(ids):
            if one in ids[:number]:
                raise ValueError(f"products.{number}.id {one!r} is taken already; give another")


ORDER_READER, SEARCH_READER = JsonReader(StapiOrder), JsonReader(StapiSearch)
PARAMETERS_READER = JsonReader(LookParameters)


class AskedOrder(NamedTuple):
    """An order as a campaign of one target.

    body: the campaign's request.  told: the order in its own words, both ends of its interval told.
    """

    campaign: CampaignRequest
    body: bytes
    told: dict[str, Any]


@dataclass(frozen=True)
class OfferedProduct:
    """A product; carrier: members of any request of it, in the operator's words."""

    spec: StapiProduct
    carrier: Mapping[str, Any]

    def asked(self, order: StapiOrder) -> AskedOrder:
        """Raises InvalidRequest with the order's own fields."""
        given, geometry = order.order_parameters, json_fields(order.geometry)
        with _refused_as("datetime"):
            start_utc, stop_utc = _interval(order.datetime, self.spec.open_days)
        with _refused_as("filter"):
            conditions = _conditions(self.spec.conditions, order.filter)
        interval = [utc_text(at_utc, 6) for at_utc in (start_utc, stop_utc)]
        target: dict[str, Any] = {"id": "order", "session_s": given.duration_s}
        if isinstance(order.geometry, GeoPoint):
            names = ("longitude_deg", "latitude_deg", "height_m")
            place = dict(zip(names, order.geometry.coordinates, strict=False))
            target["target"] = {"mode": "ground", **place}
            target["session_s"] = given.duration_s or self.spec.duration_s
        else:
            target["target"] = {"mode": _MODES[order.geometry.type], "geometry": geometry}
        campaign = {
            "name": given.name or f"Order of {self.spec.title or self.spec.id}",
            **self.carrier,
            "targets": [target],
            "start": interval[0],
            "stop": interval[1],
            "conditions": json_fields(conditions),
        }
        told = {
            "datetime": "/".join(interval),
            "geometry": geometry,
            "filter": order.filter,
            "order_parameters": json_fields(given),
        }
        body = json.dumps(campaign).encode()
        try:
            read = CAMPAIGN_READER.read(body)
        except InvalidRequest as refusal:
            raise InvalidRequest(*map(_as_said, refusal.errors)) from None
        assert isinstance(read, CampaignRequest)  # a product has one carrier
        return AskedOrder(read, body, told)

    def search_body(self, asked: AskedOrder) -> bytes:
        """The request for windows that hold a whole look; of an area for those of its middle."""
        campaign = asked.campaign
        least_s = max(campaign.targets[0].session_s or 0.0, campaign.conditions.min_duration_s)
        conditions = replace(campaign.conditions, min_duration_s=least_s)
        windows = replace(campaign.opportunities(), name=campaign.name, conditions=conditions)
        return json.dumps(json_fields(windows, self.carrier)).encode()


def require_package() -> None:
    """Raises InvalidInput where the answers' classes aren't installed."""
    if find_spec("stapi_pydantic") is None:
        detail = (
            "needs the package stapi-pydantic, of the extra `stapi`: pip install stapi-pydantic"
        )
        raise InvalidInput(detail, field=SETTING)


def read_products(file: Path) -> tuple[StapiProducts, Mapping[str, OfferedProduct]]:
    """As an operator wrote them; raises InvalidInput with the setting that names the file."""
    try:
        body = file.read_bytes()
        found = JsonReader(StapiProducts).read(body)
    except OSError as error:
        raise InvalidInput(f"{file} can't be read: {error.strerror}", field=SETTING) from None
    except InvalidRequest as refusal:
        raise InvalidInput(f"{file}: {refusal.errors[0]}", field=SETTING) from None
    document: Any = json_document(body)
    products = {}
    for one, words in zip(found.products, document["products"], strict=True):
        given = {"platform", "orbit", "attitude"} & words.keys()
        products[one.id] = OfferedProduct(one, {name: words[name] for name in sorted(given)})
    return found, products


@contextmanager
def _refused_as(field: str) -> Iterator[None]:
    try:
        yield
    except (ValueError, Refusal) as error:
        raise InvalidRequest(FieldError(field=field, detail=str(error))) from None


def _as_said(error: FieldError) -> FieldError:
    for campaigns, said in _SAID_AS.items():
        if error.field.startswith(campaigns):
            rest = error.field.removeprefix(campaigns) if "geometry" in campaigns else ""
            return replace(error, field=said + rest)
    return error


def _interval(text: str, open_days: float) -> tuple[datetime, datetime]:
    """Both ends, of which `..` or nothing stands for one."""
    ends = text.split("/")
    if len(ends) != 2 or {*ends} <= {"", ".."}:
        raise ValueError(
            "must be START/STOP, of which one may be `..`, such as "
            f"2026-03-01T00:00:00Z/2026-03-08T00:00:00Z, not {text[:80]!r}"
        )
    start, stop = (None if end in ("", "..") else utc_from_text(end) for end in ends)
    if start is None:
        assert stop is not None
        return shifted_utc(stop, -open_days * DAY_S), stop
    return start, stop or shifted_utc(start, open_days * DAY_S)


def _conditions(
    known: OpportunityConditions, asked: Mapping[str, Any] | None
) -> OpportunityConditions:
    """The product's, made narrower by a filter."""
    for name, value in _bounds(asked) if asked else ():
        least = getattr(known, name)
        narrower = max if name in _LEAST else min
        changed: dict[str, Any] = {name: value if least is None else narrower(least, value)}
        known = replace(known, **changed)
    return known


def _bounds(node: object) -> Iterator[tuple[str, float]]:
    """Conditions and their limits, of a filter in CQL2 JSON; raises ValueError."""
    match node:
        case {"op": "and", "args": [_, *_] as parts}:
            for part in parts:
                yield from _bounds(part)
            return
        case {"op": "between", "args": [named, low, high]}:
            yield from _bounds({"op": ">=", "args": [named, low]})
            yield from _bounds({"op": "<=", "args": [named, high]})
            return
        case {"op": "<=" | "<" | ">=" | ">" as op, "args": [{"property": str(name)}, value]}:
            known = QUERYABLES.get(name, Queryable("", ""))
            condition = known.at_most if op[0] == "<" else known.at_least
            if condition and isinstance(value, int | float) and not isinstance(value, bool):
                yield condition, 90.0 - value if name == "view:incidence_angle" else float(value)
                return
    raise ValueError(
        f"must bound {', '.join(QUERYABLES)} by {{op: <=, args: [{{property: ...}}, number]}}, "
        "view:sun_elevation by >= and between, too, joined by `and`; "
        f"not {json.dumps(node)[:80]}"
    )
