"""Value, bound and processor time of campaigns as chosen.

Real OCO-3 targets and seeded ones beyond 559, the ISS, elevation of 30 deg, looks of 20 to
40 s, priorities 1 to 5.  Compared: the choice, its bound, taking pass after pass whatever is
best there (greedy), and what planners do by hand: by priority, the first window that is left.

    OMP_NUM_THREADS=1 python bench/campaign.py [--targets 200] [--days 1] [--step 2]
        [--sun 10] [--ground-sample 0] [--platform smallsat-120kg]

--sun: least elevation of the Sun.  --ground-sample: its weight in what a look is worth; without
it all views are worth the same, and the choice is hardest.  Times are of the processor.
"""

import argparse
import json
import os
import time
from collections import Counter
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np

from planner.planning.campaigns import (
    CampaignRequest,
    CampaignTarget,
    ViewWeights,
    choose_campaign,
)
from planner.planning.opportunities import OpportunityConditions
from planner.world.orbits import TleOrbit
from planner.world.platforms import BODIES, PLATFORMS
from planner.world.targets import GroundTarget

ROOT = Path(__file__).parent.parent
START = datetime(2015, 2, 27, tzinfo=UTC)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--targets", type=int, default=200)
    parser.add_argument("--days", type=float, default=1.0)
    parser.add_argument("--step", type=float, default=2.0)
    parser.add_argument("--looks", type=int, default=1)
    parser.add_argument("--sun", type=float, help="deg, the Sun's least elevation")
    parser.add_argument("--ground-sample", type=float, default=1.0, help="its weight")
    parser.add_argument("--platform", choices=[*PLATFORMS, *BODIES], default="iss-hrc")
    asked = parser.parse_args()
    request = campaign_request(asked.targets, asked.days, asked.step, asked.looks)
    request = replace(
        request,
        conditions=replace(request.conditions, sun_elevation_min_deg=asked.sun),
        view=ViewWeights(ground_sample=asked.ground_sample),
    )
    if asked.platform in BODIES:
        request = replace(request, platform=BODIES[asked.platform], rest_angles_deg=None)
    stages: dict[str, float] = {}
    last = ["", time.process_time()]

    def tell(stage: str, done: int, of: int, /, **_: float | None) -> None:
        now_s = time.process_time()
        stages[str(last[0])] = stages.get(str(last[0]), 0.0) + now_s - float(last[1])
        last[:] = [stage, now_s]

    began_s, began_wall_s = time.process_time(), time.monotonic()
    campaign = choose_campaign(request, tell)
    took_s, wall_s = time.process_time() - began_s, time.monotonic() - began_wall_s
    tell("", 0, 1)
    seen = [look for flight in campaign.passes for look in flight.looks]
    elevation_deg = np.rad2deg([one.elevation_rad for one in seen])
    print(
        f"{asked.targets} targets, {asked.days:g} days, {campaign.windows} windows: "
        f"{len(seen)} looks in {len(campaign.passes)} passes, value {campaign.value:.1f}, bound "
        f"{campaign.bound:.1f}, gap {campaign.gap_share:.2%}; greedy {campaign.greedy_value:.1f} "
        f"({campaign.value / campaign.greedy_value - 1.0:+.1%}); {took_s:.1f} s of the "
        f"processor, {wall_s:.1f} s on the clock at a load of {os.getloadavg()[0]:.1f}"
    )
    print(
        f"  half of the looks above {np.median(elevation_deg):.1f} deg and below "
        f"{np.median([one.ground_sample_m or np.nan for one in seen]):.2f} m; "
        f"{len(campaign.left_out)} left out, unseen by "
        f"{dict(Counter(one.closed_by for one in campaign.unseen))}"
    )
    print("  " + ", ".join(f"{name} {spent:.1f} s" for name, spent in stages.items() if name))


def campaign_request(targets: int, days: float, step_s: float, looks: int = 1) -> CampaignRequest:
    """Seeded priorities; the first targets are OCO-3's."""
    listed = json.loads((ROOT / "tests" / "data" / "oco3_targets.json").read_text())["targets"]
    orbit = json.loads((ROOT / "examples" / "las_vegas_2015.json").read_text())["orbit"]
    rng = np.random.default_rng(20150227)
    spread = max(targets - len(listed), 0)
    seeded = zip(
        np.rad2deg(np.arcsin(rng.uniform(-0.78, 0.78, spread))).tolist(),
        rng.uniform(-180.0, 180.0, spread).tolist(),
        strict=True,
    )
    places = [*((row[2], row[3]) for row in rng.permutation(np.array(listed, object))), *seeded]
    return CampaignRequest(
        orbit=TleOrbit(line1=orbit["line1"], line2=orbit["line2"]),
        platform=PLATFORMS["iss-hrc"],
        rest_angles_deg={"alpha": 0.0, "beta": 0.0},
        targets=tuple(
            CampaignTarget(
                id=str(number),
                target=GroundTarget(latitude_deg=latitude, longitude_deg=longitude),
                priority=float(rng.integers(1, 6)),
                session_s=40.0,
                min_session_s=20.0,
                looks=looks,
            )
            for number, (latitude, longitude) in enumerate(places[:targets])
        ),
        start=START,
        stop=START + timedelta(days=days),
        conditions=OpportunityConditions(min_elevation_deg=30.0),
        step_s=step_s,
    )


if __name__ == "__main__":
    main()
