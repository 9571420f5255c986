"""The judge passes an exact table made with ERFA, and finds pointing that is off."""

import dataclasses
from datetime import timedelta

import erfa
import numpy as np
import pytest
from judged_tables import (
    ARCSEC_RAD,
    ATTITUDE,
    EPOCH_UTC,
    FIRST_ROW,
    LAS_VEGAS,
    LAST_ROW,
    ORACLE_RAD,
    CircularOrbit,
    apparent_eci,
    changed,
    only,
    q_platform_from_eci,
    r_target_eci_m,
    scenario_of,
    table_of,
)
from scipy.spatial.transform import Rotation

from planner.verification import verify
from planner.world.attitude.inertial import InertialAttitude
from planner.world.attitude.lvlh import LvlhAttitude
from planner.world.frames.time_scales import Instants
from planner.world.platforms import ISS_HRC
from planner.world.targets import EarthFixedTarget, SessionTarget

TILTED_MOUNT = dataclasses.replace(
    ISS_HRC,
    q_platform_from_body_xyzw=tuple(Rotation.from_rotvec([0.02, -0.06, 0.4]).as_quat().tolist()),
)
SPINNING = InertialAttitude(
    epoch=EPOCH_UTC - timedelta(seconds=300),
    q_body_from_eci_xyzw=(0.1, 0.7, -0.5, 0.5),
    omega_body_deg_s=(0.01, -0.064, 0.002),
)


@pytest.mark.parametrize(
    ("attitude", "platform"),
    [(LvlhAttitude(), ISS_HRC), (ATTITUDE, ISS_HRC), (ATTITUDE, TILTED_MOUNT)],
    ids=["lvlh", "yaw-pitch-roll", "mount"],
)
def test_a_table_made_with_erfa_passes(attitude, platform):
    scenario = scenario_of(attitude=attitude, platform=platform)
    report = verify(table_of(scenario), scenario)
    assert report.passed, report.findings
    assert report.findings == ()
    assert report.taken_as_given == ("orbit",)
    session = report.sessions[0]
    assert session.max_rad < ORACLE_RAD
    assert session.start_utc == EPOCH_UTC + timedelta(seconds=60)
    assert session.stop_utc == EPOCH_UTC + timedelta(seconds=100)


def test_an_inertial_attitude_turns_as_scipy_turns_it():
    scenario = scenario_of(attitude=SPINNING)
    report = verify(table_of(scenario), scenario)
    assert report.sessions[0].max_rad < ORACLE_RAD


def test_range_and_elevation_are_those_of_erfas_positions(scenario, table):
    view = verify(table, scenario).sessions[0]
    t_s = np.arange(1200, 2001) / 20.0
    r_target_m = r_target_eci_m(LAS_VEGAS, t_s)
    to_sat_m = scenario.orbit.states(Instants(EPOCH_UTC, t_s)).r_sat_eci_m - r_target_m
    range_m = np.linalg.norm(to_sat_m, axis=1)
    assert view.range_min_m == pytest.approx(range_m.min(), abs=0.01)  # dX, dY: 1 cm
    assert view.range_max_m == pytest.approx(range_m.max(), abs=0.01)
    nearest_s = float(t_s[np.argmin(range_m)])
    assert view.closest_at_utc == EPOCH_UTC + timedelta(seconds=nearest_s)
    # geodetic and geocentric verticals differ by 0.184 deg at 36 deg latitude
    sine = np.sum(to_sat_m * r_target_m, axis=1) / range_m / np.linalg.norm(r_target_m, axis=1)
    assert view.elevation_min_rad == pytest.approx(np.arcsin(sine.min()), abs=np.deg2rad(0.184))
    assert view.elevation_min_utc == EPOCH_UTC + timedelta(seconds=60)


@pytest.mark.parametrize("row", [FIRST_ROW, 401, LAST_ROW])
def test_a_row_off_by_a_fifth_of_an_arcsecond_is_found_at_its_row(scenario, table, row):
    # beta turns the boresight itself, alpha by the sine of its distance from the axis
    report = verify(changed(table, 1, row, angle_rad=0.2 * ARCSEC_RAD), scenario)
    finding = only(report, "pointing")
    assert finding.t_s == pytest.approx(row / 5.0, abs=1e-9)
    assert finding.at_utc == EPOCH_UTC + timedelta(seconds=row / 5.0)
    session = report.sessions[0]
    assert session.rows_max_rad == pytest.approx(0.2 * ARCSEC_RAD, abs=ORACLE_RAD)
    across_m = session.across_max_m
    assert 0.2 * ARCSEC_RAD * session.range_min_m * 0.97 < across_m
    assert across_m < 0.2 * ARCSEC_RAD * session.range_max_m * 1.03
    # the sine of the elevation bounds how far a miss stretches on the ground
    assert across_m * (1 - 1e-9) <= session.ground_max_m
    assert session.ground_max_m <= across_m / np.sin(session.elevation_min_rad)


@pytest.mark.parametrize(("off_arcsec", "passes"), [(0.09, True), (0.11, False)])
def test_a_tenth_of_an_arcsecond_is_the_limit(scenario, table, off_arcsec, passes):
    off = changed(table, 1, 401, angle_rad=off_arcsec * ARCSEC_RAD)
    assert verify(off, scenario).passed is passes


def test_where_a_session_content_with_nearness_is_off_its_target_is_said(scenario, table):
    """One row 1 arcsec off bends the cells beside it, 0.16 arcsec already a quarter in."""
    near = dataclasses.replace(scenario.sessions[0], keyhole="nearest")
    off = changed(table, 1, 401, angle_rad=ARCSEC_RAD)
    report = verify(off, dataclasses.replace(scenario, sessions=(near,)))
    assert report.passed  # the frame is 1,000 times as wide
    (warning,) = report.findings
    assert (warning.severity, warning.limit, warning.t_s) == ("warning", "pointing", 80.2)
    (stretch,) = report.sessions[0].off_target
    # Off at each instant judged between the rows beside it, which are on target.
    assert stretch.start_utc == EPOCH_UTC + timedelta(seconds=80.0)
    assert stretch.stop_utc == EPOCH_UTC + timedelta(seconds=80.4)
    assert stretch.max_rad == pytest.approx(ARCSEC_RAD, abs=ORACLE_RAD)


def test_the_miss_on_the_ground_is_where_the_boresight_meets_the_targets_plane():
    scenario = scenario_of(orbit=CircularOrbit(beside_deg=9.0))  # some 18 deg elevation
    table = changed(table_of(scenario), 1, slice(None), angle_rad=3.0 * ARCSEC_RAD)
    view = verify(table, scenario).sessions[0]

    t_s = table.t_s[FIRST_ROW:]
    r_target_m = r_target_eci_m(LAS_VEGAS, t_s)
    range_m = np.linalg.norm(
        scenario.orbit.states(Instants(EPOCH_UTC, t_s)).r_sat_eci_m - r_target_m, axis=1
    )
    alpha, beta = table.position[FIRST_ROW:].T
    outer, inner = ISS_HRC.axes_platform
    boresight = (
        q_platform_from_eci(scenario, t_s).inv()
        * Rotation.from_rotvec(alpha[:, None] * outer)
        * Rotation.from_rotvec(beta[:, None] * inner)
    ).apply([0.0, 0.0, 1.0])
    los = apparent_eci(scenario.orbit, LAS_VEGAS, t_s)
    # the vertical: the way to a point straight above
    up = r_target_eci_m(dataclasses.replace(LAS_VEGAS, height_m=1610.0), t_s) - r_target_m
    meets = (np.sum(los * up, axis=1) / np.sum(boresight * up, axis=1))[:, None] * boresight
    expected_m = (range_m * np.linalg.norm(meets - los, axis=1)).max()
    assert expected_m > 1.5 * view.across_max_m
    # 5 mas of the oracle's Earth orientation in 3 arcsec
    assert view.ground_max_m == pytest.approx(expected_m, rel=2e-3)


def test_a_wrong_rate_is_found_between_the_rows(scenario, table):
    wrong_rad_s = np.deg2rad(0.01)
    session = verify(changed(table, 1, 401, rate_rad_s=wrong_rad_s), scenario).sessions[0]
    assert session.rows_max_rad < ORACLE_RAD
    # the Hermite's rate function u(1-u)^2 h at u = 1/4, the nearest judged instant to its peak
    bulge_rad = 0.25 * 0.75**2 * 0.2 * wrong_rad_s
    assert session.between_rows_max_rad == pytest.approx(bulge_rad, abs=ORACLE_RAD)
    assert session.max_t_s in (pytest.approx(80.15), pytest.approx(80.25))


@pytest.mark.parametrize(
    ("light", "arcsec"),
    [
        # the ground at 36 deg moves 375 m/s for 1.5 ms: 0.56 m over 449 km
        ({"light_time": 0.0}, pytest.approx(0.257, abs=0.01)),
        ({"light_time": -1.0}, pytest.approx(0.515, abs=0.02)),
        # v/c of 7.66 km/s, nearly across the line of sight
        ({"aberration": 0.0}, pytest.approx(5.27, abs=0.02)),
        ({"aberration": -1.0}, pytest.approx(10.55, abs=0.04)),
    ],
)
def test_a_light_correction_dropped_or_turned_over_is_found(scenario, light, arcsec):
    report = verify(table_of(scenario, **light), scenario)
    only(report, "pointing")
    assert report.sessions[0].max_rad / ARCSEC_RAD == arcsec


@pytest.mark.parametrize("column", [0, 1])
def test_an_axis_with_the_other_sign_is_found(scenario, table, column):
    sign = np.where(np.arange(2) == column, -1.0, 1.0)
    turned = dataclasses.replace(
        table, position=table.position * sign, rate_rad_s=table.rate_rad_s * sign
    )
    report = verify(turned, scenario)
    only(report, "pointing")
    assert report.sessions[0].max_rad > np.deg2rad(1.0)


@pytest.mark.parametrize("name", ["yaw_deg", "pitch_deg", "roll_deg"])
def test_an_attitude_angle_with_the_other_sign_is_found(scenario, table, name):
    other = dataclasses.replace(ATTITUDE, **{name: -getattr(ATTITUDE, name)})
    only(verify(table, scenario_of(attitude=other)), "pointing")


def test_the_other_end_of_the_mount_is_found():
    scenario = scenario_of(platform=TILTED_MOUNT)
    x, y, z, w = TILTED_MOUNT.q_platform_from_body_xyzw
    conjugate = dataclasses.replace(TILTED_MOUNT, q_platform_from_body_xyzw=(-x, -y, -z, w))
    only(verify(table_of(scenario), scenario_of(platform=conjugate)), "pointing")


def test_a_target_below_the_elevation_asked_for_is_found(table):
    asked = dataclasses.replace(LAS_VEGAS, min_elevation_deg=60.0)
    report = verify(table, scenario_of(target=asked))
    finding = only(report, "elevation")
    assert finding.at_utc == report.sessions[0].elevation_min_utc
    assert finding.t_s == pytest.approx(60.0)  # the session's far end: overhead is at 85 s


def test_a_target_behind_the_earth_is_found(table):
    report = verify(table, scenario_of(orbit=CircularOrbit(opposite=True)))
    assert only(report, "occlusion").t_s == pytest.approx(60.0)
    only(report, "elevation")
    assert report.sessions[0].ground_max_m is None


@dataclasses.dataclass(frozen=True)
class SurveyedPoint(EarthFixedTarget):
    """A further Earth-fixed mode, unknown to the judge."""

    r_itrf_m: tuple[float, float, float]
    min_elevation_deg: float = 0.0
    refraction: str = "none"

    def r_target_itrf_m(self, instants):
        return np.broadcast_to(self.r_itrf_m, (len(instants), 3))


def test_a_new_earth_fixed_mode_needs_no_change_of_the_judge(table):
    r_itrf_m = erfa.gd2gc(
        1, np.deg2rad(LAS_VEGAS.longitude_deg), np.deg2rad(LAS_VEGAS.latitude_deg), 610.0
    )
    report = verify(table, scenario_of(target=SurveyedPoint(r_itrf_m=tuple(r_itrf_m))))
    assert report.passed
    assert report.taken_as_given == ("orbit", "target")


def test_a_target_the_judge_cannot_derive_never_passes(table):
    elsewhere = scenario_of(target=SessionTarget())
    report = verify(table, elsewhere)
    assert "can't derive" in only(report, "pointing").detail
    assert report.sessions == ()


def test_an_attitude_law_without_a_derivation_is_said_to_be_taken_as_given(table):
    class OtherLaw:
        def q_body_from_eci(self, instants, states):
            return ATTITUDE.q_body_from_eci(instants, states)

    report = verify(table, scenario_of(attitude=OtherLaw()))
    assert report.passed
    assert report.taken_as_given == ("orbit", "attitude")
