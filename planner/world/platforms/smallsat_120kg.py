"""A small satellite that turns as a whole under a pushbroom camera; no particular one.

Rates and accelerations are those of reaction wheels on 120 kg (0.03 N m on 13 kg m2), the camera
has 0.7 m a pixel from 500 km, and star trackers their usual angles to Sun, Moon and Earth.
"""

from planner.world.platforms.body import (
    BodyPlatform,
    Exclusion,
    LinesAcrossMotion,
    MagnitudeAgility,
    PointingKnowledge,
    PushbroomCamera,
    StarTracker,
    StarTrackers,
    SunIdle,
)

SMALLSAT_120KG = BodyPlatform(
    name="smallsat-120kg",
    agility=MagnitudeAgility(
        rate_max_deg_s=1.5, acceleration_max_deg_s2=0.12, jerk_max_deg_s3=0.06, settle_s=4.0
    ),
    off_nadir_max_deg=40.0,
    roll=LinesAcrossMotion(),
    idle=SunIdle(direction_body=(0.0, 0.0, -1.0)),
    inertia_kg_m2=((11.0, 0.1, 0.0), (0.1, 13.0, 0.0), (0.0, 0.0, 9.0)),
    torque_max_n_m=0.03,
    camera=PushbroomCamera(
        pixel_arcsec=0.275, pixels=8192, tdi_lines=64, line_rate_max_hz=12_000.0
    ),
    knowledge=PointingKnowledge(sigma_arcsec=15.0, jitter_arcsec=0.3),
    star_trackers=StarTrackers(
        needed=1,
        each=tuple(
            StarTracker(
                name=f"st{number}",
                boresight_body=(along, -0.6, -0.6245),
                sun_deg=35.0,
                moon_deg=10.0,
                limb_deg=22.0,
            )
            for number, along in ((1, 0.5), (2, -0.5))
        ),
    ),
    exclusions=(
        Exclusion(name="camera Sun", of="camera", away_from="sun", min_deg=30.0),
        Exclusion(name="glint", of="camera", away_from="glint", min_deg=8.0, when="imaging"),
    ),
)
