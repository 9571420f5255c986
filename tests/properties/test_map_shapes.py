"""Lines and areas cut for a map cover what they covered before."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planner.output.export.map_shapes import areas, hull, line

LONGITUDES = st.floats(-720.0, 720.0)


def ring_about(longitude_deg, latitude_deg, radius_deg, count=24):
    around = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return (
        np.radians(latitude_deg + radius_deg * np.sin(around)),
        np.radians(longitude_deg + radius_deg * np.cos(around)),
    )


def area_deg2(ring):
    """On the flat map, positive counter-clockwise.  Source: the shoelace formula."""
    x, y = ring[:-1].T
    return 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)


@given(LONGITUDES, st.floats(-60.0, 60.0), st.floats(0.1, 29.0), st.booleans())
def test_the_parts_of_an_area_are_as_large_as_it(longitude_deg, latitude_deg, radius_deg, reverse):
    latitude_rad, longitude_rad = ring_about(longitude_deg, latitude_deg, radius_deg)
    if reverse:
        latitude_rad, longitude_rad = latitude_rad[::-1], longitude_rad[::-1]
    wrapped_rad = (longitude_rad + np.pi) % (2.0 * np.pi) - np.pi
    rings = areas([(latitude_rad, wrapped_rad)]).rings_deg
    assert 1 <= len(rings) <= 2
    for ring in rings:
        assert np.abs(ring[:, 0]).max() <= 180.0
        np.testing.assert_array_equal(ring[0], ring[-1])
        assert area_deg2(ring) >= 0.0
    expected = 24 / 2 * radius_deg**2 * np.sin(2.0 * np.pi / 24)  # a regular polygon's
    # corners are rounded to 1e-6 deg
    assert sum(map(area_deg2, rings)) == pytest.approx(expected, abs=1e-5 * max(radius_deg, 1.0))


@given(LONGITUDES, st.floats(60.0, 89.0), st.sampled_from([1.0, -1.0]))
def test_a_ring_about_a_pole_reaches_it(first_deg, latitude_deg, side):
    longitude_rad = np.radians(first_deg + np.arange(0.0, 360.0, 10.0))
    rings = areas([(np.full(36, side * np.radians(latitude_deg)), longitude_rad)]).rings_deg
    covered = sum(map(area_deg2, rings))
    assert covered == pytest.approx(360.0 * (90.0 - latitude_deg), rel=1e-6)
    assert max(np.abs(ring[:, 1]).max() for ring in rings) == 90.0


@given(LONGITUDES, st.floats(-80.0, 80.0), st.floats(-300.0, 300.0))
def test_a_line_is_cut_where_the_map_ends(start_deg, latitude_deg, length_deg):
    longitude_rad = np.radians(np.linspace(start_deg, start_deg + length_deg, 50))
    latitude_rad = np.radians(np.linspace(latitude_deg, latitude_deg + 5.0, 50))
    parts = line(latitude_rad, (longitude_rad + np.pi) % (2.0 * np.pi) - np.pi).parts_deg
    for part in parts:
        assert len(part) >= 2
        assert np.abs(part[:, 0]).max() <= 180.0
        assert np.abs(np.diff(part[:, 0])).max() < 180.0
    for before, after in itertools.pairwise(parts):
        assert abs(before[-1, 0]) == abs(after[0, 0]) == 180.0
        assert before[-1, 1] == after[0, 1]
    east_deg = sum(part[-1, 0] - part[0, 0] for part in parts)
    assert east_deg == pytest.approx(length_deg, abs=1e-5)


@given(LONGITUDES, st.floats(-85.0, 85.0))
def test_a_hull_holds_every_corner(longitude_deg, latitude_deg):
    first = ring_about(longitude_deg, latitude_deg, 0.05, 4)
    second = ring_about(longitude_deg + 0.01, latitude_deg, 0.05, 4)
    latitude_rad, longitude_rad = (np.concatenate(pair) for pair in zip(first, second, strict=True))
    around = hull(latitude_rad, longitude_rad)
    outer = np.stack(around, axis=1)
    north, south = latitude_rad.max(), latitude_rad.min()
    assert (outer[:, 0].max(), outer[:, 0].min()) == (north, south)
    assert 4 <= len(outer) <= 6  # of two diamonds side by side, two corners each lie inside
