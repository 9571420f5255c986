"""Reach of a horizon sensor in visible light and in the infrared, and how often it sees.

The infrared limb is that of carbon dioxide at 14 to 16 um, by day and night: 30 to 40 km high
(Seshamani, Jain, Kamalakar 1990), taken as spread evenly between.
"""

from dataclasses import dataclass
from datetime import timedelta

import numpy as np
from horizon_cases import ring
from scipy.spatial.transform import Rotation

from estimator.prediction import predict_horizon
from estimator.request import Body, Position
from estimator.surroundings import Surroundings
from planner.world.frames.geodesy import MU_EARTH_M3_S2
from reproduction.lomaka_rendered import EPOCH

RADIUS_M = 6878e3
INCLINATION_DEG, NODE_DEG = 51.6, 10.0  # on 20 March the Sun is near this plane
INSTANTS = 36
INFRARED = Body(limb_height_km=35.0, limb_height_sigma_km=2.9)


@dataclass(frozen=True, kw_only=True)
class Bands:
    """Over one orbit at 500 km, two cameras 60 deg wide that look at the horizon: ahead and aside.

    visible_share, infrared_share: of instants at which both see a usable limb.
    sunlit_frames: share of frames with the Sun in them.
    visible_sigma_deg, infrared_sigma_deg: median expected error of the nadir from one camera.
    """

    visible_share: float
    infrared_share: float
    sunlit_frames: float
    visible_sigma_deg: float
    infrared_sigma_deg: float


def over_an_orbit() -> Bands:
    """Predict both bands' views along an orbit, the craft level."""
    period_s = 2.0 * np.pi * np.sqrt(RADIUS_M**3 / MU_EARTH_M3_S2)
    usable, sigmas, sunny = np.zeros((2, INSTANTS)), np.full((2, INSTANTS), np.nan), []
    for k, phase in enumerate(np.linspace(0.0, 2.0 * np.pi, INSTANTS, endpoint=False)):
        plane = Rotation.from_euler(
            "ZXZ", [NODE_DEG, INCLINATION_DEG, np.rad2deg(phase)], degrees=True
        )
        position_km = plane.apply([RADIUS_M / 1e3, 0.0, 0.0])
        x_eci, z_eci = plane.apply([0.0, 1.0, 0.0]), -position_km / np.linalg.norm(position_km)
        axes = np.stack([x_eci, np.cross(z_eci, x_eci), z_eci])
        for band, body in enumerate((Body(), INFRARED)):
            around = Surroundings(
                EPOCH + timedelta(seconds=float(phase / (2.0 * np.pi) * period_s)),
                Position(frame="GCRF", position_km=tuple(position_km.tolist())),
                body,
            )
            views = [
                predict_horizon(one, around, Rotation.from_matrix(axes), 0.5) for one in ring(2)
            ]
            usable[band, k] = all(view.reason is None for view in views)
            known = [view.sigma_rad for view in views if view.sigma_rad is not None]
            if known:
                sigmas[band, k] = np.rad2deg(np.mean(known))
            if band == 0:
                sunny += [view.sun_in_frame for view in views]
    return Bands(
        visible_share=float(usable[0].mean()),
        infrared_share=float(usable[1].mean()),
        sunlit_frames=float(np.mean(sunny)),
        visible_sigma_deg=float(np.nanmedian(sigmas[0])),
        infrared_sigma_deg=float(np.nanmedian(sigmas[1])),
    )
