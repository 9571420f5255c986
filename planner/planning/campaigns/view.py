"""Quality of a target's view, from 0 to 1, by the user's weights."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Indices, angle_rad
from planner.planning.campaigns.platforms.follower import Follower
from planner.planning.campaigns.request import ViewWeights
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.sights import Sight, Wanted, in_sights
from planner.world.clouds import Clouds
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris

PROBABILITY_EVERY = 10  # samples; it changes by less than 0.02 in 20 s of a 400 km pass


@dataclass(frozen=True, kw_only=True, eq=False)
class ViewOverTime:
    """What is seen at n instants, each (n,).

    elevation_rad: of the carrier in the target's sky, above the limb for a target in space.
    plumb_m: the carrier's height over the target.  stretch_ratio: the longer side of a pixel on the
    ground over that straight below.  These two and sun_elevation_rad are NaN in space.
    """

    elevation_rad: Array
    off_nadir_rad: Array
    plumb_m: Array
    stretch_ratio: Array
    sun_elevation_rad: Array


@dataclass(frozen=True, kw_only=True)
class Seen:
    """One look's view at an instant.

    elevation_rad: of the carrier in the target's sky, above the limb for a target in space.
    ground_sample_m: the longer side of a pixel on the ground; this, off_nadir_rad and
    sun_elevation_rad are None for a target in space.  clear_probability: that no cloud stands over
    it; None where nothing is known of it.
    """

    elevation_rad: float
    off_nadir_rad: float | None
    ground_sample_m: float | None
    sun_elevation_rad: float | None
    probability_in_frame: float
    clear_probability: float | None


@dataclass(frozen=True, kw_only=True, eq=False)
class Viewing:
    """What views depend on, beside where the target is."""

    weights: ViewWeights
    ephemeris: Ephemeris
    follower: Follower
    clouds: Clouds | None = None

    def quality(self, sight: Sight, which: Indices, t_s: Array, breaks: Indices) -> Array:
        """Quality of the view of targets `which` (n,) at t_s (n,), between 0 and 1.

        breaks: the rows at which another target or pass begins.  The probability is found for
        some samples of each stretch_ratio, and linear between them.
        """
        weights = self.weights
        quality = np.ones(len(t_s))
        if sight.on_earth and sight.images:
            view = view_of(sight, which, t_s)
            sun = np.maximum(np.sin(view.sun_elevation_rad), 0.0)
            quality *= np.minimum(1.0 / view.stretch_ratio, 1.0) ** weights.ground_sample
            quality *= np.maximum(np.cos(view.off_nadir_rad), 0.0) ** weights.off_nadir
            quality *= sun**weights.sun
            clear = self._clear(sight, which, t_s)
            quality *= np.where(np.isnan(clear), 1.0, clear)
        if weights.probability > 0.0 and sight.images:
            every = np.arange(0, len(t_s), PROBABILITY_EVERY)
            rows = np.unique(np.concatenate([every, breaks, breaks[1:] - 1, [len(t_s) - 1]]))
            found = self.follower.probability(sight, which[rows], t_s[rows], self.ephemeris)
            quality *= np.interp(np.arange(len(t_s)), rows, found) ** weights.probability
        return quality

    def _clear(self, sight: Sight, which: Indices, t_s: Array) -> Array:
        """Probability that no cloud stands over targets, (n,), NaN where nothing is known of it."""
        if self.clouds is None or not (sight.on_earth and sight.images):
            return np.full(len(t_s), math.nan)
        instants = Instants(sight.carrier.start_utc, t_s)
        return self.clouds.clear_over(sight.r_target_itrf_m(which, t_s), instants)

    def seen(
        self,
        carrier: Carrier,
        targets: Sequence[Wanted],
        target: Indices,
        t_s: Array,
        pixel_rad: float,
    ) -> list[Seen]:
        """Views of observations of `target` (rows of targets) at t_s, (n,) each."""
        seen: list[Seen | None] = [None] * len(target)
        for rows, sight, which in in_sights(target, targets, carrier):
            view = view_of(sight, which, t_s[rows])
            probability = self.follower.probability(sight, which, t_s[rows], self.ephemeris)
            pixel_m = pixel_rad * view.plumb_m * view.stretch_ratio
            clear = self._clear(sight, which, t_s[rows])
            on_earth = sight.on_earth
            for n, row in enumerate(rows.tolist()):
                seen[row] = Seen(
                    elevation_rad=float(view.elevation_rad[n]),
                    off_nadir_rad=float(view.off_nadir_rad[n]) if on_earth else None,
                    ground_sample_m=float(pixel_m[n]) if on_earth else None,
                    sun_elevation_rad=float(view.sun_elevation_rad[n]) if on_earth else None,
                    probability_in_frame=float(probability[n]),
                    clear_probability=None if math.isnan(clear[n]) else float(clear[n]),
                )
        return [one for one in seen if one is not None]


def view_of(sight: Sight, which: Indices, t_s: Array) -> ViewOverTime:
    """Targets `which` (n,) at t_s (n,)."""
    seen = sight.sighting(which, t_s)
    plumb_m, r_sat_itrf_m = np.full(len(t_s), math.nan), sight.carrier.orbit.at(t_s)[:, :3]
    if sight.on_earth:
        plumb_m = geodetic_from_itrf(r_sat_itrf_m)[2]
        plumb_m = plumb_m - geodetic_from_itrf(sight.r_target_itrf_m(which, t_s))[2]
    return ViewOverTime(
        elevation_rad=seen.elevation_rad,
        off_nadir_rad=angle_rad(seen.direction_itrf, -r_sat_itrf_m),
        plumb_m=plumb_m,
        stretch_ratio=seen.range_m / (plumb_m * np.maximum(np.sin(seen.elevation_rad), 1e-6)),
        sun_elevation_rad=seen.sun_elevation_rad,
    )
