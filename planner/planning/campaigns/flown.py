"""A carrier's resources where a revision begins, after the passes that stay."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from planner.base.arrays import Array
from planner.base.errors import InvalidInput, ResourceRunsOut, figures
from planner.planning.campaigns.carrier_looks import first_utc
from planner.planning.campaigns.charging import CHARGING
from planner.planning.campaigns.chosen import KeptResource
from planner.planning.campaigns.platforms.registry import follower_of
from planner.planning.campaigns.request import CampaignRequest
from planner.planning.campaigns.revision import PassResources
from planner.planning.campaigns.stores import Curve, RestStores, Store, begun_with, held_of
from planner.world.frames.time_scales import elapsed_s, shifted_utc, utc_text
from planner.world.resources import Resources

LEVELS = {"battery": "battery_wh", "memory": "memory_gbit", "momentum": "momentum_n_m_s"}


def resources_left(request: CampaignRequest, anew: CampaignRequest, field: str) -> Resources | None:
    """What the carrier's resources hold where its looks are chosen anew.

    request: from whose start on they are followed, at rest and over passes that stay.  field: of
    the carrier's own, as refusals name them.
    Raises InvalidInput, and ResourceRunsOut where passes that stay take too much.
    """
    last_s = elapsed_s(anew.start, request.start)
    if request.resources is None or last_s < 1.0:
        return request.resources
    passes = list(_passes(request, anew))
    rest = _rest(replace(request, stop=anew.start, revises=None))
    told: dict[KeptResource, Array] = {}
    for store in rest.stores:
        if store.name == "duty_cycle":
            continue
        room = store.room([_stayed(store, *one) for one in passes])
        if (left := float(room.left_share.min())) < -CHARGING.known_share:
            at_utc = shifted_utc(request.start, float(room.t_s[np.argmin(room.left_share)]))
            raise ResourceRunsOut(
                f"the {store.name} passes its limit of {store.limit:g} {store.unit} over passes "
                f"that stay, by {figures(-left * store.capacity)} {store.unit} at "
                f"{utc_text(at_utc, 1)}; say anew what it begins with, or let less stay",
                field=f"{field}resources.{store.name}",
                limit=store.name,
                at_utc=at_utc,
            )
        told[store.name] = store.level(room.left_share[[0, -1]])[None]
    if rest.wheels is not None:
        told["momentum"] = rest.wheels.at_last(
            [
                rest.wheels.stayed(start_s, stop_s, held.momentum_n_m_s)
                for start_s, stop_s, held in passes
                if held.momentum_n_m_s is not None
            ]
        )
    return begun_with(request.resources, held_of(told, 0), end=1)


def _rest(request: CampaignRequest) -> RestStores:
    follower = follower_of(request)
    ephemeris = request.orbit.ephemeris(request.start, request.stop)
    start_state = None
    if request.initial_q_body_from_eci_xyzw is not None:
        at_s = elapsed_s(first_utc(request), request.start)
        start_state = at_s, follower.start_state(follower.carrier(ephemeris), at_s)[:10]
    return RestStores(request, follower, ephemeris, start_state)


def _passes(
    request: CampaignRequest, anew: CampaignRequest
) -> Iterator[tuple[float, float, PassResources]]:
    """Passes that stay and end after the start, when, and what each held at its ends."""
    assert request.resources is not None
    assert anew.revises is not None
    before_s = 0.0
    held_by = {(one.pass_start, one.pass_stop): one.pass_resources for one in anew.revises.looks}
    for (start, stop), held in sorted(held_by.items(), key=lambda one: one[0]):
        start_s, stop_s = (elapsed_s(at, request.start) for at in (start, stop))
        if stop_s <= 0.0 or start_s == stop_s:
            continue
        for name, level in LEVELS.items():
            if getattr(request.resources, name) and getattr(held, level, None) is None:
                raise InvalidInput(
                    f"must say pass_resources.{level} of the pass from {utc_text(start)}, which "
                    f"stays: revise a campaign that was chosen with the {name}, or let it stay no "
                    "more",
                    field="revises.looks",
                )
        if start_s < before_s:
            raise InvalidInput(
                f"has passes of one carrier at the same time, at {utc_text(start)}",
                field="revises.looks",
            )
        before_s = stop_s
        assert held is not None
        yield start_s, stop_s, held


def _stayed(store: Store, start_s: float, stop_s: float, held: PassResources) -> Curve:
    """What a pass uses of a resource that goes evenly from one level to the other; of one that
    began before the start, what is left of it."""
    first, last = getattr(held, LEVELS[store.name])
    rises = last - first if store.name == "battery" else first - last
    begin_s = max(start_s, 0.0)
    inside = (store.t_s > begin_s) & (store.t_s < stop_s)
    t_s = np.concatenate([[begin_s], store.t_s[inside], [stop_s]])
    came = store.came_by(t_s)
    rose = rises / store.capacity * (t_s - begin_s) / (stop_s - start_s)
    return Curve(t_s, came - came[0] - rose)
