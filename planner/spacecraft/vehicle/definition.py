"""The agile spacecraft: its inertia, modes, sensors, limits and control gains.

Numbers of Platonov, Sumarokov 2019 where the paper gives them; every other default is an
assumption, named as such here and repeated in `ASSUMPTIONS` of the stabilisation report.
"""

import math
from typing import Annotated, Literal

import numpy as np

from planner.base.spec import Within, spec
from planner.world.platforms.cmg_array import CmgArray, Positive
from planner.world.platforms.gyro_craft import (
    ASSUMED_MODES,
    ControlGains,
    FlexibleMode,
    GyroCraft,
    Sensors,
    Vector3,
)

SlewObjective = Literal["smooth", "minimum_time"]
SETTLE_S = (0.0, 60.0)
SWATH_M = (100.0, 500e3)
OFF_NADIR_DEG = (0.1, 60.0)


@spec
class SlewLimits:
    """What a planned turn may ask for; of the gyros no more than `CmgArray` has everywhere.

    rate_rad_s: vector magnitude; rate_axis_rad_s: each body axis, 1.58 deg/s by default so that
    the gyro (1.6) always reads.  torque, torque_rate: magnitude of the control torque and of
    its derivative (assumed: they spare the modes).  settle_s: between the end of a turn and
    imaging, on the profile already.
    """

    rate_rad_s: Positive = math.radians(3.5)
    rate_axis_rad_s: Positive = math.radians(1.58)
    torque_n_m: Positive = 15.0
    torque_rate_n_m_s: Positive = 40.0
    momentum_sphere_n_m_s: Positive = 60.0
    settle_s: Annotated[float, Within(*SETTLE_S)] = 2.6


@spec
class PushbroomCamera:
    """The pushbroom camera, optical axis -Y, detector columns along X.

    pixel_rad: 1 m at nadir from 650 km.  tdi_lines: lines added up, which sets the exposure;
    swath_m: ground width imaged at nadir.  reversible: whether the detector also scans
    backwards (TDI in both directions).  The paper gives 1 m and 12 km; TDI is assumed.
    """

    pixel_rad: Annotated[float, Within(1e-9, 1e-3)] = 1.0 / 650e3
    tdi_lines: Annotated[int, Within(1, 1024)] = 32
    swath_m: Annotated[float, Within(*SWATH_M)] = 12e3
    reversible: bool = False
    across_max_deg: Annotated[float, Within(*OFF_NADIR_DEG)] = 45.0
    along_max_deg: Annotated[float, Within(*OFF_NADIR_DEG)] = 30.0


@spec
class AgileSpacecraft:
    """An Earth-imaging spacecraft turned by control moment gyros.

    Body axes: X along flight, Y up (the optical axis is -Y), Z = X x Y (pitch).
    inertia_kg_m2: principal moments, the swinging parts included.
    """

    name: str = "agile-cmg"
    inertia_kg_m2: Vector3 = (800.0, 500.0, 800.0)
    array: CmgArray = CmgArray()
    modes: tuple[FlexibleMode, ...] = ASSUMED_MODES
    sensors: Sensors = Sensors()
    gains: ControlGains = ControlGains()
    slew: SlewLimits = SlewLimits()
    camera: PushbroomCamera = PushbroomCamera()

    def __post_init__(self) -> None:
        a, b, c = sorted(self.inertia_kg_m2)
        if not (a > 0.0 and a + b >= c):
            raise ValueError(
                f"inertia_kg_m2 {self.inertia_kg_m2}: no body has these moments (each must be "
                "positive and at most the sum of the others)"
            )
        for name, value, most in (
            ("momentum_sphere_n_m_s", self.slew.momentum_sphere_n_m_s, self.array.sphere_n_m_s),
            ("torque_n_m", self.slew.torque_n_m, self.array.torque_n_m),
        ):
            if value > most:
                raise ValueError(
                    f"slew.{name} ({value:g}) is more than the {most:g} that the gyros of "
                    f"{self.name!r} have in every direction; ask for less of them"
                )
        craft = self.craft
        d = craft.couplings_sqrt_kg_m
        if np.linalg.eigvalsh(craft.inertia_kg_m2 - d.T @ d)[0] <= 0.0:
            raise ValueError("the modes' inertia shares leave no rigid body; make them smaller")

    @property
    def craft(self) -> GyroCraft:
        """As a simulation of its control loop takes it."""
        torque_n_m = self.gains.acceleration_share * self.slew.torque_n_m
        return GyroCraft(
            inertia_kg_m2=np.diag(self.inertia_kg_m2),
            array=self.array,
            modes=self.modes,
            sensors=self.sensors,
            gains=self.gains,
            turn_acceleration_rad_s2=torque_n_m / max(self.inertia_kg_m2),
            turn_rate_rad_s=self.slew.rate_axis_rad_s,
        )


AGILE_CMG = AgileSpacecraft()
SPACECRAFT = {AGILE_CMG.name: AGILE_CMG}
