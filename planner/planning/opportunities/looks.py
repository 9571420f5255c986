"""The view of a target at an instant, compiled: line of sight, elevation, sunlight.

Everything is in ITRF axes but what says platform.  Directions hold light time and aberration.
Those to the ground leave out refraction also where a target asks for it: on the axes 8 arcsec at
30 deg elevation and 50 at 10.
"""

import math
from typing import NamedTuple

from planner.base.arrays import Array
from planner.base.compiled import inlined, lean
from planner.base.vectors import (
    Powers,
    Vector,
    arcsin,
    cell_of,
    column_at,
    cross,
    dot,
    motion_at,
    norm,
    plus,
    scaled,
    unit,
    vector_at,
    vector_of,
)
from planner.world.frames.earth_orientation import OMEGA_EARTH_RAD_S
from planner.world.targets.apparent import SPEED_OF_LIGHT_M_S
from planner.world.targets.limb_kernel import above_limb, refracted

Quintic = tuple[Vector, Vector, Vector, Vector, Vector, Vector]


class CarrierTables(NamedTuple):
    """What `Carrier` holds, as compiled code takes it, and bounds of the orbit.

    orbit: position and inertial velocity, the orbit's own: SGP4's isn't quite the rate of its
    position.  bodies: the Sun and the Moon.  platform: its first two axes, all but unit vectors.
    turn_rad_s: of the platform at most.
    farthest_m, speed_m_s, acceleration_m_s2, passing_rad_s: greatest of position, velocity,
    acceleration and turn of the direction in ITRF.
    """

    span_s: float
    step_s: float
    orbit: Powers
    body_step_s: float
    bodies: Powers
    platform_step_s: float
    platform: Powers
    turn_rad_s: float
    farthest_m: float
    speed_m_s: float
    acceleration_m_s2: float
    passing_rad_s: float


class Places(NamedTuple):
    """Targets that are looked at alike: any number at rest on the Earth, or one that isn't, of any
    number of begins.

    resting_parameters: (n, 7), position, vertical, and least elevation or height above the limb.
    step_s: of the track, 0 for those at rest.  track: position and vertical on the Earth;
    direction, before the carrier's aberration, and 1 / range in space.  begins_s: when that does,
    by number.
    grazing_m: altitude by which the limb is raised.  bending_coefficients: (5, k), nodes of height
    and coefficients of the logarithm of the air's bending; none where refraction isn't asked for.
    """

    resting_parameters: Array
    in_space: bool
    step_s: float
    track: Powers
    grazing_m: float
    bending_coefficients: Array
    begins_s: Array


@inlined
def place_at(p: Places, n: int, t_s: float) -> Vector:
    """Position of a target on the Earth."""
    if p.step_s == 0.0:
        return vector_of(p.resting_parameters, n, 0)
    return vector_at(p.track, p.step_s, t_s - p.begins_s[n], 0)


@inlined
def up_at(p: Places, n: int, t_s: float) -> Vector:
    """The ellipsoid's normal at it."""
    if p.step_s == 0.0:
        return vector_of(p.resting_parameters, n, 3)
    return vector_at(p.track, p.step_s, t_s - p.begins_s[n], 3)


@inlined
def carried(r: Vector) -> Vector:
    """Inertial velocity of a point at rest on the Earth."""
    return -OMEGA_EARTH_RAD_S * r[1], OMEGA_EARTH_RAD_S * r[0], 0.0


@inlined
def aberrate(direction: Vector, v_m_s: Vector) -> Vector:
    """As `planner.world.targets.apparent`, to (v / c)^4."""
    beta = scaled(1.0 / SPEED_OF_LIGHT_M_S, v_m_s)
    inverse_gamma = 1.0 - 0.5 * dot(beta, beta)
    along = dot(direction, beta)
    seen = plus(scaled(inverse_gamma, direction), 1.0 + along / (1.0 + inverse_gamma), beta)
    return scaled(1.0 / (1.0 + along), seen)


@lean
def _in_space(c: CarrierTables, p: Places, t_s: float) -> tuple[Vector, float]:
    """Direction before the carrier's aberration, refracted where that is asked for, and range."""
    d = unit(vector_at(p.track, p.step_s, t_s, 0))
    if p.bending_coefficients.shape[1]:
        d = refracted(p.bending_coefficients, d, vector_at(c.orbit, c.step_s, t_s, 0))
    return d, 1.0 / column_at(p.track, p.step_s, t_s, 3)


@inlined
def look(c: CarrierTables, p: Places, n: int, t_s: float) -> tuple[Vector, float, Vector, Vector]:
    """Direction and range of a target; position and inertial velocity of the carrier."""
    r_sat = vector_at(c.orbit, c.step_s, t_s, 0)
    v = vector_at(c.orbit, c.step_s, t_s, 3)
    if p.in_space:
        d, range_m = _in_space(c, p, t_s)
        return aberrate(d, v), range_m, r_sat, v
    los = plus(place_at(p, n, t_s), -1.0, r_sat)
    range_m = norm(los)
    light_s = range_m / SPEED_OF_LIGHT_M_S
    return _apparent(place_at(p, n, t_s - light_s), light_s, r_sat, v), range_m, r_sat, v


@inlined
def _apparent(emitting: Vector, light_s: float, r_sat: Vector, v: Vector) -> Vector:
    """Direction of a place on the Earth, which light left that long ago."""
    los = plus(plus(emitting, -light_s, carried(emitting)), -1.0, r_sat)
    return aberrate(unit(los), v)


@inlined
def in_platform(c: CarrierTables, d: Vector, t_s: float) -> Vector:
    """A unit vector turned into the platform frame."""
    x = vector_at(c.platform, c.platform_step_s, t_s, 0)
    y = vector_at(c.platform, c.platform_step_s, t_s, 3)
    return _in_axes(x, y, d)


@inlined
def _in_axes(x: Vector, y: Vector, d: Vector) -> Vector:
    los = dot(x, d), dot(y, d), dot(cross(x, y), d)
    return scaled(1.5 - 0.5 * dot(los, los), los)  # a step of Newton's to unit length


@inlined
def sight_at(c: CarrierTables, p: Places, n: int, t_s: float) -> Vector:
    """Direction of a target in the platform frame."""
    return in_platform(c, look(c, p, n, t_s)[0], t_s)


class Cells(NamedTuple):
    """What a place at rest is looked at with in one cell of the carrier's tables: powers of its
    position, its velocity and the platform's axes, and the place."""

    orbit_cell: int
    r_sat: Quintic
    v: Quintic
    platform_cell: int
    x: Quintic
    y: Quintic
    place: Vector


@inlined
def cells_at(c: CarrierTables, p: Places, n: int, t_s: float) -> Cells:
    orbit, platform = (
        cell_of(c.orbit, c.step_s, t_s)[0],
        cell_of(c.platform, c.platform_step_s, t_s)[0],
    )
    return Cells(
        orbit,
        _quintic(c.orbit, orbit, 0),
        _quintic(c.orbit, orbit, 3),
        platform,
        _quintic(c.platform, platform, 0),
        _quintic(c.platform, platform, 3),
        vector_of(p.resting_parameters, n, 0),
    )


@inlined
def sight_in(c: CarrierTables, cells: Cells, t_s: float) -> Vector:
    """`sight_at` without a branch or a read of tables: a loop of it is done four by four."""
    u = t_s / c.step_s - cells.orbit_cell
    r_sat = _along(cells.r_sat, u)
    light_s = norm(plus(cells.place, -1.0, r_sat)) / SPEED_OF_LIGHT_M_S
    d = _apparent(cells.place, light_s, r_sat, _along(cells.v, u))
    u = t_s / c.platform_step_s - cells.platform_cell
    return _in_axes(_along(cells.x, u), _along(cells.y, u), d)


@inlined
def rests_within_cells(c: CarrierTables, p: Places, start_s: float, stop_s: float) -> bool:
    """Whether `sight_in` one cell of each table serves from start_s to stop_s."""
    return (
        p.step_s == 0.0
        and cell_of(c.orbit, c.step_s, start_s)[0] == cell_of(c.orbit, c.step_s, stop_s)[0]
        and cell_of(c.platform, c.platform_step_s, start_s)[0]
        == cell_of(c.platform, c.platform_step_s, stop_s)[0]
    )


@inlined
def _quintic(powers: Powers, cell: int, m: int) -> Quintic:
    rows = powers[cell]
    return (
        vector_of(rows, 0, m),
        vector_of(rows, 1, m),
        vector_of(rows, 2, m),
        vector_of(rows, 3, m),
        vector_of(rows, 4, m),
        vector_of(rows, 5, m),
    )


@inlined
def _along(powers: Quintic, u: float) -> Vector:
    total = plus(powers[4], u, powers[5])
    total = plus(powers[3], u, total)
    total = plus(powers[2], u, total)
    return plus(powers[0], u, plus(powers[1], u, total))


@lean
def platform_los(c: CarrierTables, p: Places, n: int, t_s: float) -> Vector:
    """The same, as a call."""
    return sight_at(c, p, n, t_s)


@inlined
def to_body(c: CarrierTables, body: int, r_sat: Vector, v: Vector, t_s: float) -> Vector:
    """Where the moving carrier sees the centre of the Sun (0) or the Moon (1)."""
    return aberrate(unit(plus(vector_at(c.bodies, c.body_step_s, t_s, 3 * body), -1.0, r_sat)), v)


@inlined
def to_sun(c: CarrierTables, r_target: Vector, t_s: float) -> Vector:
    """Where a target on the Earth sees the Sun; parallax, diurnal aberration included."""
    apart = plus(vector_at(c.bodies, c.body_step_s, t_s, 0), -1.0, r_target)
    return aberrate(unit(apart), carried(r_target))


@inlined
def sun_elevation(c: CarrierTables, p: Places, n: int, t_s: float) -> float:
    """Of its centre in the target's sky, without refraction; NaN in space."""
    if p.in_space:
        return math.nan
    return arcsin(dot(to_sun(c, place_at(p, n, t_s), t_s), up_at(p, n, t_s)))


@inlined
def elevation(c: CarrierTables, p: Places, n: int, t_s: float) -> float:
    """Of the carrier in the target's sky, over the plane of the ellipsoid; of a target in space
    its height above the raised limb."""
    r_sat = vector_at(c.orbit, c.step_s, t_s, 0)
    if p.in_space:
        return above_limb(_in_space(c, p, t_s)[0], r_sat, p.grazing_m)
    apart = plus(r_sat, -1.0, place_at(p, n, t_s))
    return arcsin(dot(apart, up_at(p, n, t_s)) / norm(apart))


@inlined
def closeness(c: CarrierTables, p: Places, n: int, t_s: float) -> float:
    """Greatest at the closest approach; that a carrier doesn't make to a target in space, of
    which the height above the limb counts."""
    if p.in_space:
        return elevation(c, p, n, t_s)
    return -norm(plus(vector_at(c.orbit, c.step_s, t_s, 0), -1.0, place_at(p, n, t_s)))


@inlined
def climb(c: CarrierTables, p: Places, n: int, t_s: float, of_elevation: bool) -> float:
    """What has the sign of the rate of elevation or closeness, of a place at rest."""
    r_sat, v = motion_at(c.orbit, c.step_s, t_s)
    apart = plus(r_sat, -1.0, vector_of(p.resting_parameters, n, 0))
    opening = dot(v, apart)
    if not of_elevation:
        return -opening
    up = vector_of(p.resting_parameters, n, 3)
    return dot(v, up) - dot(apart, up) * opening / dot(apart, apart)
