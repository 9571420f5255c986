"""The margin by which each condition of a request is met."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.interpolation import UniformTable
from planner.motion.pointing.angles import axis_angles
from planner.planning.opportunities.carrier import Carrier
from planner.planning.opportunities.masks import TURN_RAD as MASK_TURN_RAD
from planner.planning.opportunities.masks import Direction, clear_of, nodes_beside
from planner.planning.opportunities.request import OpportunityConditions
from planner.planning.opportunities.sights import EarthSight, Sight
from planner.planning.opportunities.spans import Margin, Nodes
from planner.planning.opportunities.windows import Cause
from planner.world.platforms import TwoAxisPlatform
from planner.world.targets.apparent import aberrate
from planner.world.targets.earth_limb import limb_clearance_rad

HIDDEN_RAD = math.radians(1.5)  # below the limb: refraction lifts by 1.1 deg, half a disk is 0.3
SUN_STEP_S = 600.0  # 2.5 deg of the Earth's turn
NEVER_RAD = -math.pi
TURN_RAD = 2.0 * math.pi
TURN_MAX_RAD = math.radians(10.0)  # between nodes; a keep-out or stop is met at its own pace


@dataclass(frozen=True, eq=False)
class Condition:
    """A margin to be kept, and how closely it must be looked at.

    step_s: longest time between nodes.  turn_rad: greatest turn of the line of sight.
    more_nodes: adds nodes where these don't tell.
    """

    cause: Cause
    margin: Margin
    step_s: float
    turn_rad: float
    more_nodes: Callable[[Nodes], Nodes] | None = None


def conditions_of(
    conditions: OpportunityConditions, platform: TwoAxisPlatform, sight: Sight
) -> Iterator[Condition]:
    """What narrows the time a target is in sight; the cheap and the selective first."""
    carrier = sight.carrier
    orbit_step_s = float(carrier.node_s[1])
    on_earth = isinstance(sight, EarthSight)
    if on_earth and not (
        conditions.sun_elevation_min_deg is conditions.sun_elevation_max_deg is None
    ):
        yield Condition("sun_elevation", _sunlight_margin(conditions, sight), SUN_STEP_S, math.inf)

    def turning_condition(cause: Cause, margin: Margin) -> Condition:
        return Condition(cause, margin, orbit_step_s, TURN_MAX_RAD)

    def los_itrf(which: Indices, t_s: Array) -> Array:
        return sight.sighting(which, t_s).direction_itrf

    def los_platform(which: Indices, t_s: Array) -> Array:
        return carrier.in_platform(los_itrf(which, t_s), t_s)

    if on_earth and conditions.max_off_nadir_deg is not None:
        limit_rad = math.radians(conditions.max_off_nadir_deg)

        def off_nadir(which: Indices, t_s: Array) -> Array:
            return limit_rad - off_nadir_rad(los_itrf(which, t_s), carrier, t_s)

        yield turning_condition("off_nadir", off_nadir)
    bodies: tuple[tuple[Cause, float | None, UniformTable], ...] = (
        ("sun_keep_out", conditions.sun_keep_out_deg, carrier.r_sun_itrf_m),
        ("moon_keep_out", conditions.moon_keep_out_deg, carrier.r_moon_itrf_m),
    )
    for cause, keep_out_deg, r_body_itrf_m in bodies:
        if keep_out_deg is not None:
            yield turning_condition(cause, _keep_out(keep_out_deg, r_body_itrf_m, sight))
    yield turning_condition("reach", _reach_margin(platform, los_platform))
    if platform.masks:
        yield _clear_of_masks(platform, carrier, los_platform, orbit_step_s)


def _reach_margin(platform: TwoAxisPlatform, los_platform: Direction) -> Margin:
    def margin_rad(which: Indices, t_s: Array) -> Array:
        angle_rad = axis_angles(platform, los_platform(which, t_s)).angle_rad
        return np.asarray(reach_margin_rad(platform, angle_rad).max(axis=0))

    return margin_rad


def _clear_of_masks(
    platform: TwoAxisPlatform, carrier: Carrier, los_platform: Direction, longest_s: float
) -> Condition:
    margin = clear_of(platform.masks, los_platform)
    return Condition(
        cause="mask",
        margin=margin,
        step_s=min(longest_s, MASK_TURN_RAD / carrier.platform_turn_max_rad_s),
        turn_rad=MASK_TURN_RAD,
        more_nodes=lambda nodes: nodes_beside(nodes, margin, los_platform),
    )


def reach_margin_rad(platform: TwoAxisPlatform, angle_rad: Array) -> Array:
    """How far from the nearest stop each way of pointing is, shape (2, n).

    angle_rad: (2, n, 2) as from `axis_angles`, NaN where unreachable.
    """
    from_middle = np.abs(within_stops(platform, angle_rad) - _middle_rad(platform))
    reach = np.array([0.5 * (a.angle_max_rad - a.angle_min_rad) for a in platform.axis_limits])
    margin = np.minimum(reach[0] - from_middle[..., 0], reach[1] - from_middle[..., 1])
    return np.where(np.isnan(margin), NEVER_RAD, margin)


def within_stops(platform: TwoAxisPlatform, angle_rad: Array) -> Array:
    """Angles, shape (..., 2), whole turns away, as near as can be to mid-travel."""
    middle_rad = _middle_rad(platform)
    return angle_rad - TURN_RAD * np.round((angle_rad - middle_rad) / TURN_RAD)


def _middle_rad(platform: TwoAxisPlatform) -> Array:
    return np.array([0.5 * (a.angle_min_rad + a.angle_max_rad) for a in platform.axis_limits])


def separation_rad(
    direction_itrf: Array, r_body_itrf_m: UniformTable, carrier: Carrier, t_s: Array
) -> Array:
    """Angle at the carrier between unit vectors (n, 3) and a body's centre, (n,)."""
    return angle_rad(direction_itrf, _body_direction(r_body_itrf_m, carrier, t_s))


def off_nadir_rad(direction_itrf: Array, carrier: Carrier, t_s: Array) -> Array:
    """Angle of unit vectors (n, 3) from the geocentre's direction, (n,)."""
    return angle_rad(direction_itrf, -carrier.r_sat_itrf_m.at(t_s))


def angle_rad(direction: Array, other_direction: Array) -> Array:
    """Between vectors (n, 3) of any length, accurate near 0 and pi too."""
    across = np.linalg.norm(np.cross(direction, other_direction), axis=1)
    return np.asarray(np.arctan2(across, np.einsum("nj,nj->n", direction, other_direction)))


def _body_direction(r_body_itrf_m: UniformTable, carrier: Carrier, t_s: Array) -> Array:
    """Where the moving carrier sees a body, unit vectors (n, 3)."""
    to_body_m = r_body_itrf_m.at(t_s) - carrier.r_sat_itrf_m.at(t_s)
    direction = to_body_m / np.linalg.norm(to_body_m, axis=1, keepdims=True)
    return aberrate(direction, carrier.v_sat_itrf_m_s.at(t_s))


def _sunlight_margin(conditions: OpportunityConditions, sight: Sight) -> Margin:
    low_deg, high_deg = conditions.sun_elevation_min_deg, conditions.sun_elevation_max_deg
    low_rad = -math.inf if low_deg is None else math.radians(low_deg)
    high_rad = math.inf if high_deg is None else math.radians(high_deg)

    def margin_rad(which: Indices, t_s: Array) -> Array:
        elevation_rad = sight.sun_elevation_rad(which, t_s)
        return np.asarray(np.minimum(elevation_rad - low_rad, high_rad - elevation_rad))

    return margin_rad


def _keep_out(keep_out_deg: float, r_body_itrf_m: UniformTable, sight: Sight) -> Margin:
    def margin_rad(which: Indices, t_s: Array) -> Array:
        body = _body_direction(r_body_itrf_m, sight.carrier, t_s)
        away_rad = angle_rad(sight.sighting(which, t_s).direction_itrf, body)
        above_limb_rad = limb_clearance_rad(body, sight.carrier.r_sat_itrf_m.at(t_s), 0.0)
        return np.maximum(away_rad - math.radians(keep_out_deg), -HIDDEN_RAD - above_limb_rad)

    return margin_rad
