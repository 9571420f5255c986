"""Ways to hold sessions that cost the same are chosen by their order, not by rounding."""

import json

import pytest
from plausible_requests import plausible_request

from app.requests.plan import read_plan_request
from planner.planning.sessions.pipeline import make_plan
from planner.planning.sessions.platforms.two_axis.mover import TwoAxisMover


@pytest.mark.parametrize("share", [1.0 - 1e-13, 1.0, 1.0 + 1e-13])
def test_an_axis_that_waits_is_not_turned_round_for_the_last_digit(monkeypatch, share):
    """Of seed 1032 alpha's slew takes longest, whichever whole turn beta goes to: by 15 or by 345
    deg, which a sum's last digit decided."""
    least_s = TwoAxisMover.least_s

    def otherwise_rounded(mover, start, end):
        turned = abs(end[1].angle_rad - start[1].angle_rad) > 3.2
        return least_s(mover, start, end) * (share if turned else 1.0)

    monkeypatch.setattr(TwoAxisMover, "least_s", otherwise_rounded)
    request = plausible_request(1032, sessions_max=3)
    plan = make_plan(read_plan_request(json.dumps(request).encode()))
    assert abs(plan.table.position[310, 1] - plan.table.position[0, 1]) < 0.3
