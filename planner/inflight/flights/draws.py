"""Draws of one disturbed flight: how far each cause is off, in its own sigmas.

Each run has a generator of its own (Philox, keyed by the seed and the run's number), so that a
run is the same whoever flies it and whichever runs are flown beside it.
Source: Salmon et al. 2011, Parallel random numbers: as easy as 1, 2, 3.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from planner.base.arrays import Array
from planner.inflight.simulation.platforms.flyer import ATTITUDE, CLOCK, EARTH, ORBIT


@dataclass(frozen=True, kw_only=True, eq=False)
class Draw:
    """One run's errors, each of unit variance.

    orbit_scores: radial, along and across the track, (3,), the second carried onto that error's
    own distribution.  attitude_scores: of each mode or body axis.
    phase_rad: of the swing about each body axis, (3,); swing_share: 1, or 0 for none.
    seeds: of what happens in the flight itself, by cause.
    """

    orbit_scores: Array
    attitude_scores: Array
    phase_rad: Array
    swing_share: float
    earth_score: float
    clock_score: float
    seeds: Mapping[str, int]

    def with_cause_of(self, other: "Draw", cause: str) -> "Draw":
        """The same run, but for one cause as the other has it."""
        if cause in self.seeds:
            return replace(self, seeds={**self.seeds, cause: other.seeds[cause]})
        return replace(self, **{name: getattr(other, name) for name in _MEMBERS[cause]})


_MEMBERS = {
    ORBIT: ("orbit_scores",),
    ATTITUDE: ("attitude_scores", "phase_rad", "swing_share"),
    EARTH: ("earth_score",),
    CLOCK: ("clock_score",),
}


def draw_run(seed: int, run: int, modes: int, flown_causes: Sequence[str]) -> Draw:
    """The errors of one run; modes: independent turns of the base's attitude."""
    random = np.random.Generator(np.random.Philox(key=[seed, run]))
    orbit, earth_and_clock = random.standard_normal(3), random.standard_normal(2)
    return Draw(
        orbit_scores=orbit,
        phase_rad=random.uniform(0.0, 2.0 * np.pi, 3),
        swing_share=1.0,
        earth_score=float(earth_and_clock[0]),
        clock_score=float(earth_and_clock[1]),
        seeds={cause: int(random.integers(2**32)) for cause in flown_causes},
        attitude_scores=random.standard_normal(modes),  # last: their number hangs on the request
    )


def undisturbed(modes: int) -> Draw:
    """Everything as the plan has it."""
    return Draw(
        orbit_scores=np.zeros(3),
        attitude_scores=np.zeros(modes),
        phase_rad=np.zeros(3),
        swing_share=0.0,
        earth_score=0.0,
        clock_score=0.0,
        seeds={},
    )
