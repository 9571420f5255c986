"""A request for a campaign of several carriers, which share its targets."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from datetime import datetime
from functools import cached_property
from typing import Annotated

from pydantic import Field

from planner.base.assumed import Assumed
from planner.base.spec import Within, is_kept, spec
from planner.planning.campaigns.request import BOUNDS as CAMPAIGN_BOUNDS
from planner.planning.campaigns.request import CampaignRequest, CampaignTarget, ViewWeights
from planner.planning.campaigns.revision import Revision
from planner.planning.opportunities import OpportunityConditions
from planner.planning.opportunities.request import BOUNDS as OPPORTUNITY_BOUNDS
from planner.world.attitude import Attitude
from planner.world.clouds import Clouds
from planner.world.orbits import Orbit
from planner.world.platforms import PIXELS_ARCSEC, AngleDeg, AnyPlatform
from planner.world.scenario import SlewOptions
from planner.world.targets.terrain import Terrain


@dataclass(frozen=True, kw_only=True)
class FleetBounds:
    """What a campaign of several carriers may ask for."""

    carriers_max: int = 100  # each is searched for windows by itself, one after another


BOUNDS = FleetBounds()


@spec
class CampaignCarrier:
    """A platform in its orbit, one of several that a campaign chooses for.

    id: your name for it, different from the others'. E.g. `"north"`.
    attitude: attitude of the carrier that two axes stand on, its local orbital frame unless given;
    a body steers itself and has none.
    sensor: name of what it carries: targets that ask for a sensor are looked at by carriers with
    that one only. E.g. `"infrared"`.
    rest_angles_deg: angles at which two axes rest before, between and after passes, by axis; 0
    unless given. A body rests on its idle attitude. E.g. `{"alpha": 0.0, "beta": 0.0}`.
    slew: options of its slews between targets.
    pixel_arcsec: angle that a pixel covers, for the ground samples; unless given, that of the
    platform's camera. E.g. `0.68`.
    """

    id: str
    platform: AnyPlatform
    orbit: Orbit
    attitude: Attitude | None = None
    sensor: str | None = None
    rest_angles_deg: Mapping[str, AngleDeg] | None = None
    slew: SlewOptions = SlewOptions()
    pixel_arcsec: Annotated[float, Within(*PIXELS_ARCSEC)] | None = None

    def __post_init__(self) -> None:
        if not self.id:
            raise ValueError("id must not be empty: passes are reported by it")


# What is a carrier's own in a campaign of several, by the name it has in a campaign of one.
_OWN = frozenset(field.name for field in fields(CampaignCarrier)) - {"id", "sensor"}


@spec
class FleetRequest:
    """Several carriers, and targets to be looked at by any of them from `start` to `stop`.

    name: your name for it, shown in lists.
    carriers: those to choose for. A campaign of one has its members in their place.
    targets: the targets to choose from; each gets its looks from whichever carriers serve best.
    terrain: heights of the ground under targets that say none themselves; the requests of the
    passes have the heights instead of it.
    start: start of the campaign; UTC, rounded up to a command row. E.g. `"2015-02-27T12:00:00Z"`.
    stop: end of the campaign; UTC. E.g. `"2015-02-28T00:00:00Z"`.
    clouds: a forecast of clouds: a look is worth what it would be in a clear sky, times the
    probability of that, where the forecast says one.
    view: weights of the view's qualities in the worth of a look.
    step_s: looks begin on whole multiples of it after `start`; finer finds more and takes longer.
    revises: the campaign that this one revises: what flies soon stays, later looks are chosen anew.
    """

    name: str = ""
    carriers: Annotated[tuple[CampaignCarrier, ...], Field(max_length=BOUNDS.carriers_max)]
    targets: Annotated[tuple[CampaignTarget, ...], Field(max_length=OPPORTUNITY_BOUNDS.targets_max)]
    start: datetime
    stop: datetime
    terrain: Terrain | None = None
    conditions: OpportunityConditions = OpportunityConditions()
    clouds: Clouds | None = None
    view: ViewWeights = ViewWeights()
    step_s: Annotated[float, Within(*CAMPAIGN_BOUNDS.steps_s)] = CAMPAIGN_BOUNDS.step_s
    revises: Revision | None = None

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
        if self.conditions.duty_cycle is not None:
            raise ValueError(
                "conditions.duty_cycle must be left out of a campaign of several carriers, whose "
                "choice doesn't keep it; ask for a campaign of each by itself"
            )
        if self.revises is not None:
            self.revises.require(self.start, self.stop, self.conditions)
        asked = sum(one.counted_target_days for one in self.requests.values())
        if asked > CAMPAIGN_BOUNDS.target_days_max and not is_kept():
            raise ValueError(
                f"targets times days must not exceed {CAMPAIGN_BOUNDS.target_days_max:.0f}, "
                f"counted for each carrier that may look at them, which these {asked:.0f} do; ask "
                "for fewer at a time, or tell them apart by sensor"
            )

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
        for number, carrier in enumerate(self.carriers):
            rows = [
                row
                for row, wanted in enumerate(self.targets)
                if wanted.sensor in (None, carrier.sensor)
            ]
            if not rows:
                continue
            try:
                found[carrier.id] = CampaignRequest(
                    name=self.name,
                    targets=tuple(replace(self.targets[row], sensor=None) for row in rows),
                    start=self.start,
                    stop=self.stop,
                    terrain=self.terrain,
                    conditions=self.conditions,
                    clouds=self.clouds,
                    view=self.view,
                    step_s=self.step_s,
                    **{name: getattr(carrier, name) for name in _OWN},
                )
            except ValueError as error:
                raise ValueError(_as_asked(str(error), number, rows)) from None
        return found

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
