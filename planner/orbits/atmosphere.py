"""The density of the upper air: Harris-Priester, for mean solar activity."""

import numpy as np

from planner.arrays import Array

BULGE_LAG_RAD = np.deg2rad(30.0)  # Montenbruck & Gill 2000, 3.5.2
BULGE_EXPONENT = 2.0  # for low inclinations; 6 for polar orbits: Montenbruck & Gill 2000, 3.5.2
HEIGHT_MIN_M = 1e5

# Height (km), density on the night side and under the bulge (g/km^3):
# Montenbruck & Gill 2000, table 3.8
_TABLE = np.array(
    [
        (100, 497400.0, 497400.0),
        (120, 24900.0, 24900.0),
        (130, 8377.0, 8710.0),
        (140, 3899.0, 4059.0),
        (150, 2122.0, 2215.0),
        (160, 1263.0, 1344.0),
        (170, 800.8, 875.8),
        (180, 528.3, 601.0),
        (190, 361.7, 429.7),
        (200, 255.7, 316.2),
        (210, 183.9, 239.6),
        (220, 134.1, 185.3),
        (230, 99.49, 145.5),
        (240, 74.88, 115.7),
        (250, 57.09, 93.08),
        (260, 44.03, 75.55),
        (270, 34.30, 61.82),
        (280, 26.97, 50.95),
        (290, 21.39, 42.26),
        (300, 17.08, 35.26),
        (320, 10.99, 25.11),
        (340, 7.214, 18.19),
        (360, 4.824, 13.37),
        (380, 3.274, 9.955),
        (400, 2.249, 7.492),
        (420, 1.558, 5.684),
        (440, 1.091, 4.355),
        (460, 0.7701, 3.362),
        (480, 0.5474, 2.612),
        (500, 0.3916, 2.042),
        (520, 0.2819, 1.605),
        (540, 0.2042, 1.267),
        (560, 0.1488, 1.005),
        (580, 0.1092, 0.7997),
        (600, 0.08070, 0.6390),
        (620, 0.06012, 0.5123),
        (640, 0.04519, 0.4121),
        (660, 0.03430, 0.3325),
        (680, 0.02632, 0.2691),
        (700, 0.02043, 0.2185),
        (720, 0.01607, 0.1779),
        (740, 0.01281, 0.1452),
        (760, 0.01036, 0.1190),
        (780, 0.008496, 0.09776),
        (800, 0.007069, 0.08059),
        (840, 0.004680, 0.05741),
        (880, 0.003200, 0.04210),
        (920, 0.002210, 0.03130),
        (960, 0.001560, 0.02360),
        (1000, 0.001150, 0.01810),
    ]
)
_HEIGHT_M = _TABLE[:, 0] * 1e3
_LOG_DENSITY = np.log(_TABLE[:, 1:] * 1e-12)


def density_kg_m3(r_eci_m: Array, height_m: Array, r_sun_eci_m: Array) -> Array:
    """Density at n positions, shape (n,); nothing above 1000 km, that of 100 km below it.

    r_eci_m, r_sun_eci_m: shape (n, 3).  height_m: above the ellipsoid, shape (n,).
    The bulge trails the Sun by two hours of local time.  Leaves out the solar cycle and
    magnetic storms, which halve or double the density.
    Source: Montenbruck & Gill 2000, eq. 3.100-3.104.
    """
    c, s = np.cos(BULGE_LAG_RAD), np.sin(BULGE_LAG_RAD)
    x, y, z = (r_sun_eci_m / np.linalg.norm(r_sun_eci_m, axis=1, keepdims=True)).T
    bulge = np.stack([c * x - s * y, s * x + c * y, z], axis=1)
    cos_angle = np.einsum("ni,ni->n", r_eci_m, bulge) / np.linalg.norm(r_eci_m, axis=1)
    weight = (0.5 + 0.5 * cos_angle) ** (BULGE_EXPONENT / 2.0)
    night, day = (np.exp(np.interp(height_m, _HEIGHT_M, column)) for column in _LOG_DENSITY.T)
    density = night + (day - night) * weight
    return np.where(height_m > _HEIGHT_M[-1], 0.0, density)
