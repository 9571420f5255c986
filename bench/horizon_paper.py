"""What are the errors of the paper's two-camera method over pitch and yaw?  Its Figs. 3, 5, 6.

Run: OMP_NUM_THREADS=1 python bench/horizon_paper.py
Fig. 3 is a map of the error over yaw and pitch; Figs. 5 and 6 sweep pitch alone.  The limb is
the paper's: sharp and everywhere at one height.  Beside it stands the product's estimator.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
from horizon_cases import ring
from horizon_paper_method import paper_nadir
from scipy.spatial.transform import Rotation

from estimator.pipeline import estimate_vertical
from estimator.rendering.scene import HorizonRenderer, Scene
from estimator.rendering.sensor import Sensor
from estimator.request import Body, HorizonRequest, Position, PredictedAttitude
from estimator.surroundings import Surroundings

EPOCH = datetime(2026, 3, 20, 12, tzinfo=UTC)
POSITION = Position(frame="ITRF", position_km=(6878.0, 0.0, 0.0))
LEVEL = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])
SCENE = Scene(constant_limb_m=17.5e3, cloud_cover=0.0, land=0.0)


def errors_deg(pitch_deg: float, yaw_deg: float) -> tuple[float, float, float]:
    """Of the chord as printed, the chord on unit rays, and the estimator; NaN when refused."""
    around = Surroundings(EPOCH, POSITION, Body())
    tilt = Rotation.from_euler("xy", [yaw_deg, pitch_deg], degrees=True).as_matrix()
    c_body_from_itrf = tilt @ LEVEL
    cameras = ring(2)
    horizon = HorizonRenderer(around.limb.r_itrf_m, c_body_from_itrf, around.sun_itrf, SCENE, 3)
    images = [horizon.picture(c, Sensor()) for c in cameras]
    truth = c_body_from_itrf @ around.limb.nadir_itrf
    q = Rotation.from_matrix(c_body_from_itrf @ around.c_itrf_from_eci).as_quat()
    request = HorizonRequest(epoch=EPOCH, position=POSITION, cameras=cameras)
    told = PredictedAttitude(q_body_from_eci_xyzw=tuple(q.tolist()), sigma_deg=1.0)
    answer = estimate_vertical(images, replace(request, predicted=told))
    nadirs = [paper_nadir(images, cameras, unit_rays) for unit_rays in (False, True)]
    nadirs.append(answer.geocentric.nadir_body if answer.geocentric else None)
    printed, unit, ours = (
        np.nan if n is None else float(np.rad2deg(np.linalg.norm(np.cross(n, truth))))
        for n in nadirs
    )
    return printed, unit, ours


def main() -> None:
    angles = np.array([-12.0, -6.0, 0.0, 6.0, 12.0])
    table = np.array([[errors_deg(pitch, yaw) for pitch in angles] for yaw in angles])
    for k, name in enumerate(("chord as printed", "chord on unit rays", "estimator")):
        print(f"Fig. 3, {name}: error in deg; rows yaw, columns pitch {angles.astype(int)}")
        for yaw, row in zip(angles, table[:, :, k], strict=True):
            print(f"  {yaw:5.0f}  " + "  ".join(f"{error:7.4f}" for error in row))
    sweep = np.array([errors_deg(pitch, 0.0) for pitch in np.arange(-14.0, 14.1, 2.0)])
    rms = np.sqrt(np.nanmean(sweep**2, axis=0))
    print(
        f"Figs. 5-6, pitch -14..14 deg, rms: as printed {rms[0]:.3f}, unit rays {rms[1]:.3f}, "
        f"estimator {rms[2]:.4f} deg; the paper: 0.038 (model), 0.752 (experiment)"
    )


if __name__ == "__main__":
    main()
