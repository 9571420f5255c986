"""The cones that the boresight of two axes must keep out of."""

import math
from typing import Annotated

import erfa
import numpy as np

from planner.base.arrays import Array
from planner.base.rotation import Rotation
from planner.base.spec import LENGTH_MIN, VectorPart, Within, spec
from planner.world.frames.local_orbital import q_lvlh_from_eci
from planner.world.frames.solar_system import BODIES
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.targets.body import HIDDEN_RAD, BodyTarget

Vector3 = tuple[VectorPart, VectorPart, VectorPart]
WAYS_TO_SAY = "body, ra_deg and dec_deg, direction_lvlh or direction_platform"


@spec
class KeepOut:
    """A cone about one direction; exactly one direction is given.

    half_angle_deg: from the cone's axis to its side.
    body: the centre of the Sun, the Moon or a planet, as seen; the cone lapses while the Earth
    hides the body, disk and refraction included.
    ra_deg, dec_deg: right ascension and declination of a direction in GCRF axes. E.g. `10.0`.
    direction_lvlh: in the local orbital frame (+Z geocentric nadir, +Y against the orbit normal);
    needs no unit length. E.g. `[0.0, 0.0, -1.0]`.
    direction_platform: fixed to the platform, such as a part of the carrier; needs no unit length.
    E.g. `[0.0, 0.0, -1.0]`.
    """

    half_angle_deg: Annotated[float, Within(1e-3, 179.9)]
    body: str | None = None
    ra_deg: Annotated[float, Within(0.0, 360.0)] | None = None
    dec_deg: Annotated[float, Within(-90.0, 90.0)] | None = None
    direction_lvlh: Vector3 | None = None
    direction_platform: Vector3 | None = None

    def __post_init__(self) -> None:
        if (self.ra_deg is None) != (self.dec_deg is None):
            raise ValueError("ra_deg and dec_deg belong together; give both or neither")
        given = (self.body, self.ra_deg, self.direction_lvlh, self.direction_platform)
        if sum(value is not None for value in given) != 1:
            raise ValueError(f"a keep-out cone needs one direction: {WAYS_TO_SAY}")
        if self.body is not None and self.body.lower() not in BODIES:
            raise ValueError(f"body must be one of {', '.join(BODIES)}, not {self.body[:40]!r}")
        for name in ("direction_lvlh", "direction_platform"):
            vector = getattr(self, name)
            if vector is not None and not math.hypot(*vector) >= LENGTH_MIN:
                raise ValueError(
                    f"{name} must be at least {LENGTH_MIN:g} long, not {math.hypot(*vector):g}"
                )

    @property
    def about(self) -> str:
        """The direction, for a sentence."""
        if self.body is not None:
            return f"the {self.body.capitalize()}"
        if self.ra_deg is not None:
            return f"right ascension {self.ra_deg:g}, declination {self.dec_deg:g} deg"
        if self.direction_lvlh is not None:
            return f"LVLH direction {_direction_text(self.direction_lvlh)}"
        assert self.direction_platform is not None
        return f"platform direction {_direction_text(self.direction_platform)}"

    def axis_base(
        self, instants: Instants, states: OrbitStates, q_base_from_eci: Rotation
    ) -> tuple[Array, Array]:
        """The cone's axis, unit vectors (n, 3), and by how much it counts, rad, (n,).

        It counts where the second is positive: a body is that far from being wholly hidden.
        """
        n = len(instants.t_s)
        always = np.full(n, math.pi)
        if self.direction_platform is not None:
            return np.tile(_unit_vector(self.direction_platform), (n, 1)), always
        if self.direction_lvlh is not None:
            q_lvlh = q_lvlh_from_eci(states.r_sat_eci_m, states.v_sat_eci_m_s)
            axis_eci = q_lvlh.inv().apply(_unit_vector(self.direction_lvlh))
        elif self.body is not None:
            seen = BodyTarget(name=self.body, grazing_altitude_km=0.0).apparent(instants, states)
            axis_eci, always = seen.direction_eci, seen.clearance_rad + HIDDEN_RAD
        else:
            ra, dec = math.radians(self.ra_deg or 0.0), math.radians(self.dec_deg or 0.0)
            axis_eci = np.tile(erfa.s2c(ra, dec), (n, 1))
        return np.asarray(q_base_from_eci.apply(axis_eci)), always


def _unit_vector(vector: Vector3) -> Array:
    return np.asarray(vector) / math.hypot(*vector)


def _direction_text(direction_unit: tuple[float, ...]) -> str:
    return "(" + ", ".join(f"{part:.6g}" for part in direction_unit) + ")"
