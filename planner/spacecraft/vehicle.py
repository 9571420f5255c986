"""The agile spacecraft: a body with gyros, whose camera looks within a box.

Numbers of Platonov, Sumarokov 2019 where the paper gives them; what its file assumes is repeated in
`ASSUMPTIONS` of the stabilisation report.
"""

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from planner.base.errors import InfeasibleSlew
from planner.world.platforms import BodyPlatform
from planner.world.platforms.agile_cmg import AGILE_CMG
from planner.world.platforms.gyro_craft import GyroCraft, Sensors, gyro_craft
from planner.world.platforms.gyros import GyroSet

SlewObjective = Literal["smooth", "minimum_time"]


@dataclass(frozen=True, kw_only=True)
class VehicleOptions:
    """What the gyros keep for other things than turns."""

    # what the body holds on its idle attitude, and gravity's torque gives in an hour
    other_n_m_s: float = 4.0
    rate_least_deg_s: float = 0.1  # the idle attitude turns at 0.06


OPTIONS = VehicleOptions()


@dataclass(frozen=True, kw_only=True)
class AgileSpacecraft:
    """A body turned by gyros; X along flight, Y up (the optical axis is -Y), Z = X x Y (pitch).

    body: with its limits of turns, nothing stored in its gyros.  rate_max_deg_s: length of its
    largest rate.  swath_m: ground width imaged at nadir.
    """

    body: BodyPlatform = AGILE_CMG
    rate_max_deg_s: float = 3.5
    swath_m: float = 12e3
    across_max_deg: float = 45.0
    along_max_deg: float = 30.0

    @property
    def name(self) -> str:
        return self.body.name

    @property
    def gyros(self) -> GyroSet:
        assert self.body.gyros is not None  # it is turned by them
        return self.body.gyros

    @property
    def craft(self) -> GyroCraft:
        """As a simulation of its control loop takes it; its gyro reads no more if asked to turn
        faster."""
        return replace(gyro_craft(self.body), sensors=Sensors())

    @property
    def _size_kg_m2(self) -> float:
        """Momentum that is turned with the body at a rate about each axis, over that rate."""
        return float(np.linalg.norm(np.diag(np.array(self.body.inertia_kg_m2))))

    def _room_n_m_s(self, stored_n_m_s: float) -> float:
        """For turns, in the sphere that the gyros are steered in."""
        return self.gyros.turns.momentum_max_n_m_s - stored_n_m_s - OPTIONS.other_n_m_s

    def rate_deg_s(self, asked_deg_s: float, stored_n_m_s: float = 0.0) -> float:
        """As much of a rate about any axis as there is room for in the gyros."""
        room_deg_s = math.degrees(self._room_n_m_s(stored_n_m_s) / self._size_kg_m2)
        return min(asked_deg_s, self.rate_max_deg_s / math.sqrt(3.0), room_deg_s)

    def platform(self, stored_n_m_s: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> BodyPlatform:
        """The body with momentum in its gyros at the start, body axes, which slows its turns.

        Raises InfeasibleSlew where they leave no room.
        """
        stored, turns = math.hypot(*stored_n_m_s), self.gyros.turns
        rate_deg_s = self.rate_deg_s(turns.rate_max_deg_s, stored)
        along, across = np.tan(np.deg2rad([self.along_max_deg, self.across_max_deg]))
        off_nadir_deg = math.degrees(math.atan(math.hypot(along, across))) + 0.5
        with suppress(ValueError):  # no torque is left to turn what is held
            if rate_deg_s >= OPTIONS.rate_least_deg_s:
                turns = replace(turns, rate_max_deg_s=rate_deg_s)
                gyros = replace(self.gyros, turns=turns, start_n_m_s=stored_n_m_s)
                return replace(self.body, gyros=gyros, off_nadir_max_deg=min(off_nadir_deg, 90.0))
        least_n_m_s = math.radians(OPTIONS.rate_least_deg_s) * self._size_kg_m2
        beyond_n_m_s = least_n_m_s - self._room_n_m_s(stored)
        much = f"at least {beyond_n_m_s:.1f} N m s" if beyond_n_m_s > 0.0 else "momentum"
        raise InfeasibleSlew(
            f"the gyros store {stored:.1f} N m s at the start, which leaves no room "
            f"to turn in the {turns.momentum_max_n_m_s:.0f} N m s sphere they are steered in; "
            f"unload {much} first",
            field="settings.momentum_n_m_s",
            limit="momentum",
        )


SPACECRAFT = {AGILE_CMG.name: AgileSpacecraft()}
