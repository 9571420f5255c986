"""Quality of a target's view, from 0 to 1, by the user's weights."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Indices, angle_rad
from planner.motion.pointing.angles import axis_angles
from planner.motion.pointing.line_of_sight import LineOfSight
from planner.planning.campaigns.request import ViewWeights
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.sights import Sight, in_sights
from planner.planning.sessions.platforms.two_axis.budget import probabilities_at
from planner.world.attitude import AttitudeLaw
from planner.world.frames.geodesy import geodetic_from_itrf
from planner.world.frames.time_scales import Instants
from planner.world.orbits import Ephemeris
from planner.world.platforms import TwoAxisPlatform
from planner.world.targets import Target, VisibleTarget
from planner.world.targets.earth_fixed import EarthFixedTarget

PROBABILITY_EVERY = 10  # samples; it changes by less than 0.02 in 20 s of a 400 km pass
_DELTA_S = 1.0


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
    sun_elevation_rad are None for a target in space.
    """

    elevation_rad: float
    off_nadir_rad: float | None
    ground_sample_m: float | None
    sun_elevation_rad: float | None
    probability_in_frame: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Viewing:
    """What views depend on, beside where the target is."""

    weights: ViewWeights
    ephemeris: Ephemeris
    attitude: AttitudeLaw
    platform: TwoAxisPlatform

    def quality(self, sight: Sight, which: Indices, t_s: Array, breaks: Indices) -> Array:
        """Quality of the view of targets `which` (n,) at t_s (n,), between 0 and 1.

        breaks: the rows at which another target or pass begins.  The probability is found for
        some samples of each stretch_ratio, and linear between them.
        """
        weights = self.weights
        quality = np.ones(len(t_s))
        if sight.on_earth:
            view = view_of(sight, which, t_s)
            sun = np.maximum(np.sin(view.sun_elevation_rad), 0.0)
            quality *= np.minimum(1.0 / view.stretch_ratio, 1.0) ** weights.ground_sample
            quality *= np.maximum(np.cos(view.off_nadir_rad), 0.0) ** weights.off_nadir
            quality *= sun**weights.sun
        if weights.probability > 0.0:
            every = np.arange(0, len(t_s), PROBABILITY_EVERY)
            rows = np.unique(np.concatenate([every, breaks, breaks[1:] - 1, [len(t_s) - 1]]))
            found = self.probability(sight, which[rows], t_s[rows])
            quality *= np.interp(np.arange(len(t_s)), rows, found) ** weights.probability
        return quality

    def probability(self, sight: Sight, which: Indices, t_s: Array) -> Array:
        """That each target is in the frame, (n,); 0 where no angles point there."""
        carrier = sight.carrier
        before, seen, after = (
            sight.sighting(which, at_s) for at_s in (t_s - _DELTA_S, t_s, t_s + _DELTA_S)
        )
        los_platform = seen.los_platform
        angle_rad = axis_angles(self.platform, los_platform).angle_rad[0]
        rows = np.flatnonzero(np.isfinite(angle_rad).all(axis=1))
        if not len(rows):
            return np.zeros(len(t_s))
        los_rate_per_s = (after.los_platform - before.los_platform) / (2.0 * _DELTA_S)
        instants = Instants(carrier.start_utc, t_s[rows])
        los = LineOfSight(
            instants=instants,
            states=self.ephemeris.states(instants),
            los_platform=los_platform[rows],
            los_rate_platform_per_s=los_rate_per_s[rows],
            los_acceleration_platform_per_s2=np.full((len(rows), 3), math.nan),
            range_m=seen.range_m[rows],
            clearance_rad=seen.elevation_rad[rows],
        )
        probability = np.zeros(len(t_s))
        probability[rows] = probabilities_at(
            los,
            self.ephemeris,
            self.attitude,
            _target_of(sight, which[rows]),
            self.platform,
            angle_rad[rows],
        )
        return probability

    def seen(
        self,
        carrier: Carrier,
        targets: Sequence[Target],
        target: Indices,
        t_s: Array,
        pixel_rad: float,
    ) -> list[Seen]:
        """Views of observations of `target` (rows of targets) at t_s, (n,) each."""
        seen: list[Seen | None] = [None] * len(target)
        for rows, sight, which in in_sights(target, targets, carrier):
            view = view_of(sight, which, t_s[rows])
            probability = self.probability(sight, which, t_s[rows])
            pixel_m = pixel_rad * view.plumb_m * view.stretch_ratio
            on_earth = sight.on_earth
            for n, row in enumerate(rows.tolist()):
                seen[row] = Seen(
                    elevation_rad=float(view.elevation_rad[n]),
                    off_nadir_rad=float(view.off_nadir_rad[n]) if on_earth else None,
                    ground_sample_m=float(pixel_m[n]) if on_earth else None,
                    sun_elevation_rad=float(view.sun_elevation_rad[n]) if on_earth else None,
                    probability_in_frame=float(probability[n]),
                )
        return [one for one in seen if one is not None]


def view_of(sight: Sight, which: Indices, t_s: Array) -> ViewOverTime:
    """Targets `which` (n,) at t_s (n,)."""
    seen = sight.sighting(which, t_s)
    plumb_m = np.full(len(t_s), math.nan)
    if sight.on_earth:
        plumb_m = geodetic_from_itrf(sight.carrier.r_sat_itrf_m.at(t_s))[2]
        plumb_m = plumb_m - geodetic_from_itrf(sight.r_target_itrf_m(which, t_s))[2]
    return ViewOverTime(
        elevation_rad=seen.elevation_rad,
        off_nadir_rad=angle_rad(seen.direction_itrf, -sight.carrier.r_sat_itrf_m.at(t_s)),
        plumb_m=plumb_m,
        stretch_ratio=seen.range_m / (plumb_m * np.maximum(np.sin(seen.elevation_rad), 1e-6)),
        sun_elevation_rad=seen.sun_elevation_rad,
    )


def _target_of(sight: Sight, which: Indices) -> VisibleTarget:
    """Rows of `which` as one target, a place per instant."""
    if not sight.on_earth:
        return sight.targets[0]
    if sight.places.step_s == 0.0:
        return _Places(sight.places.resting_parameters[which, :3])
    return sight.targets[0]


class _Places(EarthFixedTarget):
    """A place at rest for each instant, whose number may be asked for several times over."""

    min_elevation_deg = 0.0
    refraction = "none"

    def __init__(self, r_itrf_m: Array) -> None:
        self._r_itrf_m = r_itrf_m

    def r_target_itrf_m(self, instants: Instants) -> Array:
        """Shape (n, 3)."""
        return np.tile(self._r_itrf_m, (len(instants) // len(self._r_itrf_m), 1))
