"""Of the looks of a large fleet at a target the best ones; of the others what they are worth."""

import pickle
from collections.abc import Iterable, Mapping, Sequence
from datetime import timedelta
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices, Mask, rank_among
from planner.base.reporting import tell_nobody
from planner.planning.campaigns import fleet
from planner.planning.campaigns.carrier_looks import (
    CarrierLooks,
    CarrierWindows,
    windows_of_carrier,
)
from planner.planning.campaigns.request import CampaignRequest


class BestViews(NamedTuple):
    """How well one carrier's looks can see, as what is to be kept asks; goes through pickle.

    ids: of each candidate the target's that may look less often, None where all looks stay.
    most: (candidates,), how many looks it may have.  candidate, quality: of each look, (looks,);
    -1 where it can't be followed.
    """

    ids: Sequence[str | None]
    most: Indices
    candidate: Indices
    quality: Array


class KeptLooks(NamedTuple):
    """Of one carrier: whether each look is kept, (looks,), and the quality of the best of all
    carriers' that is not, (candidates,)."""

    kept: Mask
    spare_quality: Array


class SeenByCarrier(NamedTuple):
    """What one carrier tells of its looks before some are kept.

    packed_windows: its `CarrierWindows`.
    """

    views: BestViews
    packed_windows: bytes


def seen_by_carrier(request: CampaignRequest) -> SeenByCarrier:
    """Of a carrier by itself; raises OutsideCoverage."""
    windows = windows_of_carrier(request, modes_by_pass=True)
    return SeenByCarrier(best_views(windows), pickle.dumps(windows))


def kept_of_carrier(
    request: CampaignRequest, packed_windows: bytes, kept: KeptLooks
) -> CarrierLooks:
    """The looks that are kept, of what `seen_by_carrier` told."""
    windows: CarrierWindows = pickle.loads(packed_windows)  # noqa: S301 (our own)
    return windows.completed(request).with_looks(tell_nobody, *kept)


def sees_often(requests: Mapping[str, CampaignRequest]) -> bool:
    """Whether so many carriers look at so many targets that some looks at each are enough."""
    days = [(one.stop - one.start) / timedelta(days=1) for one in requests.values()]
    return fleet.are_many(requests.values()) and sum(days) > fleet.BOUNDS.kept_looks


def best_views(windows: CarrierWindows) -> BestViews:
    """Of all looks, by following each."""
    ways, quality = windows.ways_to(), np.full(len(windows.looks.target), -1.0)
    if len(ways.look):
        np.maximum.at(quality, ways.look, np.maximum.reduceat(ways.quality, ways.offset))
    return BestViews(
        ids=[
            one.wanted.id if not one.scans and one.wanted.group is None else None
            for one in windows.candidates
        ],
        most=np.array([one.looks for one in windows.candidates], np.intp),
        candidate=windows.looks.target,
        quality=quality,
    )


def looks_to_keep(views: Iterable[BestViews]) -> list[KeptLooks]:
    """Of each carrier in turn; the earlier carrier's where views are as good."""
    views = list(views)
    names = dict.fromkeys(name for one in views for name in one.ids if name is not None)
    number = {name: n for n, name in enumerate(names)} | {None: -1}
    numbers = [np.array([number[name] for name in one.ids], np.intp) for one in views]
    target = np.concatenate([own[one.candidate] for own, one in zip(numbers, views, strict=True)])
    most = np.concatenate([one.most[one.candidate] for one in views])
    quality = np.concatenate([one.quality for one in views])
    rank = rank_among(target, quality)
    kept = (target < 0) | ((rank < fleet.BOUNDS.kept_looks * most) & (quality >= 0.0))
    spare_quality = np.zeros(len(names) + 1)  # the last of those of which all looks stay
    np.maximum.at(spare_quality, target[~kept], quality[~kept])
    ends = np.cumsum([len(one.candidate) for one in views])
    return [
        KeptLooks(own_kept, spare_quality[own])
        for own_kept, own in zip(np.split(kept, ends[:-1]), numbers, strict=True)
    ]
