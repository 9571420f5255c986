"""Looks of a fleet's carriers, found apart by several processes."""

import io
import pickle
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from planner.base.at_once import done_at_once
from planner.base.reporting import tell_nobody
from planner.planning.campaigns.fleet import FleetRequest
from planner.planning.campaigns.request import CampaignRequest

if TYPE_CHECKING:
    from planner.planning.campaigns.carrier_looks import CarrierLooks


def carriers_apart(
    request: CampaignRequest | FleetRequest, found: Sequence[bytes] = ()
) -> Sequence[bytes]:
    """What `find_looks` is given of each carrier; nothing where all are soon found, or found.

    found: of what was given before, by carrier.  A fleet that sees its targets often finds first
    how well each carrier sees, and then the looks that are kept.
    """
    from planner.planning.campaigns import fewer_looks, looks_of_carrier, requests_to_choose

    if found and not _is_first_round(found):
        return ()
    if not isinstance(request, FleetRequest) or not request.is_large:
        return ()
    requests = requests_to_choose(request)
    if len(requests) < 2:
        return ()
    if not found:
        is_often = fewer_looks.sees_often(requests)
        all_looks = partial(looks_of_carrier, tell=tell_nobody, modes_by_pass=True)
        find = fewer_looks.seen_by_carrier if is_often else all_looks
        return _packed(find, requests, [()] * len(requests))
    seen = dict(map(_unpacked, found))
    kept = fewer_looks.looks_to_keep([one.views for one in seen.values()])
    own = zip((one.packed_windows for one in seen.values()), kept, strict=True)
    return _packed(fewer_looks.kept_of_carrier, {one: requests[one] for one in seen}, own)


def _is_first_round(found: Sequence[bytes]) -> bool:
    from planner.planning.campaigns.fewer_looks import SeenByCarrier

    return isinstance(_unpacked(found[0])[1], SeenByCarrier)


class _Packer(pickle.Pickler):
    """Of what one carrier needs; the targets, which carriers share, are packed by themselves."""

    def __init__(self, file: io.BytesIO, common: Sequence[object]) -> None:
        super().__init__(file)
        self._common = {id(one): number for number, one in enumerate(common)}

    def persistent_id(self, obj: object) -> int | None:
        return self._common.get(id(obj))


class _Unpacker(pickle.Unpickler):
    """Of what `_Packer` packed."""

    def __init__(self, packed: bytes, common: bytes) -> None:
        super().__init__(io.BytesIO(packed))
        self._common = pickle.loads(common)  # noqa: S301 (our own)

    def persistent_load(self, pid: int) -> object:
        return self._common[pid]


def _packed(
    find: Callable[..., object],
    requests: Mapping[str, CampaignRequest],
    more: Iterable[tuple[object, ...]],
) -> list[bytes]:
    """What to find of each carrier, of its request and more."""
    given = []
    packed: dict[tuple[int, ...], bytes] = {}
    for (carrier, request), others in zip(requests.items(), more, strict=True):
        common = request.targets, request.opportunities().targets
        same = tuple(map(id, request.targets))
        if same not in packed:
            packed[same] = pickle.dumps(common)
        own = io.BytesIO()
        _Packer(own, common).dump((carrier, find, (request, *others)))
        given.append(pickle.dumps((own.getvalue(), packed[same])))
    return given


def find_looks(given: bytes) -> bytes:
    """Of one carrier, by `carriers_apart`; raises a Refusal."""
    carrier, find, arguments = _Unpacker(*pickle.loads(given)).load()  # noqa: S301 (our own)
    return zlib.compress(pickle.dumps((carrier, find(*arguments))), 1)


def looks_found(found: Sequence[bytes]) -> Mapping[str, "CarrierLooks"]:
    """Of each carrier, after the last round."""
    return dict(done_at_once(_unpacked, found))


def _unpacked(found: bytes) -> tuple[str, Any]:
    told: tuple[str, Any] = pickle.loads(zlib.decompress(found))  # noqa: S301 (our own)
    return told
