"""STAPI: products of an operator's carriers, their opportunities, and orders of looks.

An order is a campaign of one target, kept and planned as any.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from http import HTTPStatus
from typing import Annotated, Any, Literal, NamedTuple

import anyio.to_thread
from fastapi import APIRouter, Depends, HTTPException, Query, Request, Response
from pydantic import BaseModel, Field
from sqlalchemy import Connection
from stapi_pydantic import (
    Conformance,
    Link,
    Opportunity,
    OpportunityCollection,
    OpportunityProperties,
    Order,
    OrderCollection,
    OrderProperties,
    OrderSearchParameters,
    OrderStatus,
    OrderStatusCode,
    OrderStatuses,
    Product,
    ProductsCollection,
    RootResponse,
)
from stapi_pydantic.constants import STAPI_VERSION

from app.answers.problem import TYPE_PREFIX
from app.http.blocking import database_of, read
from app.http.negotiation import JSON, ONLY_JSON, answers, json_body
from app.http.openapi.fields import describe
from app.http.routes.job_routes import JobResource
from app.http.routes.opportunities import OPPORTUNITIES
from app.http.routes.parameters import LIST_MAX, IdempotencyKey, Parameters, PathId
from app.ids import is_id
from app.jobs.kinds import ORDER
from app.requests.campaign import CAMPAIGN_READER
from app.requests.stapi import (
    GEOMETRIES,
    ORDER_READER,
    PARAMETERS_READER,
    QUERYABLES,
    SEARCH_READER,
    AskedOrder,
    LookParameters,
    OfferedProduct,
    StapiProduct,
    StapiProducts,
    StapiSearch,
)
from app.store import jobs, results
from app.store.job import Job
from app.store.packed import unzip
from app.work.searches import GEOJSON, PROBABILITY, VIEW, WindowsAsked, listing_of_search
from planner.base.errors import InvalidInput
from planner.output.export import EXPORTERS
from planner.world.frames.time_scales import shifted_utc, utc_from_text, utc_text

REST_S = 600.0  # for the way to an opportunity's looks and back
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


ORDERS = JobResource(
    kind=ORDER.name,
    path="/stapi/orders",
    tag="stapi",
    requests=CAMPAIGN_READER,
    examples={},
    listing=listing_of_search,
    singular="order",
    plural="orders",
    response=Order,
    list_response=OrderCollection,
)
# STAPI's specification describes it, and the API's own document doesn't hang on a setting.
router = APIRouter(prefix="/stapi", include_in_schema=False)


def _links(request: Request) -> Links:
    service, _ = request.app.state.stapi
    return Links(service.url or str(request.base_url))


def _product(request: Request, product_id: str) -> OfferedProduct:
    _, products = request.app.state.stapi
    if product_id not in products:
        known = ", ".join(products)
        detail = f"there is no product with this id; there are {known}"
        raise HTTPException(HTTPStatus.NOT_FOUND, detail)
    found: OfferedProduct = products[product_id]
    return found


class PageQuery(Parameters):
    """Which to list: so many, from the one that `next` of the page before names."""

    limit: int = Field(default=10, ge=1, le=LIST_MAX)
    next: str = Field(default="", max_length=64)


To = Annotated[Links, Depends(_links)]
Found = Annotated[OfferedProduct, Depends(_product)]
Body = Annotated[bytes, Depends(json_body)]
Page = Annotated[PageQuery, Query()]
AS_GEOJSON = answers(GEOJSON, JSON)


def _json(model: BaseModel, media_type: str = JSON, **answer: Any) -> Response:  # noqa: ANN401 (of a Response)
    content = model.model_dump_json(by_alias=True, exclude_none=True)
    return Response(content, media_type=media_type, **answer)


@router.get("", dependencies=ONLY_JSON)
@router.get("/", dependencies=ONLY_JSON)
async def get_landing_page(request: Request, to: To) -> Response:
    service: StapiProducts = request.app.state.stapi[0]
    below = [to.to(one, f"stapi/{one}") for one in ("conformance", "products")]
    links = [to.to("self", "stapi"), *below, to.to("orders", "stapi/orders", GEOJSON)]
    links.append(to.to("service-doc", "docs", "text/html"))
    told = {"title": service.title, "description": service.description}
    return _json(RootResponse(id="slewtrack", conformsTo=CONFORMS_TO, links=links, **told))


@router.get("/conformance", dependencies=ONLY_JSON)
async def get_conformance() -> Response:
    return _json(Conformance(conforms_to=CONFORMS_TO))


@router.get("/products", dependencies=ONLY_JSON)
async def get_products(request: Request, page: Page, to: To) -> Response:
    """A page begins with the product that `next` names."""
    products: list[OfferedProduct] = [*request.app.state.stapi[1].values()]
    first = products.index(_product(request, page.next)) if page.next else 0
    shown, after = products[first:][: page.limit], products[first:][page.limit :]
    links = [to.to("self", "stapi/products")]
    if after:
        rest = f"stapi/products?next={after[0].spec.id}&limit={page.limit}"
        links.append(to.to("next", rest))
    listed = [product_out(one.spec, to) for one in shown]
    return _json(ProductsCollection(products=listed, links=links))


@router.get("/products/{product_id}", dependencies=ONLY_JSON)
async def get_product(found: Found, to: To) -> Response:
    return _json(product_out(found.spec, to))


@router.get("/products/{product_id}/conformance", dependencies=ONLY_JSON)
async def get_product_conformance(found: Found) -> Response:
    return _json(Conformance(conforms_to=PRODUCT_CONFORMS_TO))


@router.get("/products/{product_id}/queryables", dependencies=ONLY_JSON)
async def get_queryables(found: Found) -> dict[str, Any]:
    """A JSON Schema of what a filter may bound."""
    told = {name: {"type": "number", "description": one.text} for name, one in QUERYABLES.items()}
    return {"type": "object", "title": "Queryables", "properties": told}


@router.get("/products/{product_id}/order-parameters", dependencies=ONLY_JSON)
async def get_order_parameters(found: Found) -> dict[str, Any]:
    """A JSON Schema of what an order may say beside its place and its time."""
    schema = PARAMETERS_READER.json_schema("#/$defs/{model}")
    describe({LookParameters.__name__: schema}, [LookParameters])
    return schema


@router.post("/products/{product_id}/opportunities", dependencies=AS_GEOJSON)
async def post_opportunities(request: Request, found: Found, body: Body, to: To) -> Response:
    """Windows that hold the order's look, kept as any search; a page begins where `next` says."""

    def as_read() -> tuple[StapiSearch, AskedOrder]:
        search = SEARCH_READER.read(body)
        return search, found.asked(search)

    search, asked = await anyio.to_thread.run_sync(as_read)
    search_id, _, cursor = (search.next or ":0").partition(":")
    if not (cursor.isdecimal() and len(cursor) < 10 and (is_id(search_id) or not search.next)):
        raise InvalidInput("must be `next` of the page before", field="next")
    of_windows, include = found.search_body(asked), frozenset({VIEW, PROBABILITY})
    wanted = WindowsAsked(cursor=int(cursor), limit=search.limit, include=include)
    if search.next:
        whole = await OPPORTUNITIES.find_kept(request, search_id, wanted)
        if hashlib.sha256(whole.body).digest() != hashlib.sha256(of_windows).digest():
            raise InvalidInput("belongs to another search: leave it out", field="next")
        page = await whole.page(request, wanted.cursor)
    else:
        spec = await anyio.to_thread.run_sync(OPPORTUNITIES.requests.read, of_windows)
        whole, page = await OPPORTUNITIES.find_and_keep(request, spec, of_windows, wanted)
    product_id, windows = found.spec.id, json.loads(b"[" + page.windows + b"]")
    links = [to.create_order(product_id, asked.told)]
    links.append(to.to("search", f"v1/opportunities/{whole.search_id}"))
    if page.next is not None:
        at = f"stapi/products/{product_id}/opportunities"
        after = {"next": f"{whole.search_id}:{page.next}", "limit": search.limit}
        links.append(to.to("next", at, GEOJSON, method="POST", body=asked.told | after))
    told: list[Any] = [opportunity_out(one, product_id, asked.told, to) for one in windows]
    return _json(
        OpportunityCollection(type="FeatureCollection", features=told, links=links), GEOJSON
    )


@router.post("/products/{product_id}/orders", dependencies=AS_GEOJSON)
async def post_order(
    request: Request, found: Found, body: Body, key: IdempotencyKey, to: To
) -> Response:
    """Accepted, it is kept and planned, whatever dies in between."""

    def accepted() -> Job:
        asked = found.asked(ORDER_READER.read(body))
        options = {"product": found.spec.id, "asked": asked.told}
        return ORDERS.accept(request, asked.campaign, asked.body, key, options=options)

    job = await database_of(request).answer(accepted)
    at = {"Location": str(to.to("self", f"stapi/orders/{job.id}").href)}
    return _json(await _order(request, job.id, to), GEOJSON, status_code=201, headers=at)


def _standing(connection: Connection, job: Job) -> StandingOrder:
    passes, unseen = jobs.parts_of(connection, job.id), None
    if job.state == "done" and not passes:
        choice = json.loads(unzip(results.document(connection, job.id) or b""))
        [one] = choice["unseen"]
        unseen = (one["closed_by"], one["because"])
    return StandingOrder(job, passes, unseen)


async def _order(request: Request, order_id: str, to: Links) -> Order[OrderStatus]:
    """Raises 404."""

    def reading(connection: Connection) -> Order[OrderStatus]:
        return order_out(_standing(connection, ORDERS.job_of(connection, order_id)), to)

    return await read(request, reading)


@router.get("/orders", dependencies=AS_GEOJSON)
async def get_orders(request: Request, page: Page, to: To) -> Response:
    """The latest first; a page begins after the order that `next` names."""

    def reading(connection: Connection) -> list[Order[OrderStatus]]:
        before, limit = page.next or None, page.limit + 1
        found = jobs.latest(connection, ORDERS.kind, limit, before=before)
        return [order_out(_standing(connection, one), to) for one in found]

    orders, links = await read(request, reading), [to.to("self", "stapi/orders", GEOJSON)]
    if len(orders) > page.limit:
        rest = f"stapi/orders?next={orders[page.limit - 1].id}&limit={page.limit}"
        links.append(to.to("next", rest, GEOJSON))
    return _json(OrderCollection(features=orders[: page.limit], links=links), GEOJSON)


@router.get("/orders/{id}", dependencies=AS_GEOJSON)
async def get_order(request: Request, order_id: PathId, to: To) -> Response:
    return _json(await _order(request, order_id, to), GEOJSON)


@router.get("/orders/{id}/statuses", dependencies=ONLY_JSON)
async def get_statuses(request: Request, order_id: PathId, page: Page, to: To) -> Response:
    """Three at most, so that there is one page."""

    def reading(connection: Connection) -> list[OrderStatus]:
        return statuses_of(_standing(connection, ORDERS.job_of(connection, order_id)), to)

    links = [to.to("self", f"stapi/orders/{order_id}/statuses")]
    return _json(OrderStatuses(statuses=await read(request, reading), links=links))
