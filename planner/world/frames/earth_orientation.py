"""The Earth's orientation: ITRF and TEME against ECI (GCRF axes), EME2000 against GCRF.

IAU 2006/2000A precession-nutation with the IERS's UT1, polar motion and celestial pole
offsets.  Precession and nutation are computed every 6 h and interpolated by polynomials (within
1e-12 rad) to a 120 s grid, which they, pole and UT1 - TAI are interpolated from linearly (they bend
by less than 1e-9 arcsec in between); the rotation angle is computed at every instant.
"""

from datetime import UTC, datetime, timedelta
from functools import lru_cache

import erfa
import numpy as np

from planner.base.arrays import Array, cross
from planner.base.errors import OutsideCoverage
from planner.base.interpolation import NODES, lagrange_weights
from planner.world.frames.iers import earth_orientation_table
from planner.world.frames.time_scales import DAY_S, MJD_JD, TT_MINUS_TAI_S, Instants

# d(ERA)/d(UT1): IERS Conventions 2010, eq. 5.15
OMEGA_EARTH_RAD_S = 2.0 * np.pi * 1.00273781191135448 / DAY_S
NODE_STEP_S = 120.0
BLOCK_NODES = 180  # 6 h, between two instants at which the nutation's series are summed
BLOCKS_KEPT = 182  # 45 days, 2 MB
_MJD_EPOCH = datetime(1858, 11, 17, tzinfo=UTC)

# Mean equator and equinox of J2000.0 to GCRF: IERS Conventions 2010, 5.5.4 (frame bias, 23 mas)
C_GCRF_FROM_EME2000: Array = erfa.bp00(2451545.0, 0.0)[0].T.copy()
C_GCRF_FROM_EME2000.setflags(write=False)


def c_itrf_from_eci(instants: Instants) -> Array:
    """Rotation matrices from GCRF to ITRF axes, shape (n, 3, 3).

    Leaves out diurnal and semi-diurnal tides in pole and UT1 (3 cm on the ground at most).
    Raises OutsideCoverage before 1973; past the end of the IERS data see
    `earth_orientation_warnings`.  Source: IERS Conventions 2010, 5.4-5.5 (CIO based).
    """
    return _celestial_to_terrestrial(instants, _interpolate_nodes(instants))[0]


def c_itrf_from_teme(instants: Instants) -> Array:
    """Rotation matrices from SGP4's TEME to ITRF axes, shape (n, 3, 3).

    Source: Vallado 2006 (AIAA 2006-6753), appendix C: GMST 1982 of UT1, then polar motion.
    """
    parameters = _interpolate_nodes(instants)
    gmst_rad = _gmst_rad(instants, parameters)
    return np.asarray(erfa.c2tcio(np.eye(3), gmst_rad, erfa.pom00(*parameters[:, 4:7].T)))


def c_frame_from_eci(frame: str, instants: Instants) -> Array:
    """Rotation matrices from GCRF to the axes of ITRF, TEME, EME2000 or GCRF, shape (n, 3, 3)."""
    if frame == "ITRF":
        return c_itrf_from_eci(instants)
    if frame == "TEME":
        # By way of ITRF, where polar motion there and back leaves the difference of two angles.
        parameters = _interpolate_nodes(instants)
        turn_rad = _era_rad(instants, parameters) - _gmst_rad(instants, parameters)
        return np.asarray(erfa.c2tcio(_c_cirs_from_eci(parameters), turn_rad, np.eye(3)))
    c = C_GCRF_FROM_EME2000.T if frame == "EME2000" else np.eye(3)
    return np.broadcast_to(c, (len(instants), 3, 3))


def itrf_from_eci_state(
    r_eci_m: Array, v_eci_m_s: Array, instants: Instants
) -> tuple[Array, Array]:
    """Position and velocity relative to the rotating Earth, each (n, 3), in ITRF axes.

    Leaves out the motion of the Earth's axis itself (2e-5 m/s in low orbit).
    """
    c, omega_itrf_rad_s = _celestial_to_terrestrial(instants, _interpolate_nodes(instants))
    r_itrf_m = np.einsum("nij,nj->ni", c, r_eci_m)
    v_itrf_m_s = np.einsum("nij,nj->ni", c, v_eci_m_s) - cross(omega_itrf_rad_s, r_itrf_m)
    return r_itrf_m, v_itrf_m_s


def eci_from_itrf_state(
    r_itrf_m: Array, v_itrf_m_s: Array, instants: Instants
) -> tuple[Array, Array]:
    """Inverse of `itrf_from_eci_state`."""
    c, omega_itrf_rad_s = _celestial_to_terrestrial(instants, _interpolate_nodes(instants))
    v_inertial_itrf_m_s = v_itrf_m_s + cross(omega_itrf_rad_s, r_itrf_m)
    return np.einsum("nji,nj->ni", c, r_itrf_m), np.einsum("nji,nj->ni", c, v_inertial_itrf_m_s)


def eci_from_frame_state(
    frame: str, r_m: Array, v_m_s: Array, instants: Instants
) -> tuple[Array, Array]:
    """Position and velocity, each (n, 3), of a frame of `c_frame_from_eci`, in ECI.

    An ITRF velocity is relative to the rotating Earth; the slow turning of TEME is left out.
    """
    if frame == "ITRF":
        return eci_from_itrf_state(r_m, v_m_s, instants)
    c = c_frame_from_eci(frame, instants)
    return np.einsum("nji,nj->ni", c, r_m), np.einsum("nji,nj->ni", c, v_m_s)


def iers_data_end_utc() -> datetime:
    """Last day with UT1 and pole, the IERS's predictions included."""
    return _MJD_EPOCH + timedelta(days=float(earth_orientation_table().utc_mjd[-1]))


def earth_orientation_warnings(instants: Instants) -> tuple[str, ...]:
    """What to tell the user when instants lie past the end of the IERS data."""
    past_days = float(
        np.max(instants.utc_mjd(), initial=0.0) - earth_orientation_table().utc_mjd[-1]
    )
    if past_days <= 0.0:
        return ()
    return (
        f"Earth orientation data end on {iers_data_end_utc():%Y-%m-%d}, {past_days:.1f} days too "
        "early: the last values are held and the ground target may be off by about "
        f"{0.5 * past_days:.1f} m east or west; install a newer astropy-iers-data",
    )


def _celestial_to_terrestrial(instants: Instants, parameters: Array) -> tuple[Array, Array]:
    """Matrices (n, 3, 3) and the Earth's rotation vector in ITRF axes (n, 3), rad/s.

    parameters: as of `_interpolate_nodes`.
    """
    era_rad = _era_rad(instants, parameters)
    c_itrf_from_tirs = erfa.pom00(*parameters[:, 4:7].T)
    rate_rad_s = OMEGA_EARTH_RAD_S * (1.0 + parameters[:, 7])
    c_itrf_from_eci = erfa.c2tcio(_c_cirs_from_eci(parameters), era_rad, c_itrf_from_tirs)
    return np.asarray(c_itrf_from_eci), c_itrf_from_tirs[:, :, 2] * rate_rad_s[:, None]


def _c_cirs_from_eci(parameters: Array) -> Array:
    return np.asarray(erfa.c2ixys(parameters[:, 0], parameters[:, 1], parameters[:, 2]))


def _era_rad(instants: Instants, parameters: Array) -> Array:
    jd1, jd2 = instants.tai_jd()
    return np.asarray(erfa.era00(jd1, jd2 + parameters[:, 3] / DAY_S))


def _gmst_rad(instants: Instants, parameters: Array) -> Array:
    jd1, jd2 = instants.tai_jd()
    return np.asarray(erfa.gmst82(jd1, jd2 + parameters[:, 3] / DAY_S))


@lru_cache(maxsize=2)  # an orbit's states and what they are turned by ask for the same instants
def _interpolate_nodes(instants: Instants) -> Array:
    """Columns X, Y, s (rad), UT1 - TAI (s), xp, yp, s' (rad), d(UT1 - TAI)/dt, shape (n, 8)."""
    jd1, jd2 = instants.tai_jd()
    position = ((jd1 - MJD_JD) + jd2) * (DAY_S / NODE_STEP_S)
    cell = np.floor(position)
    cells, which = np.unique(cell, return_inverse=True)
    node_ticks = np.union1d(cells, cells + 1.0)
    first = np.searchsorted(node_ticks, cells)
    values = _at_nodes(node_ticks)
    slope = values[first + 1] - values[first]
    u = (position - cell)[:, None]
    at = np.asarray(values[first][which] + u * slope[which])
    return np.concatenate([at, slope[which, 3:4] / NODE_STEP_S], axis=1)


def _at_nodes(node_ticks: Array) -> Array:
    """Columns X, Y, s, UT1 - TAI, xp, yp, s' at ticks of 120 s of TAI, shape (m, 7)."""
    block, within = np.divmod(node_ticks.astype(np.int64), BLOCK_NODES)
    blocks, which = np.unique(block, return_inverse=True)
    kept = np.array([_node_block(int(number)) for number in blocks]).reshape(-1, BLOCK_NODES, 7)
    return np.asarray(kept[which, within])


@lru_cache(maxsize=BLOCKS_KEPT)
def _node_block(number: int) -> Array:
    """BLOCK_NODES neighbouring nodes; kept, since one plan asks for the same ones many times."""
    node_ticks = (number * BLOCK_NODES + np.arange(BLOCK_NODES)).astype(np.float64)
    epoch_utc = datetime(2000, 1, 1, tzinfo=UTC)
    tai_offset_s = node_ticks * NODE_STEP_S - (51544.0 * DAY_S + 32.0)  # TAI - UTC of that epoch
    utc_mjd = Instants(epoch_utc, tai_offset_s).utc_mjd()
    table = earth_orientation_table()
    if len(utc_mjd) and utc_mjd.min() < table.utc_mjd[0]:
        raise OutsideCoverage(
            "Earth orientation is not known before 1973-01-02 (finals2000A); use later times"
        )
    eop = table.at(utc_mjd)
    whole, rest = np.divmod(node_ticks * NODE_STEP_S, DAY_S)
    tt = (MJD_JD + whole, (rest + TT_MINUS_TAI_S) / DAY_S)
    around = np.arange(NODES) - NODES // 2 + 1
    weights = lagrange_weights(around - (np.arange(BLOCK_NODES) / BLOCK_NODES)[:, None])
    x, y, s = (weights @ [_nutation(number + int(block)) for block in around]).T
    return np.stack(
        [x + eop[:, 3], y + eop[:, 4], s, eop[:, 0], eop[:, 1], eop[:, 2], erfa.sp00(*tt)], axis=1
    )


@lru_cache(maxsize=BLOCKS_KEPT + NODES)
def _nutation(block: int) -> tuple[float, float, float]:
    """X, Y and s, the pole's offsets excluded, as a block begins."""
    days, rest_s = divmod(block * BLOCK_NODES * NODE_STEP_S, DAY_S)
    x, y, s = erfa.xys06a(MJD_JD + days, (rest_s + TT_MINUS_TAI_S) / DAY_S)
    return float(x), float(y), float(s)
