"""A request for a campaign of several carriers, which share its targets."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Annotated

from pydantic import Field

from planner.base.assumed import Assumed
from planner.base.spec import is_kept, spec
from planner.planning.campaigns.request import CampaignCommon, CampaignRequest, CarrierCommon
from planner.world.conditions import DutyCycle


@dataclass(frozen=True, kw_only=True)
class FleetBounds:
    """What a campaign of several carriers may ask for."""

    carriers_max: int = 100  # each is searched for windows by itself
    target_days_max: float = 1_000_000.0  # counted for each carrier that may look at them
    large_target_days: float = 2000.0  # some ten seconds: then its carriers are searched apart
    # For each look that a target may have, of a fleet that sees it oftener.  Fewer leave a choice
    # less to give way with; more take memory, which grows with the looks near each other.
    kept_looks: int = 12


BOUNDS = FleetBounds()


def counted_target_days(requests: Iterable[CampaignRequest]) -> float:
    """Of all carriers together."""
    return sum(one.counted_target_days for one in requests)


def are_many(requests: Iterable[CampaignRequest]) -> bool:
    """Whether so many targets are looked at for so long that carriers are worth tasks."""
    return counted_target_days(requests) >= BOUNDS.large_target_days


@spec
class CampaignCarrier(CarrierCommon):
    """A platform in its orbit, one of several that a campaign chooses for.

    id: your name for it, different from the others'. E.g. `"north"`.
    sensor: name of what it carries: targets that ask for a sensor are looked at by carriers with
    that one only. E.g. `"infrared"`.
    duty_cycle: limit on its imaging in any span of time, in place of that of `conditions`.
    """

    id: str
    sensor: str | None = None
    duty_cycle: DutyCycle | None = None

    def __post_init__(self) -> None:
        if not self.id:
            raise ValueError("id must not be empty: passes are reported by it")


# What is a carrier's own in a campaign of several, by the name it has in a campaign of one.
_OWN = frozenset(field.name for field in fields(CarrierCommon))
_COMMON = frozenset(field.name for field in fields(CampaignCommon)) - {
    "targets",
    "conditions",
    "revises",
}


@spec
class FleetRequest(CampaignCommon):
    """Several carriers, and targets to be looked at by any of them from `start` to `stop`.

    carriers: those to choose for. A campaign of one has its members in their place.
    targets: the targets to choose from; each gets its looks from whichever carriers serve best.
    """

    carriers: Annotated[tuple[CampaignCarrier, ...], Field(max_length=BOUNDS.carriers_max)]

    def __post_init__(self) -> None:
        if not self.carriers:
            raise ValueError("carriers must hold at least one carrier")
        if not self.targets:
            raise ValueError("targets must hold at least one target")
        for of_what, ids in (
            ("carriers", [one.id for one in self.carriers]),
            ("targets", [one.id for one in self.targets]),
        ):
            taken: set[str] = set()
            for number, one in enumerate(ids):
                if one in taken:
                    raise ValueError(f"{of_what}.{number}.id {one!r} is taken already")
                taken.add(one)
        self._require_known_sensors()
        if self.revises is not None:
            self.revises.require(self.start, self.stop)
        asked = self.counted_target_days
        if asked > BOUNDS.target_days_max and not is_kept():
            raise ValueError(
                f"targets times days must not exceed {BOUNDS.target_days_max:.0f}, "
                f"counted for each carrier that may look at them, which these {asked:.0f} do; ask "
                "for fewer at a time, or tell them apart by sensor"
            )

    @property
    def counted_target_days(self) -> float:
        """As of a campaign of one, of all carriers."""
        return counted_target_days(self.requests.values())

    @property
    def is_large(self) -> bool:
        """Whether it pays to find the looks of its carriers apart."""
        return are_many(self.requests.values())

    def _require_known_sensors(self) -> None:
        sensors = {one.sensor for one in self.carriers} - {None}
        for number, wanted in enumerate(self.targets):
            if wanted.sensor is not None and wanted.sensor not in sensors:
                known = ", ".join(sorted(filter(None, sensors))) or "none"
                raise ValueError(
                    f"targets.{number}.sensor {wanted.sensor!r} is no carrier's; carriers have "
                    f"{known}"
                )

    @cached_property
    def requests(self) -> Mapping[str, CampaignRequest]:
        """The same for each carrier with targets by itself, by its id.

        Raises ValueError with the field at fault, as this request has it.
        """
        found = {}
        plain = [
            one if one.sensor is None else replace(one, sensor=None) for one in self.targets
        ]  # once, as building them takes longer than all else here
        for number, carrier in enumerate(self.carriers):
            rows = [
                row
                for row, wanted in enumerate(self.targets)
                if wanted.sensor in (None, carrier.sensor)
            ]
            if not rows:
                continue
            try:
                duty_cycle = carrier.duty_cycle or self.conditions.duty_cycle
                found[carrier.id] = CampaignRequest(
                    targets=tuple(plain[row] for row in rows),
                    conditions=replace(self.conditions, duty_cycle=duty_cycle),
                    **{name: getattr(self, name) for name in _COMMON},
                    **{name: getattr(carrier, name) for name in _OWN},
                )
            except ValueError as error:
                raise ValueError(_as_asked(str(error), number, rows)) from None
        return found

    def field_of(self, carrier: str, field: str) -> str:
        """A field of a carrier's, as this request has it."""
        return f"carriers.{[one.id for one in self.carriers].index(carrier)}.{field}"

    @property
    def carrier_ids(self) -> frozenset[str]:
        """Of all carriers, those without a target, too."""
        return frozenset(one.id for one in self.carriers)

    @property
    def platform_names(self) -> str:
        """Each once."""
        return ", ".join(dict.fromkeys(one.platform.name for one in self.carriers))

    @property
    def assumed(self) -> tuple[Assumed, ...]:
        """Where the targets are that are given by name."""
        looked_up = (
            wanted.target.assumed(f"targets.{number}.target")
            for number, wanted in enumerate(self.targets)
        )
        return tuple(one for one in looked_up if one is not None)


def _as_asked(detail: str, carrier: int, rows: list[int]) -> str:
    """A refusal of one carrier's request, its field as the request of all has it."""
    head, *rest = detail.split(" ")[0].rstrip(":").split(".")
    if head in _OWN:
        return f"carriers.{carrier}.{detail}"
    if head == "targets" and rest and rest[0].isdecimal():
        return detail.replace(f"targets.{rest[0]}.", f"targets.{rows[int(rest[0])]}.", 1)
    return detail
