"""The Earth's gravity: EIGEN-6S to degree and order 36, at many positions at once."""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from math import factorial, sqrt

import numpy as np
from numpy.typing import NDArray

from planner.base.arrays import Array

DEGREE = 36
GM_M3_S2 = 3.986004415e14  # EIGEN-6S (planner/world/orbits/data/eigen6s_n36.csv)
RADIUS_M = 6378136.46  # EIGEN-6S, the radius its coefficients are scaled with


@dataclass(frozen=True, eq=False)
class GravityField:
    """Sums and recursion factors of the field, ready for matrix products.

    With U_nm = V_nm + i W_nm the acceleration is GM/R^2 times
    x + i y: sum(lower_xy U + conj(upper_xy U)),  z: Re sum(z U).
    lower_xy, upper_xy, z: complex, shape ((DEGREE + 2)^2,), U's order.  up_factor, back_factor: of
    the recursion, shape (DEGREE + 2, DEGREE + 2).
    """

    lower_xy: NDArray[np.complex128]
    upper_xy: NDArray[np.complex128]
    z: NDArray[np.complex128]
    up_factor: Array
    back_factor: Array

    def acceleration_itrf_m_s2(self, r_itrf_m: Array) -> Array:
        """Attraction (no centrifugal part) in ITRF axes, shape (n, 3), outside the Earth.

        Leaves out tides and the terms above degree 36: about 1e-5 m/s^2 at 400 km, but with
        periods under 150 s, so centimetres in 900 s.
        Source: Cunningham 1970 as in Montenbruck & Gill 2000, eq. 3.27-3.33.
        """
        size = DEGREE + 2
        r2 = np.einsum("ni,ni->n", r_itrf_m, r_itrf_m)
        shrink = RADIUS_M / r2
        xy = (r_itrf_m[:, 0] + 1j * r_itrf_m[:, 1]) * shrink
        z = r_itrf_m[:, 2] * shrink
        shrink2 = RADIUS_M * shrink
        u = np.zeros((size, size, len(r_itrf_m)), dtype=np.complex128)
        u[0, 0] = RADIUS_M / np.sqrt(r2)
        for n in range(1, size):
            u[n, :n] = self.up_factor[n, :n, None] * (z * u[n - 1, :n])
            if n > 1:
                u[n, :n] -= self.back_factor[n, :n, None] * (shrink2 * u[n - 2, :n])
            u[n, n] = (2 * n - 1) * xy * u[n - 1, n - 1]
        flat = u.reshape(size * size, -1)
        in_plane = self.lower_xy @ flat + np.conj(self.upper_xy @ flat)
        along = (self.z @ flat).real
        return (GM_M3_S2 / RADIUS_M**2) * np.stack([in_plane.real, in_plane.imag, along], axis=1)


@cache
def earth_gravity() -> GravityField:
    """The field of the packaged coefficients, read once a process (about 10 ms)."""
    text = (files("planner.world.orbits") / "data" / "eigen6s_n36.csv").read_text(encoding="ascii")
    rows = [line.split(",") for line in text.splitlines() if line[0].isdigit()]
    size = DEGREE + 2
    lower_xy, upper_xy, z = (np.zeros((size, size), dtype=np.complex128) for _ in range(3))
    for n_text, m_text, c_text, s_text in rows:
        n, m = int(n_text), int(m_text)
        norm = sqrt((2 - (m == 0)) * (2 * n + 1) * factorial(n - m) / factorial(n + m))
        k = norm * complex(float(c_text), -float(s_text))
        z[n + 1, m] -= (n - m + 1) * k
        lower_xy[n + 1, m + 1] -= k if m == 0 else k / 2
        if m > 0:
            upper_xy[n + 1, m - 1] += (n - m + 2) * (n - m + 1) * k / 2
    degree, order = np.indices((size, size))
    below = np.maximum(degree - order, 1)
    return GravityField(
        lower_xy=lower_xy.ravel(),
        upper_xy=upper_xy.ravel(),
        z=z.ravel(),
        up_factor=np.where(order < degree, (2 * degree - 1) / below, 0.0),
        back_factor=np.where(order < degree, (degree + order - 1) / below, 0.0),
    )
