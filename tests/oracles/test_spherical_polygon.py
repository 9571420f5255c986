"""Distance of a direction from a polygon, by points along its sides, and the side it winds on."""

import math

import numpy as np
import pytest
from mask_shapes import boom, inside, mask_corners, sampled_away_rad, star

from planner.motion.detour.caps import convex_parts
from planner.verification.field_masks import Region
from planner.world.platforms import FieldMask


def random_mask(number):
    """Some convex, most not; from 1 to 80 deg in size."""
    rng = np.random.default_rng(number)
    middle = rng.normal(size=3)
    middle /= np.linalg.norm(middle)
    size_rad = math.radians(10.0 ** rng.uniform(0.0, math.log10(80.0)))
    if number % 5 == 0:
        corners = boom(rng, middle, size_rad, size_rad / 50.0)
    else:
        corners = star(rng, middle, size_rad, int(rng.integers(4, 40)))
    if number % 2:
        corners = corners[::-1]
    return FieldMask(name="any", corners_platform=tuple(map(tuple, (3.0 * corners).tolist())))


def directions_about(mask, count):
    """Half of them anywhere, half near; some at a corner's very edge."""
    rng = np.random.default_rng(count)
    corners = mask_corners(mask)
    size = np.linalg.norm(corners - corners.mean(axis=0), axis=1).max()
    found = np.concatenate(
        [
            rng.normal(size=(count, 3)),
            corners.mean(axis=0) + 0.7 * size * rng.normal(size=(count, 3)),
            corners + 1e-6 * rng.normal(size=corners.shape),
        ]
    )
    return found / np.linalg.norm(found, axis=1, keepdims=True)


@pytest.mark.parametrize("number", range(20))
def test_depth_is_what_points_along_the_sides_and_winding_say(number):
    """By the planner and by the judge, who share no code."""
    mask = random_mask(number)
    corners = mask_corners(mask)
    directions = directions_about(mask, 60)
    sampled_rad, step_rad = sampled_away_rad(corners, directions)
    is_inside = inside(corners, directions)
    for depth_rad in (mask.depth_rad(directions), -Region(mask).away_rad(directions)):
        assert np.array_equal(depth_rad > 0.0, is_inside)
        away_rad = np.abs(depth_rad)
        assert (away_rad <= sampled_rad + 1e-12).all()  # rounding
        # The nearest point lies at most half a step from a sampled one.
        assert (sampled_rad <= np.hypot(away_rad, step_rad) + 1e-12).all()


@pytest.mark.parametrize("number", range(20))
def test_convex_parts_make_up_the_polygon_once(number):
    mask = random_mask(number)
    parts = convex_parts(mask.polygon)
    directions = directions_about(mask, 500)
    depth_rad = np.stack([part.depth_rad(directions) for part in parts])
    off_seams = np.abs(depth_rad).min(axis=0) > 1e-9
    holders = (depth_rad > 0.0).sum(axis=0)
    assert np.array_equal(holders[off_seams], inside(mask_corners(mask), directions)[off_seams])
    for part in parts:
        # Convex: every corner is on the inner side of every side.
        assert (part.normals @ part.corner_directions.T).min() > -1e-9


def test_an_octant_is_as_deep_as_its_incircle():
    mask = FieldMask(
        name="octant", corners_platform=((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    )
    middle = np.full((1, 3), 1.0 / math.sqrt(3.0))
    incircle_rad = math.asin(1.0 / math.sqrt(3.0))
    np.testing.assert_allclose(mask.depth_rad(middle), incircle_rad, rtol=0, atol=1e-15)
    # From behind, a corner is nearest: 90 deg and what is left of the octant's circumcircle.
    away_rad = math.pi - math.acos(1.0 / math.sqrt(3.0))
    np.testing.assert_allclose(mask.depth_rad(-middle), -away_rad, rtol=0, atol=1e-15)
