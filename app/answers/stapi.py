"""STAPI's answers, as its own classes have them; loaded where an operator has products."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Literal, NamedTuple

from stapi_pydantic import (
    Link,
    Opportunity,
    OpportunityProperties,
    Order,
    OrderProperties,
    OrderSearchParameters,
    OrderStatus,
    OrderStatusCode,
    Product,
)
from stapi_pydantic.constants import STAPI_VERSION

from app.answers.problem import TYPE_PREFIX
from app.requests.stapi import GEOMETRIES, StapiProduct
from app.store.job import Job
from planner.output.export import EXPORTERS
from planner.world.frames.time_scales import shifted_utc, utc_from_text, utc_text

REST_S = 600.0  # for the way to an opportunity's looks and back
JSON, GEOJSON = "application/json", "application/geo+json"
_CLASS = f"https://stapi.example.com/v{STAPI_VERSION}"
CONFORMS_TO = [f"{_CLASS}/core", f"{_CLASS}/order-statuses"]
PRODUCT_CONFORMS_TO = [f"{_CLASS}/opportunities"]
PRODUCT_CONFORMS_TO += [f"https://geojson.org/schema/{one}.json" for one in GEOMETRIES]


class OpportunityOut(Opportunity[Any, OpportunityProperties]):
    """With what the specification asks for beyond the class."""

    stapi_type: Literal["Opportunity"] = "Opportunity"
    stapi_version: str = STAPI_VERSION


class Links:
    """Those of a service; base: its address, with a slash."""

    def __init__(self, base: str) -> None:
        self._base = base

    def to(self, rel: str, path: str, media_type: str = JSON, **members: Any) -> Link:  # noqa: ANN401 (of a Link)
        return Link(href=self._base + path, rel=rel, type=media_type, **members)

    def create_order(self, product_id: str, body: Mapping[str, Any] | None = None) -> Link:
        """An order of a product; body: what it says."""
        path = f"stapi/products/{product_id}/orders"
        return self.to("create-order", path, method="POST", body=body)


def product_out(product: StapiProduct, links: Links) -> Product:
    at = f"stapi/products/{product.id}"
    told = ("id", "title", "description", "license")
    below = ("conformance", "queryables", "order-parameters")
    return Product(
        **{name: getattr(product, name) for name in told},
        keywords=[*product.keywords],
        conformsTo=PRODUCT_CONFORMS_TO,
        links=[
            links.to("self", at),
            *(links.to(rel, f"{at}/{rel}") for rel in below),
            links.to("opportunities", f"{at}/opportunities", GEOJSON, method="POST"),
            links.create_order(product.id),
        ],
    )


def opportunity_out(
    window: Mapping[str, Any], product_id: str, told: Mapping[str, Any], links: Links
) -> OpportunityOut:
    """A window with view and probability, and how to order it; told: the order's words."""
    closest = window["closest"]
    begin_utc, end_utc = map(utc_from_text, (window["rise"], window["set"]))
    around = (shifted_utc(begin_utc, -REST_S), shifted_utc(end_utc, REST_S))
    order = {**told, "datetime": "/".join(map(utc_text, around))}
    places = [*_positions(told["geometry"]["coordinates"])]
    corners = [[pick(place[way] for place in places) for way in (0, 1)] for pick in (min, max)]
    return OpportunityOut(
        type="Feature",
        id=f"{product_id}/{window['rise']}",
        geometry=told["geometry"],
        bbox=(corners[0][0], corners[0][1], corners[1][0], corners[1][1]),
        properties=OpportunityProperties(
            datetime=(begin_utc, end_utc),
            product_id=product_id,
            **{
                "view:off_nadir": closest["off_nadir_deg"],
                "view:incidence_angle": round(90.0 - closest["elevation_deg"], 6),
                "view:sun_elevation": closest["sun_elevation_deg"],
                "gsd": closest["ground_sample_along_m"],
                "session": window["session"],
                "probability_in_frame": window["probability_in_frame"],
            },
        ),
        links=[links.create_order(product_id, order)],
    )


def _positions(coordinates: Sequence[Any]) -> Iterator[Sequence[float]]:
    if not isinstance(coordinates[0], Sequence):
        yield coordinates
    else:
        for part in coordinates:
            yield from _positions(part)


class StandingOrder(NamedTuple):
    """An order and what became of it.

    passes: jobs of its plans.  unseen: the reason why nothing can be planned, by code and text.
    """

    job: Job
    passes: Sequence[Job]
    unseen: tuple[str, str] | None

    @property
    def made(self) -> list[Job]:
        return [one for one in self.passes if one.state == "done"]


def order_out(order: StandingOrder, links: Links) -> Order[OrderStatus]:
    asked, at = order.job.options["asked"], f"stapi/orders/{order.job.id}"
    start_utc, stop_utc = map(utc_from_text, asked["datetime"].split("/"))
    planned: dict[str, Any] = {}
    if made := order.made:
        likely = [one.probability_in_frame for one in made if one.probability_in_frame is not None]
        looks = [look for one in made for look in one.options["campaign"]["looks"]]
        planned = {"looks": looks, "probability_in_frame": min(likely, default=None)}
    return Order[OrderStatus](
        id=order.job.id,
        geometry=asked["geometry"],
        properties=OrderProperties[OrderStatus](
            product_id=order.job.options["product"],
            created=order.job.created_utc,
            status=statuses_of(order, links)[-1],
            search_parameters=OrderSearchParameters(
                datetime=(start_utc, stop_utc),
                geometry=asked["geometry"],
                filter=asked["filter"],
            ),
            opportunity_properties=planned,
            order_parameters=asked["order_parameters"],
        ),
        links=[
            links.to("self", at, GEOJSON),
            links.to("monitor", f"{at}/statuses"),
            links.to("campaign", f"v1/campaigns/{order.job.id}"),
            *(link for one in made for link in _links_of_plan(f"v1/plans/{one.id}", links)),
        ],
    )


def _links_of_plan(at: str, links: Links) -> Iterator[Link]:
    yield links.to("plan", at)
    for name, exporter in EXPORTERS.items():
        path = f"{at}/table?format={name}"
        yield links.to("table", path, exporter.media_type, title=exporter.title)


def statuses_of(order: StandingOrder, links: Links) -> list[OrderStatus]:
    """All that the order has had, in order of time."""
    at_utc, begun_utc, ended_utc = (
        getattr(order.job, f"{when}_utc") for when in ("created", "started", "finished")
    )
    found = [OrderStatus(timestamp=at_utc, status_code=OrderStatusCode.received)]
    if begun_utc is not None:  # the work, even before it is written down
        begun_utc = max(at_utc, begun_utc)
        found.append(OrderStatus(timestamp=begun_utc, status_code=OrderStatusCode.accepted))
    if ended_utc is not None:
        plans = [links.to("plan", f"v1/plans/{one.id}") for one in order.made]
        code, reason, text = _end(order)
        found.append(
            OrderStatus(
                timestamp=ended_utc,
                status_code=code,
                reason_code=reason,
                reason_text=text,
                links=plans,
            )
        )
    return found


def _end(order: StandingOrder) -> tuple[OrderStatusCode, str | None, str | None]:
    """The last status, and the reason's code and text."""
    jobs, code = (order.job, *order.passes), OrderStatusCode
    if order.made:
        return code.scheduled, None, None
    if order.unseen is not None:
        return code.rejected, *order.unseen
    if any(one.state == "cancelled" for one in jobs):
        return code.user_cancelled, None, None
    state, problem = next((one.state, one.problem) for one in jobs if one.problem is not None)
    assert problem is not None
    reason = problem["type"].removeprefix(TYPE_PREFIX)
    return code.rejected if state == "refused" else code.failed, reason, problem["detail"]
