"""The only times at which the carrier could stand high enough above points on the ground."""

import numpy as np

from planner.arrays import Array
from planner.opportunities.carrier import Carrier
from planner.opportunities.spans import Nodes

PLUMB_RAD = 0.0034  # geodetic against geocentric vertical: 0.1924 deg at most
SINGLE_RAD = 1e-3  # what single precision leaves of an angle's cosine, at its worst near 0
BEYOND = 2  # rows, so that a pass at the end of the span still shows three


def candidate_nodes(carrier: Carrier, r_target_itrf_m: Array, min_elevation_rad: Array) -> Nodes:
    """Rows of the orbit around every instant at which a target may be visible.

    r_target_itrf_m: (k, 3), at rest.  Each group of nodes reaches two rows beyond both
    ends of visibility, or to the end of the span.  The Earth's central angle to a carrier at
    distance r, seen at elevation e from distance R, is acos(R cos e / r) - e.
    """
    r_sat_m = carrier.r_sat_itrf_m.at(carrier.node_s)
    distance_m = np.linalg.norm(r_sat_m, axis=1)
    ground_m = np.linalg.norm(r_target_itrf_m, axis=1)
    least_rad = min_elevation_rad - PLUMB_RAD
    cosine = np.minimum(ground_m * np.cos(least_rad) / distance_m.max(), 1.0)
    step_s = carrier.node_s[1] - carrier.node_s[0]
    between_rad = 0.5 * step_s * carrier.turn_max_rad_s
    central_rad = np.arccos(cosine) - least_rad + between_rad + SINGLE_RAD

    to_sat = (r_sat_m / distance_m[:, None]).astype(np.float32)
    to_target = (r_target_itrf_m / ground_m[:, None]).astype(np.float32)
    near = to_target @ to_sat.T > np.cos(np.minimum(central_rad, np.pi))[:, None].astype(np.float32)
    wider = near.copy()
    for rows in range(1, BEYOND + 1):
        wider[:, rows:] |= near[:, :-rows]
        wider[:, :-rows] |= near[:, rows:]
    target, row = np.divmod(np.flatnonzero(wider), wider.shape[1])
    begins = np.append(True, (target[1:] != target[:-1]) | (row[1:] != row[:-1] + 1))
    begins = begins[: len(target)]
    return Nodes(target=target[begins], group=np.cumsum(begins) - 1, t_s=carrier.node_s[row])
