"""A campaign's choice as answers tell it: its worth and bound, and the share of each carrier."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from planner.base.answer_members import Count, NotNegative, Share
from planner.base.assumed import Assumed
from planner.planning.campaigns.chosen import UnchosenByAll, UnchosenTarget, UnseenByAll
from planner.planning.campaigns.fleet import FleetRequest
from planner.planning.campaigns.request import CampaignRequest
from planner.planning.campaigns.revision import RevisionFound
from planner.planning.opportunities.closing import Unseen

if TYPE_CHECKING:
    from planner.planning.campaigns.campaign import Campaign


@dataclass(frozen=True, kw_only=True)
class CampaignChoiceOut:
    """The worth of the looks chosen together, and the most that it could be.

    value: of the looks chosen. E.g. `5.94`.
    bound: no choice is worth more whose looks begin on the grid of `step_s`, have one of the
    lengths tried (least, wanted, half-way) and lie in the same passes. E.g. `6.0`.
    gap_share: the difference between bound and `value`, as a share of the bound. E.g. `0.01`.
    greedy_value: worth of the choice that takes whatever is worth most in each pass, one pass after
    another. E.g. `5.1`.
    windows: number of windows to choose from. E.g. `12`.
    looks: number of looks chosen. E.g. `6`.
    passes: number of passes that hold looks. E.g. `4`.
    unseen: targets that can't be looked at for as long as they must, and why.
    left_out: targets that can, but others are worth more.
    assumed: places of the targets that the request gives by name only.
    warnings: cautions to read before relying on it. E.g.
    `["the elements' epoch 2015-02-27T11:40:53Z is 9.0 days from the farthest instant asked for"]`.
    revision: of a campaign that revises another: the looks that stay, beside those that all else
    here tells of, and what became of each target; null of others.
    """

    value: NotNegative
    bound: NotNegative
    gap_share: Share
    greedy_value: NotNegative
    windows: Count
    looks: Count
    passes: Count
    unseen: tuple[Unseen, ...]
    left_out: tuple[UnchosenTarget, ...]
    assumed: tuple[Assumed, ...]
    warnings: tuple[str, ...]
    revision: RevisionFound | None = None


@dataclass(frozen=True, kw_only=True)
class CarrierOut:
    """The share of one of several carriers.

    id: its name in the request. E.g. `"north"`.
    passes: number of its passes that hold looks. E.g. `2`.
    looks: number of looks chosen for it. E.g. `5`.
    value: of these. E.g. `7.25`.
    """

    id: str
    passes: Count
    looks: Count
    value: NotNegative


@dataclass(frozen=True, kw_only=True)
class FleetChoiceOut(CampaignChoiceOut):
    """The worth of the looks chosen for several carriers, and the most that it could be.

    unseen: targets that no carrier can look at for as long as it must, and why not the one that
    comes nearest.
    left_out: targets that some carrier can, but others are worth more.
    carriers: the share of each, in the request's order.
    """

    unseen: tuple[UnseenByAll, ...]
    left_out: tuple[UnchosenByAll, ...]
    carriers: tuple[CarrierOut, ...]


def told_of(request: CampaignRequest | FleetRequest, campaign: "Campaign") -> CampaignChoiceOut:
    told = CampaignChoiceOut(
        value=campaign.value,
        bound=campaign.bound,
        gap_share=campaign.gap_share,
        greedy_value=campaign.greedy_value,
        windows=campaign.windows,
        looks=sum(len(flight.looks) for flight in campaign.passes),
        passes=len(campaign.passes),
        unseen=campaign.unseen,
        left_out=campaign.left_out,
        assumed=request.assumed,
        warnings=campaign.warnings,
        revision=campaign.revision,
    )
    if not isinstance(request, FleetRequest):
        return told
    carriers = []
    for carrier in request.carriers:
        own = [flight.looks for flight in campaign.passes if flight.carrier == carrier.id]
        value = sum((look.value for looks in own for look in looks), 0.0)
        looks = sum(map(len, own))
        carriers.append(CarrierOut(id=carrier.id, passes=len(own), looks=looks, value=value))
    return FleetChoiceOut(**vars(told), carriers=tuple(carriers))
