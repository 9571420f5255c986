"""An Earth-imaging spacecraft turned by control moment gyros.

Body axes are X along flight, Y up, Z = X x Y.  Inertia, gyros and camera are those of Platonov,
Sumarokov 2019, and off nadir its 45 deg across the track; limits of torque, torque rate and
settling are assumed, as in docs/spacecraft.md.
"""

from planner.world.platforms.body import (
    BodyPlatform,
    LinesAcrossMotion,
    NadirIdle,
    PointingKnowledge,
    PushbroomCamera,
)
from planner.world.platforms.gyros import GyroSet, GyroTurns, ScissoredPairs

AGILE_CMG = BodyPlatform(
    name="agile-cmg",
    gyros=GyroSet(
        array=ScissoredPairs(rotor_n_m_s=60.0, gimbal_rate_max_deg_s=57.3),
        turns=GyroTurns(
            rate_max_deg_s=1.58,
            torque_max_n_m=15.0,
            torque_rate_max_n_m_s=40.0,
            momentum_max_n_m_s=60.0,
            settle_s=2.6,
        ),
    ),
    off_nadir_max_deg=45.0,
    roll=LinesAcrossMotion(),
    idle=NadirIdle(direction_body=(0.0, -1.0, 0.0), forward_body=(1.0, 0.0, 0.0)),
    inertia_kg_m2=((800.0, 0.0, 0.0), (0.0, 500.0, 0.0), (0.0, 0.0, 800.0)),
    camera=PushbroomCamera(
        boresight_body=(0.0, -1.0, 0.0),
        line_body=(0.0, 0.0, 1.0),
        pixel_arcsec=0.31733,  # 1 m from 650 km
        pixels=12_000,
        tdi_lines=32,
    ),
    knowledge=PointingKnowledge(sigma_arcsec=5.0, control_sigma_arcsec=5.0),
)
