"""The public benchmark stereo_imaging: pairs and triples of looks by a fleet, with a bound.

Some ten satellites with real TLEs, 120 to 140 areas in 48 h, by daylight, scalar agility, a cone
about nadir.  An area counts by its best pair or triple of looks: by their convergence, common
ground and resolution.  Ranked are the share of areas covered, then the mean quality.

    python bench/stereo_imaging.py [CASE [OUT.json]]

CASE: a folder with mission.yaml, satellites.yaml and targets.yaml; without, the small one of our
tests.  OUT.json: the solution, in the benchmark's own format.  Windows, orbits and frames are
slewtrack's.  From each window some looks are taken; pairs and triples of them that are worth most
are put together by an integer programme, in which an area counts once and looks with no slew
between exclude each other.  The bound is what each area is worth with no other in the way.

Where the benchmark's text leaves it open, we do as its published verifier does: steering is about
the velocity over the ground and the direction to the Earth's centre; footprints lie on the
ellipsoid, told along the radius through the area; the geometry's quality falls by a tenth a
degree outside the preferred convergence; every valid triple has its whole bonus.  Common ground is
estimated there from a hundred random points: a product is worth what is to be expected of that.
Source: Mtrya, astro-reason (MIT), benchmarks/stereo_imaging.
"""

import json
import math
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import yaml
from aeossp import OFF_NADIR_MARGIN_DEG, stage_clock
from agility import Agility, slew_s
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_array
from scipy.stats import binom

from planner.base.arrays import Array, Indices, Mask
from planner.planning.opportunities import (
    OpportunityConditions,
    OpportunityRequest,
    OpportunityTarget,
    find_opportunities,
)
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S
from planner.world.frames.geodesy import WGS84_A_M, WGS84_B_M, itrf_from_geodetic
from planner.world.frames.time_scales import Instants
from planner.world.orbits import TleOrbit
from planner.world.platforms import BODIES
from planner.world.targets import GroundTarget

SMALL = Path(__file__).parents[1] / "tests" / "data" / "stereo_small"
ELLIPSOID_M = np.array([WGS84_A_M, WGS84_A_M, WGS84_B_M])
PREFERRED_DEG = {
    "urban_structured": (8.0, 18.0),
    "vegetated": (8.0, 14.0),
    "rugged": (10.0, 20.0),
    "open": (15.0, 25.0),
}
SUN_MARGIN_DEG = 0.2  # between the verticals of the ellipsoid and of the Earth's centre
SLEW_MARGIN_S = 0.05  # of the frames' difference
ANCHOR_MARGIN_DEG = 0.02  # off nadir to the ellipsoid, and to the area above it
LOOKS_A_WINDOW = 24  # 5 s apart, in which convergence changes by 3 deg
POINTS = 1024  # of an area, evenly spread
FALLS_OVER_DEG = 10.0  # the geometry's quality, outside the preferred convergence
WINDOWS_MOST = 1_000_000  # of a satellite: theirs are numbered apart
DRAWN = 100  # at random by the benchmark
PAIRS_TRIED = 200  # the best of an area, for a third look
KEPT = 4  # products of the same windows
DOUBTED = 0.01  # of estimates that fall short, from which on a product has a spare
NODES = 50  # of the programme, the same on every machine; here it ends at its root


class Satellite(NamedTuple):
    """told: of the case's file."""

    told: dict[str, Any]
    orbit: TleOrbit
    agility: Agility

    @property
    def pixel_rad(self) -> float:
        return math.radians(self.told["pixel_ifov_deg"])


@dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """rules: of the mission.  Of areas: ids, scenes, targets, r_itrf_m (n, 3), radius_m (n,)."""

    start_utc: datetime
    stop_utc: datetime
    rules: dict[str, Any]
    satellites: Sequence[Satellite]
    ids: Sequence[str]
    scenes: Sequence[str]
    targets: Sequence[GroundTarget]
    r_itrf_m: Array
    radius_m: Array


class Looks(NamedTuple):
    """Of each look its target, satellite and window, (n,); scale_m of a pixel.

    view_itrf: unit vectors from the area at the middle; begins_itrf and ends_itrf: along the
    boresight, (n, 3).  steering_deg: along and across, (n, 2).  is_covered: which points of the
    area, (n, POINTS).
    """

    target: Indices
    satellite: Indices
    window: Indices
    begin_s: Array
    stop_s: Array
    scale_m: Array
    view_itrf: Array
    begins_itrf: Array
    ends_itrf: Array
    steering_deg: Array
    is_covered: Mask

    def of(self, rows: Indices) -> "Looks":
        return Looks(*(one[rows] for one in self))


class Products(NamedTuple):
    """looks: two or three of each, (n, 3), the third of a pair -1.  quality, and how likely it is
    that the product is valid: as expected, (n,)."""

    looks: Indices
    target: Indices
    quality: Array
    likely: Array


def read_case(folder: Path) -> Case:
    """The case's files."""
    mission, satellites, areas = (
        yaml.load((folder / f"{name}.yaml").read_text(), yaml.CSafeLoader)
        for name in ("mission", "satellites", "targets")
    )
    rules = mission["mission"]
    targets = [
        GroundTarget(
            latitude_deg=one["latitude_deg"],
            longitude_deg=one["longitude_deg"],
            height_m=one["elevation_ref_m"],
        )
        for one in areas
    ]
    latitude_deg, longitude_deg, height_m = np.array(
        [(one.latitude_deg, one.longitude_deg, one.height_m) for one in targets]
    ).T
    return Case(
        start_utc=datetime.fromisoformat(rules["horizon_start"]),
        stop_utc=datetime.fromisoformat(rules["horizon_end"]),
        rules=rules,
        satellites=[_satellite(one) for one in satellites],
        ids=[one["id"] for one in areas],
        scenes=[one["scene_type"] for one in areas],
        targets=targets,
        r_itrf_m=itrf_from_geodetic(np.radians(latitude_deg), np.radians(longitude_deg), height_m),
        radius_m=np.array([float(one["aoi_radius_m"]) for one in areas]),
    )


def _satellite(told: dict[str, Any]) -> Satellite:
    orbit = TleOrbit(line1=told["tle_line1"], line2=told["tle_line2"])
    return Satellite(told, orbit, Agility.told(told))


def looks_of(case: Case) -> Looks:
    """From every window some, the first and the last among them, area after area."""
    found = [_looks(case, number) for number in range(len(case.satellites))]
    looks = Looks(*map(np.concatenate, zip(*found, strict=True)))
    return looks.of(np.argsort(looks.target, kind="stable"))


def _looks(case: Case, number: int) -> Looks:
    satellite = case.satellites[number]
    sun_deg = case.rules["validity_thresholds"]["min_solar_elevation_deg"] + SUN_MARGIN_DEG
    windows = find_opportunities(
        OpportunityRequest(
            platform=BODIES["agile-cmg"],  # leans farther and turns faster than all of these
            orbit=satellite.orbit,
            start=case.start_utc,
            stop=case.stop_utc,
            targets=tuple(
                OpportunityTarget(id=name, target=target)
                for name, target in zip(case.ids, case.targets, strict=True)
            ),
            conditions=OpportunityConditions(
                max_off_nadir_deg=satellite.told["max_off_nadir_deg"] - OFF_NADIR_MARGIN_DEG,
                sun_elevation_min_deg=sun_deg,
            ),
        )
    ).windows
    first_s, last_s = np.ceil(windows.rise_s), np.floor(windows.set_s)
    r_m, v_m_s = _states(case, satellite, 0.5 * (first_s + last_s))
    aim_m = case.r_itrf_m[windows.target]
    tangent = math.tan(0.5 * satellite.told["cross_track_pixels"] * satellite.pixel_rad)
    # As long as it takes for the strip's ends to leave the area.
    share = np.linalg.norm(aim_m, axis=1) / np.linalg.norm(r_m, axis=1)
    width_m = (1.0 - share) * np.linalg.norm(r_m, axis=1) * tangent
    half_m = np.sqrt(np.maximum(case.radius_m[windows.target] ** 2 - width_m**2, 0.0))
    needs_s = 2.0 * half_m / (share * np.linalg.norm(v_m_s, axis=1))
    least_s, most_s = (satellite.told[f"{end}_obs_duration_s"] for end in ("min", "max"))
    lasts_s = np.ceil(np.clip(needs_s, least_s, math.floor(most_s)))
    told = [
        (row, begin_s)
        for row in np.flatnonzero(last_s - first_s >= lasts_s).tolist()
        for begin_s in np.unique(
            np.rint(np.linspace(first_s[row], last_s[row] - lasts_s[row], LOOKS_A_WINDOW))
        ).tolist()
    ]
    row = np.array([one for one, _ in told], np.intp)
    begin_s = np.array([one for _, one in told])
    stop_s, aim_m, target = begin_s + lasts_s[row], aim_m[row], windows.target[row]
    r_m, v_m_s = _states(case, satellite, 0.5 * (begin_s + stop_s))
    axes = _axes(r_m, v_m_s)
    foot_m = aim_m / np.linalg.norm(aim_m / ELLIPSOID_M, axis=1)[:, None]
    steering = np.einsum("kij,kj->ki", axes, foot_m - r_m)
    slopes = steering[:, :2] / steering[:, 2:]
    slant_m = np.linalg.norm(foot_m - r_m, axis=1)
    view_m = r_m - aim_m
    boresights, strip_m = [], []
    for t_s in (begin_s, stop_s):
        at_m, rate_m_s = _states(case, satellite, t_s)
        los = np.einsum("kij,ki->kj", _axes(at_m, rate_m_s), np.insert(slopes, 2, 1.0, axis=1))
        boresights.append(los / np.linalg.norm(los, axis=1)[:, None])
        strip_m.append(_foot_m(at_m, boresights[-1]))
    return Looks(
        target=target,
        satellite=np.full(len(row), number),
        window=number * WINDOWS_MOST + row,
        begin_s=begin_s,
        stop_s=stop_s,
        scale_m=slant_m * satellite.pixel_rad,
        view_itrf=view_m / np.linalg.norm(view_m, axis=1)[:, None],
        begins_itrf=boresights[0],
        ends_itrf=boresights[1],
        steering_deg=np.degrees(np.arctan(slopes)),
        is_covered=_covered(aim_m, case.radius_m[target], *strip_m, slant_m * tangent),
    )


def _states(case: Case, satellite: Satellite, t_s: Array) -> tuple[Array, Array]:
    """Positions, and velocities over the turning ground, in ITRF."""
    ephemeris = satellite.orbit.ephemeris(case.start_utc, case.stop_utc)
    r_m, v_m_s = ephemeris.states_in_itrf_axes(Instants(case.start_utc, t_s))
    return r_m, v_m_s - OMEGA_EARTH_RAD_S * np.cross([0.0, 0.0, 1.0], r_m)


def _axes(r_m: Array, v_m_s: Array) -> Array:
    """Along, across and down, rows of (n, 3, 3)."""
    down = -r_m / np.linalg.norm(r_m, axis=1)[:, None]
    along = v_m_s - np.einsum("ki,ki->k", v_m_s, down)[:, None] * down
    along /= np.linalg.norm(along, axis=1)[:, None]
    return np.stack([along, np.cross(along, down), down], axis=1)


def _foot_m(r_m: Array, los: Array) -> Array:
    """Where lines of sight first meet the ellipsoid; within such cones they all do."""
    r, d = r_m / ELLIPSOID_M, los / ELLIPSOID_M
    a, b = np.einsum("ki,ki->k", d, d), np.einsum("ki,ki->k", r, d)
    c = np.einsum("ki,ki->k", r, r) - 1.0
    return r_m + ((-b - np.sqrt(b**2 - a * c)) / a)[:, None] * los


def _covered(
    aim_m: Array, radius_m: Array, from_m: Array, to_m: Array, half_width_m: Array
) -> Mask:
    """Which points of areas lie within a strip's half width of its middle line."""
    up = aim_m / np.linalg.norm(aim_m, axis=1)[:, None]
    east = np.cross([0.0, 0.0, 1.0], up)
    east /= np.linalg.norm(east, axis=1)[:, None]
    flat = np.stack([east, np.cross(up, east)], axis=1)
    begin, end = (np.einsum("kij,kj->ki", flat, one - aim_m) for one in (from_m, to_m))
    place = np.arange(POINTS)
    turn, spread = place * math.pi * (3.0 - math.sqrt(5.0)), np.sqrt((place + 0.5) / POINTS)
    unit = np.stack([spread * np.cos(turn), spread * np.sin(turn)])
    way = end - begin
    found = np.empty((len(aim_m), POINTS), np.bool_)
    for k in range(len(found)):
        from_begin = radius_m[k] * unit - begin[k][:, None]
        share = np.clip(way[k] @ from_begin / (way[k] @ way[k]), 0.0, 1.0)
        off = from_begin - share * way[k][:, None]
        found[k] = np.einsum("ij,ij->j", off, off) <= half_width_m[k] ** 2
    return found


def products_of(case: Case, looks: Looks) -> Products:
    """Pairs and triples worth most of every area, from all sets of its windows."""
    found = [Products(np.empty((0, 3), np.intp), np.empty(0, np.intp), np.empty(0), np.empty(0))]
    for target in np.unique(looks.target).tolist():
        rows = np.flatnonzero(looks.target == target)
        one = _products(case, target, looks.of(rows))
        found.append(one._replace(looks=np.where(one.looks < 0, -1, rows[one.looks])))
    return Products(*map(np.concatenate, zip(*found, strict=True)))


def _products(case: Case, target: int, looks: Looks) -> Products:
    rules = case.rules["validity_thresholds"]
    weights = case.rules["quality_model"]["pair_weights"]
    bonus = case.rules["quality_model"]["tri_stereo_bonus_by_scene"][case.scenes[target]]
    middle_s = 0.5 * (looks.begin_s + looks.stop_s)
    apart_s = np.abs(middle_s[:, None] - middle_s)
    is_own = looks.satellite[:, None] == looks.satellite
    together = (looks.window[:, None] == looks.window) & ~_exclude(case, looks)
    together |= ~is_own & bool(case.rules["allow_cross_satellite_stereo"])
    together &= apart_s <= case.rules["max_stereo_pair_separation_s"]
    cosine = np.clip(looks.view_itrf @ looks.view_itrf.T, -1.0, 1.0)
    turn_deg = np.degrees(np.arccos(cosine))
    ratio = looks.scale_m[:, None] / looks.scale_m
    ratio = np.maximum(ratio, ratio.T)
    is_pair = together & (turn_deg >= rules["min_convergence_deg"])
    is_pair &= turn_deg <= rules["max_convergence_deg"]
    is_pair &= ratio <= rules["max_pixel_scale_ratio"]
    low, high = PREFERRED_DEG[case.scenes[target]]
    outside_deg = np.maximum(np.maximum(low - turn_deg, turn_deg - high), 0.0)
    covered = looks.is_covered.astype(np.float32)
    least = rules["min_overlap_fraction"]
    likely, overlap = _estimated(least, covered @ covered.T / POINTS)
    likely *= is_pair
    sharp = weights["geometry"] * np.maximum(1.0 - outside_deg / FALLS_OVER_DEG, 0.0)
    sharp += weights["resolution"] * np.maximum(1.0 - (ratio - 1.0) / 0.5, 0.0)
    quality = likely * sharp + is_pair * weights["overlap"] * overlap
    first, second = np.nonzero(np.triu(likely > DOUBTED))
    best = np.argsort(-quality[first, second], kind="stable")
    first, second = first[best], second[best]
    # Third looks to the best pairs.
    i, j = first[:PAIRS_TRIED, None], second[:PAIRS_TRIED, None]
    k = np.arange(len(looks.target))[None, :]
    a, b, c = likely[i, j], likely[i, k], likely[j, k]
    off_nadir_deg = np.degrees(np.arctan(np.hypot(*np.tan(np.radians(looks.steering_deg)).T)))
    near = rules["near_nadir_anchor_max_off_nadir_deg"] - ANCHOR_MARGIN_DEG
    sure, _ = _estimated(least, (covered[i[:, 0]] * covered[j[:, 0]]) @ covered.T / POINTS)
    sure *= a * b + a * c + b * c - 2.0 * a * b * c  # two of the three are valid
    sure *= together[i, k] & together[j, k]
    sure *= np.minimum(np.minimum(off_nadir_deg[i], off_nadir_deg[j]), off_nadir_deg[k]) <= near
    pair = np.maximum(np.maximum(quality[i, j], quality[i, k]), quality[j, k])
    if_valid = quality / np.maximum(likely, DOUBTED)
    top = np.maximum(np.maximum(if_valid[i, j], if_valid[i, k]), if_valid[j, k])
    worth = sure * np.minimum(1.0, top + bonus) + (1.0 - sure) * pair
    row, third = np.nonzero(sure > DOUBTED)
    pairs = np.column_stack([first, second, np.full(len(first), -1)])
    chosen = np.concatenate([pairs, np.column_stack([first[row], second[row], third])])
    value = np.concatenate([quality[first, second], worth[row, third]])
    valid = np.concatenate([likely[first, second], np.maximum(a, sure)[row, third]])
    keep = _best_of_each(looks, chosen, value)
    return Products(chosen[keep], np.full(len(keep), target), value[keep], valid[keep])


def _estimated(least: float, share: Array) -> tuple[Array, Array]:
    """How likely an estimate of common ground reaches the least, and the quality it then adds."""
    known, drawn = np.linspace(0.0, 1.0, 501), np.arange(DRAWN + 1)
    odds = binom.pmf(drawn, DRAWN, known[:, None]) * (drawn >= least * DRAWN)
    quality = odds @ np.minimum(drawn / DRAWN / 0.95, 1.0)
    return np.interp(share, known, odds.sum(axis=1)), np.interp(share, known, quality)


def _best_of_each(looks: Looks, chosen: Indices, value: Array) -> Indices:
    """Some worth most of each set of windows; of equals any, so that they spread over these."""
    chosen = np.sort(chosen, axis=1)
    windows = np.sort(np.where(chosen < 0, -1, looks.window[chosen]), axis=1)
    _, once = np.unique(chosen, axis=0, return_index=True)
    kind = np.unique(windows[once], axis=0, return_inverse=True)[1].reshape(-1)
    lot = np.random.default_rng(0).permutation(len(once))
    order = np.lexsort((lot, -np.round(value[once], 4), kind))
    place = np.arange(len(order)) - np.searchsorted(kind[order], kind[order])
    return np.asarray(once[order[place < KEPT]])


def _exclude(case: Case, looks: Looks) -> Mask:
    """Which looks have no slew between, being one satellite's, (n, n)."""
    found = np.zeros((len(looks.target), len(looks.target)), np.bool_)
    for number in np.unique(looks.satellite).tolist():
        agility, own = case.satellites[number].agility, np.flatnonzero(looks.satellite == number)
        some = looks.of(own)
        spare_s = some.begin_s - some.stop_s[:, None] - agility.settle_s - SLEW_MARGIN_S
        is_late = spare_s < slew_s(180.0, agility)
        i, j = np.nonzero(is_late & (spare_s > 0.0))
        cosine = np.einsum("ki,ki->k", some.ends_itrf[i], some.begins_itrf[j])
        angle_deg = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        is_late[i, j] = spare_s[i, j] < [slew_s(one, agility) for one in angle_deg.tolist()]
        found[np.ix_(own, own)] = is_late & is_late.T
    return found


class Used(NamedTuple):
    """Looks that some product takes.

    rows: among all looks, (u,).  takes: which of them each product takes, (products, u).  is_out:
    which have no slew between, (u, u).
    """

    rows: Indices
    takes: Mask
    is_out: Mask


def used_by(case: Case, looks: Looks, products: Products) -> Used:
    """Of all products."""
    rows = np.unique(products.looks[products.looks >= 0])
    takes = np.zeros((len(products.target), len(rows)), np.bool_)
    product, place = np.nonzero(products.looks >= 0)
    takes[product, np.searchsorted(rows, products.looks[product, place])] = True
    return Used(rows, takes, _exclude(case, looks.of(rows)))


def choose(looks: Looks, products: Products, used: Used) -> Indices:
    """Products, one an area: most areas that are likely covered, and their quality, together."""
    if not len(products.target):
        return np.empty(0, np.intp)
    some, takes = looks.of(used.rows), used.takes
    is_out = used.is_out & (some.target[:, None] != some.target)
    areas = (np.flatnonzero(products.target == one) for one in np.unique(products.target))
    rows = {one.tobytes(): one for one in areas}
    for look in np.flatnonzero(is_out.any(axis=1)).tolist():
        # Of all products of an area that need a look in its way there is one at most.
        with_look, out = np.flatnonzero(takes[:, look]), np.flatnonzero(is_out[look])
        for target in np.unique(some.target[out]).tolist():
            others = np.flatnonzero(takes[:, out[some.target[out] == target]].any(axis=1))
            row = np.sort(np.concatenate([with_look, others]))
            rows[row.tobytes()] = row
    lengths = [len(one) for one in rows.values()]
    columns = np.concatenate(list(rows.values()))
    entries = np.ones(len(columns)), (np.repeat(np.arange(len(rows)), lengths), columns)
    found = milp(
        -(products.likely + products.quality),
        integrality=np.ones(len(products.target), np.intp),
        bounds=Bounds(0.0, 1.0),
        constraints=LinearConstraint(csr_array(entries), -np.inf, 1.0),
        options={"node_limit": NODES},
    )
    return np.flatnonzero(found.x > 0.5)


def with_spares(case: Case, products: Products, used: Used, chosen: Indices) -> Indices:
    """Looks chosen, and where they may be judged short of common ground those of further products,
    as far as no look chosen is in the way."""
    takes, is_out = used.takes, used.is_out & ~np.eye(len(used.rows), dtype=np.bool_)
    held = takes[chosen].any(axis=0)
    doubt = np.ones(len(case.ids))
    doubt[products.target[chosen]] = 1.0 - products.likely[chosen]
    for product in np.argsort(-products.quality, kind="stable").tolist():
        target, own = products.target[product], takes[product]
        is_new = not held[own].all() and not is_out[np.ix_(own, held)].any()
        if doubt[target] > DOUBTED and is_new:
            held |= own
            doubt[target] *= 1.0 - products.likely[product]
    return used.rows[held]


def actions_of(case: Case, looks: Looks, rows: Indices) -> list[dict[str, Any]]:
    """In the benchmark's format."""

    def utc(t_s: float) -> str:
        return (case.start_utc + timedelta(seconds=t_s)).strftime("%Y-%m-%dT%H:%M:%SZ")

    return [
        {
            "type": "observation",
            "satellite_id": case.satellites[looks.satellite[row]].told["id"],
            "target_id": case.ids[looks.target[row]],
            "start_time": utc(float(looks.begin_s[row])),
            "end_time": utc(float(looks.stop_s[row])),
            "off_nadir_along_deg": float(looks.steering_deg[row, 0]),
            "off_nadir_across_deg": float(looks.steering_deg[row, 1]),
        }
        for row in rows.tolist()
    ]


class Solution(NamedTuple):
    """actions, and mean quality and share of areas covered as expected, each with its bound."""

    actions: list[dict[str, Any]]
    quality: float
    quality_bound: float
    covered: float
    covered_bound: float


def solve(case: Case, tell: Callable[[str], None]) -> Solution:
    """Looks from windows, products of looks, one product an area, spares."""
    looks = looks_of(case)
    tell(f"{len(np.unique(looks.window))} windows, {len(looks.target)} looks")
    products = products_of(case, looks)
    tell(f"{len(products.target)} products of {len(np.unique(products.target))} areas")
    used = used_by(case, looks, products)
    chosen = choose(looks, products, used)
    tell(f"{len(chosen)} areas chosen")
    rows = with_spares(case, products, used, chosen)
    tell(f"{len(rows)} looks with spares")
    best = np.zeros((2, len(case.ids)))
    for bound, worth in zip(best, (products.quality, products.likely), strict=True):
        np.maximum.at(bound, products.target, worth)
    bound = best.mean(axis=1).tolist()
    value = [
        float(one[chosen].sum()) / len(case.ids) for one in (products.quality, products.likely)
    ]
    return Solution(actions_of(case, looks, rows), value[0], bound[0], value[1], bound[1])


def main() -> None:
    folder, *out = map(Path, sys.argv[1:] or [SMALL])
    begun, tell = time.process_time(), stage_clock()
    case = read_case(folder)
    tell(f"{folder.name}: {len(case.satellites)} satellites, {len(case.ids)} areas")
    found = solve(case, tell)
    print(
        f"expected before spares: quality {found.quality:.5f}, bound {found.quality_bound:.5f}; "
        f"covered {found.covered:.5f}, bound {found.covered_bound:.5f}"
    )
    if out:
        out[0].write_text(json.dumps({"actions": found.actions}, indent=1))
    print(f"{time.process_time() - begun:.1f} s of the processor")


if __name__ == "__main__":
    main()
