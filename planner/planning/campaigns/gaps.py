"""The least gap between looks of a pass, kept by when the next target can be followed."""

import math

import numpy as np

from planner.base.arrays import Indices
from planner.planning.campaigns.network import NEVER, Network
from planner.planning.campaigns.platforms.follower import Follower
from planner.planning.campaigns.request import CampaignRequest


class Gaps:
    """Of one campaign: `conditions.min_gap_s` from the end of a look to the start of the next."""

    def __init__(self, request: CampaignRequest, follower: Follower, settle_steps: int) -> None:
        """settle_steps: of a target followed before its look begins, which count for the gap."""
        self._step_s, gap_s = request.step_s, request.conditions.min_gap_s
        # More than slews need is waited on the next target, or at rest before it.
        self._steps = max(math.ceil(gap_s / self._step_s - 1e-9) - settle_steps, 0)
        self.longest_s = max(follower.longest_slew_s, self._steps * self._step_s)
        # Half of it at either end of a pass, so that two have all of it between them.
        self.rest_s = max(follower.rest_s, 0.5 * gap_s)

    def keep(self, network: Network, least_steps: Indices) -> Network:
        """The same, no look's target followed sooner after another one.

        least_steps: (targets,), the shortest look.  Its reach is no less than the gap.
        """
        if not self._steps:
            return network
        arrival = network.arrival.copy()
        usable_to = network.last - least_steps[network.target]
        for way in range(len(network.way)):
            to = network.edge_to[network.edge_from[way] : network.edge_from[way + 1]]
            leave = np.arange(network.first[way], network.last[way] + 1)[:, None]
            begin = network.arrival_offset[way]
            arrivals = arrival[begin : begin + leave.size * to.size].reshape(leave.size, to.size)
            soonest = leave + self._steps
            cell = soonest + (network.offset - network.first)[to]
            late = np.where(soonest > usable_to[to], NEVER, np.maximum(arrivals, cell))
            arrivals[:] = np.where(arrivals == NEVER, NEVER, late)
        return network._replace(arrival=arrival)
