"""The judge of a body passes a table made by others' code, and finds each fault put into it."""

import dataclasses
import math
from importlib.resources import files

import numpy as np
import pytest
from judged_bodies import AGILITY, BODY, ORBIT, body_scenario, body_table, unit, with_rows
from judged_tables import ARCSEC_RAD, EPOCH_UTC, LAS_VEGAS, apparent_eci
from scipy.interpolate import BPoly
from scipy.spatial.transform import Rotation, RotationSpline
from skyfield.api import load, load_file
from skyfield.framelib import ICRS

from planner.base.commands import COMMAND_STEP_S
from planner.verification import verify
from planner.verification.platforms.body import exclusions as body_exclusions
from planner.verification.platforms.body import judge as body_judge
from planner.verification.platforms.body.judge import BodyJudge
from planner.verification.platforms.body.quintic import motion_between
from planner.verification.surroundings import Surroundings, mirror_direction
from planner.world.conditions import Conditions
from planner.world.frames.time_scales import Instants, shifted_utc
from planner.world.platforms.body import (
    AxisAgility,
    AzimuthRoll,
    Exclusion,
    NearestRoll,
    PushbroomCamera,
    StarTracker,
    StarTrackers,
    SunSide,
)
from planner.world.platforms.gyros import GyroSet, GyroTurns, ScissoredPairs
from planner.world.targets import StationTarget

INERTIA_KG_M2 = ((11.0, 0.1, 0.0), (0.1, 13.0, 0.0), (0.0, 0.0, 9.0))
BY_AXIS = AxisAgility(
    rate_max_deg_s=(2.0, 2.0, 2.0),
    acceleration_max_deg_s2=(0.15, 0.15, 0.15),
    jerk_max_deg_s3=(0.05, 0.05, 0.05),
)


@pytest.fixture(scope="module")
def table():
    return body_table()


def limits_of(report):
    return {finding.limit for finding in report.findings}


def with_body(**fields):
    return body_scenario(dataclasses.replace(BODY, **fields))


def test_a_table_by_other_code_passes(table):
    report = verify(table, body_scenario(final_state=None))
    assert report.passed
    assert report.findings == ()
    assert report.taken_as_given == ("orbit",)
    (session,) = report.sessions
    assert session.max_rad < 0.01 * ARCSEC_RAD  # ERFA's full series against the judge's nodes


def test_between_rows_it_flies_the_quintic_of_the_parameters(table):
    """SciPy's parameters and its polynomial through both rows' values and derivatives."""
    cell, u_s = np.array([170, 170, 171]), np.array([0.03, 0.17, 0.1])
    motion = motion_between(table.position, table.rate_rad_s, table.acceleration_rad_s2, cell, u_s)
    q = Rotation.from_quat(table.position)
    for number, (row, into_s) in enumerate(zip(cell, u_s, strict=True)):
        turn = (q[row].inv() * q[row + 1]).as_mrp()
        # their derivatives at the second row, by differences of how SciPy composes turns
        step_s = 1e-3
        omega, alpha = table.rate_rad_s[row + 1], table.acceleration_rad_s2[row + 1]
        near = [
            (
                Rotation.from_mrp(turn) * Rotation.from_rotvec(omega * s + alpha * s**2 / 2.0)
            ).as_mrp()
            for s in (-step_s, 0.0, step_s)
        ]
        end = [
            turn,
            (near[2] - near[0]) / (2 * step_s),
            (near[2] - 2 * near[1] + near[0]) / step_s**2,
        ]
        start = [np.zeros(3), table.rate_rad_s[row] / 4.0, table.acceleration_rad_s2[row] / 4.0]
        curve = BPoly.from_derivatives([0.0, COMMAND_STEP_S], [start, end])
        expected = q[row] * Rotation.from_mrp(curve(into_s))
        off = (expected.inv() * Rotation.from_quat(motion.q_eci_from_body_xyzw[number])).magnitude()
        assert off < 1e-3 * ARCSEC_RAD
        later = q[row] * Rotation.from_mrp(curve(into_s + 1e-4))
        sooner = q[row] * Rotation.from_mrp(curve(into_s - 1e-4))
        omega = (sooner.inv() * later).as_rotvec() / 2e-4
        assert motion.omega_body_rad_s[number] == pytest.approx(omega, abs=1e-7)
        q_at = expected
        ahead, behind = (q_at.inv() * later).as_rotvec(), (q_at.inv() * sooner).as_rotvec()
        alpha = (ahead + behind) / 1e-8
        assert motion.alpha_body_rad_s2[number] == pytest.approx(alpha, abs=1e-5)


@pytest.mark.parametrize(
    ("kind", "share"), [("rate", 0.999), ("acceleration", 0.99), ("jerk", 0.999)]
)
@pytest.mark.parametrize("by_axis", [False, True])
def test_a_limit_just_below_what_is_flown_is_broken(table, kind, share, by_axis):
    """Also by axis, where only one is below."""
    margins = verify(table, body_scenario()).limits
    (margin,) = [margin for margin in margins if margin.kind == kind]
    name = {"rate": "rate_max_deg_s", "acceleration": "acceleration_max_deg_s2"}.get(
        kind, "jerk_max_deg_s3"
    )
    if by_axis:
        names = ("rate_max_deg_s", "acceleration_max_deg_s2", "jerk_max_deg_s3")
        free = {one: (getattr(AGILITY, one),) * 3 for one in names}
        by_axis_margins = verify(table, with_body(agility=AxisAgility(**free))).limits
        worst = min((m for m in by_axis_margins if m.kind == kind), key=lambda m: m.margin)
        bounds = list(free[name])
        bounds["xyz".index(worst.axis)] = math.degrees(abs(worst.extreme)) * share
        agility = AxisAgility(**{**free, name: tuple(bounds)})
        expected_axis = worst.axis
    else:
        most = math.degrees(margin.extreme)
        agility = dataclasses.replace(AGILITY, **{name: most * share})
        expected_axis = "body"
    (finding,) = verify(table, with_body(agility=agility)).findings
    assert (finding.limit, finding.axis) == (kind, expected_axis)


def test_the_rate_between_rows_is_judged():
    """Rows at 1 deg/s either side of a faster middle."""
    table = body_table()
    h, peak = COMMAND_STEP_S, np.deg2rad(1.0)
    alpha = np.deg2rad(0.05)
    turn = peak * h + alpha * h**2 / 6.0  # of a rate peak + alpha u (h - u) / h
    table = dataclasses.replace(
        table,
        position=Rotation.from_rotvec([[0, 0, 0], [turn, 0, 0]]).as_quat(),
        rate_rad_s=np.array([[peak, 0, 0]] * 2),
        acceleration_rad_s2=np.array([[alpha, 0, 0], [-alpha, 0, 0]]),
    )
    (rate,) = [m for m in BodyJudge(table, body_scenario()).margins() if m.kind == "rate"]
    assert rate.extreme == pytest.approx(peak + alpha * h / 4.0, rel=1e-6)
    assert rate.t_s == pytest.approx(0.1)


MUTANTS = {
    "rate of the other sign": lambda t: dataclasses.replace(t, rate_rad_s=-t.rate_rad_s),
    "attitude turned over": lambda t: dataclasses.replace(
        t, position=t.position * [-1.0, -1.0, -1.0, 1.0]
    ),
    "scalar first": lambda t: dataclasses.replace(t, position=np.roll(t.position, 1, axis=1)),
    "rates in the other order": lambda t: dataclasses.replace(t, rate_rad_s=t.rate_rad_s[:, ::-1]),
    "rates in ECI": lambda t: dataclasses.replace(
        t, rate_rad_s=Rotation.from_quat(t.position).apply(t.rate_rad_s)
    ),
    "accelerations of the other sign": lambda t: dataclasses.replace(
        t, acceleration_rad_s2=-t.acceleration_rad_s2
    ),
    "rates in degrees": lambda t: dataclasses.replace(t, rate_rad_s=np.rad2deg(t.rate_rad_s)),
    "a row late": lambda t: dataclasses.replace(
        t,
        **{
            name: np.concatenate([getattr(t, name)[:1], getattr(t, name)[:-1]])
            for name in ("position", "rate_rad_s", "acceleration_rad_s2")
        },
    ),
    "one rate too high": lambda t: with_rows(t, 150, rate_rad_s=[0.0, 1e-4, 0.0]),
    "one attitude off": lambda t: with_rows(t, 150, position=[0.0, 1e-7, 0.0, 0.0]),
    "one acceleration off": lambda t: with_rows(t, 150, acceleration_rad_s2=[2e-3, 0.0, 0.0]),
    "not unit": lambda t: dataclasses.replace(t, position=t.position * 1.00001),
    "a sign that flips": lambda t: dataclasses.replace(
        t, position=np.concatenate([t.position[:200], -t.position[200:]])
    ),
    "no number": lambda t: with_rows(t, 17, rate_rad_s=[np.nan, 0.0, 0.0]),
    "short of a row": lambda t: dataclasses.replace(t, rate_rad_s=t.rate_rad_s[1:]),
    "no accelerations": lambda t: dataclasses.replace(t, acceleration_rad_s2=None),
    "other columns": lambda t: dataclasses.replace(t, channels=t.channels[::-1]),
}


@pytest.mark.parametrize("mutate", MUTANTS.values(), ids=MUTANTS.keys())
def test_a_mutant_is_found(table, mutate):
    report = verify(mutate(table), body_scenario())
    assert not report.passed
    assert limits_of(report) & {"table", "motion", "pointing", "initial_state"}


@pytest.mark.parametrize(("off_arcsec", "passes"), [(0.08, True), (0.15, False), (-3.0, False)])
def test_a_shifted_target_is_found(off_arcsec, passes):
    report = verify(body_table(off_arcsec * ARCSEC_RAD), body_scenario())
    assert report.passed is passes
    assert limits_of(report) == (set() if passes else {"pointing"})
    (session,) = report.sessions
    assert session.max_rad == pytest.approx(abs(off_arcsec) * ARCSEC_RAD, rel=0.1)


@pytest.mark.parametrize(("settle_s", "passes"), [(0.0, True), (2.0, True), (4.0, False)])
def test_the_camera_stands_on_the_target_while_it_settles(table, settle_s, passes):
    """The session begins at 60 s, the slew ends at 58."""
    settling = with_body(agility=dataclasses.replace(AGILITY, settle_s=settle_s))
    assert limits_of(verify(table, settling)) == (set() if passes else {"pointing"})


@pytest.mark.parametrize("column", ["position", "rate_rad_s", "acceleration_rad_s2"])
def test_cells_left_out_hold_no_extreme(table, column, monkeypatch):
    """Beside every cell looked into, on rows that are off by 1e-7 to 1e-2 in one column."""
    rng = np.random.default_rng(44)
    every = dataclasses.replace(body_judge.OPTIONS, turn_within=1e99, rate_within=1e99)
    for scale in np.logspace(-7.0, -2.0, 11):
        rows = rng.integers(0, len(table.t_s), 4)
        off = scale * rng.normal(size=(4, getattr(table, column).shape[1]))
        spoiled = with_rows(table, rows, **{column: off})
        for agility in (AGILITY, BY_AXIS):
            body = dataclasses.replace(BODY, agility=agility)
            told = BodyJudge(spoiled, body_scenario(body)).margins()
            with monkeypatch.context() as patched:
                patched.setattr(body_judge, "OPTIONS", every)
                whole = BodyJudge(spoiled, body_scenario(body)).margins()
            assert [one.extreme for one in told] == [one.extreme for one in whole]


def test_off_nadir_is_counted_at_the_target(table):
    t_s = np.arange(300, 501) / 5.0
    los, states = apparent_eci(ORBIT, LAS_VEGAS, t_s), ORBIT.states(Instants(EPOCH_UTC, t_s))
    most_deg = math.degrees(np.arccos(np.sum(los * unit(-states.r_sat_eci_m), axis=1)).max())
    assert verify(table, with_body(off_nadir_max_deg=most_deg + 1e-3)).passed
    (finding,) = verify(table, with_body(off_nadir_max_deg=most_deg - 1e-3)).findings
    assert finding.limit == "off_nadir"


@pytest.mark.parametrize(("off_arcsec", "passes"), [(7.0, True), (-15.0, False), (30.0, False)])
def test_a_camera_off_its_roll_rule_is_found(off_arcsec, passes):
    """The pointing is as it was: the turn is about the boresight."""
    report = verify(body_table(roll_rad=off_arcsec * ARCSEC_RAD), body_scenario())
    assert report.passed is passes
    assert limits_of(report) == (set() if passes else {"roll"})


@pytest.mark.parametrize(
    "rule",
    [NearestRoll(), AzimuthRoll(azimuth_deg=90.0), SunSide(direction_body=(1.0, 0.0, 0.0))],
    ids=lambda rule: rule.rule,
)
def test_another_rule_than_the_one_flown_is_broken(table, rule):
    assert limits_of(verify(table, with_body(roll=rule))) == {"roll"}


def test_a_line_lies_square_to_the_motion_and_not_against_it(table):
    """A frame may be flown against it, and a line that sums up both ways; another may not."""
    lines = PushbroomCamera(pixel_arcsec=0.275, pixels=8192, line_body=(0.0, -1.0, 0.0))
    assert limits_of(verify(table, with_body(camera=lines))) == {"roll"}
    both = dataclasses.replace(lines, both_ways=True)
    assert verify(table, with_body(camera=both)).passed
    aside = dataclasses.replace(both, line_body=(1.0, 0.0, 0.0))
    assert limits_of(verify(table, with_body(camera=aside))) == {"roll"}


def test_the_end_is_the_idle_attitude_where_asked(table):
    report = verify(table, body_scenario(final_state="idle"))
    assert limits_of(report) == {"final_state"}
    idle = body_table(last_s=4.0)  # before it leaves the idle attitude
    judge = BodyJudge(idle, body_scenario(final_state="idle"))
    assert list(judge.row_findings()) == []
    over = body_scenario(final_state="idle", final_by=shifted_utc(table.epoch_utc, 3.0))
    assert any("by when" in finding.detail for finding in verify(table, over).findings)
    turned = with_rows(table, 0, rate_rad_s=[0.0, 3e-7, 0.0])
    assert "initial_state" in limits_of(verify(turned, body_scenario()))


def test_the_begin_is_the_motion_asked_for(table):
    """SciPy's inverse of the first row; the table's own start is idle, and any motion of it."""
    q_xyzw = tuple(Rotation.from_quat(table.position[0]).inv().as_quat().tolist())
    told = np.degrees([table.rate_rad_s[0], table.acceleration_rad_s2[0]]).tolist()
    asked = dataclasses.replace(
        body_scenario().initial_state,
        q_body_from_eci_xyzw=q_xyzw,
        omega_body_deg_s=tuple(told[0]),
        alpha_body_deg_s2=tuple(told[1]),
    )

    def judged(**changes):
        begin = dataclasses.replace(asked, **changes)
        scenario = dataclasses.replace(body_scenario(), initial_state=begin)
        return limits_of(verify(table, scenario))

    assert judged() == set()
    turned = Rotation.from_quat(q_xyzw) * Rotation.from_rotvec([0.0, 2e-7, 0.0])
    assert judged(q_body_from_eci_xyzw=tuple(turned.as_quat().tolist())) == {"initial_state"}
    assert judged(omega_body_deg_s=None) == {"initial_state"}
    faster = (told[1][0] + 1e-4, *told[1][1:])
    assert judged(alpha_body_deg_s2=faster) == {"initial_state"}


@pytest.fixture(scope="module")
def skyfield_sun_eci():
    """Where the Sun stands in the carrier's sky at the epoch, unit vector: by Skyfield."""

    ephemeris = load_file(str(files("planner.verification") / "data" / "de421.bsp"))
    at = load.timescale(builtin=True).from_datetime(EPOCH_UTC)
    sun = ephemeris["earth"].at(at).observe(ephemeris["sun"]).apparent()
    return unit(sun.frame_xyz(ICRS).au)


@pytest.mark.parametrize(
    ("side", "name", "limit_deg"), [("away_from", "min_deg", 10.0), ("near", "max_deg", 150.0)]
)
def test_exclusions_are_counted_from_the_suns_edge(table, skyfield_sun_eci, side, name, limit_deg):
    """The least angle of a body axis from its nearest edge, the greatest from its farthest, but
    for the carrier's parallax and aberration."""
    sign, extreme = (1.0, np.min) if side == "away_from" else (-1.0, np.max)
    for axis in np.vstack([np.eye(3), -np.eye(3)]):
        angles = np.arccos(Rotation.from_quat(table.position).apply(axis) @ skyfield_sun_eci)
        edge = extreme(angles) - sign * math.radians(0.2690)  # half the disk at 0.9905 au
        rule = Exclusion(
            name="axis", direction_body=tuple(axis.tolist()), **{side: "sun", name: limit_deg}
        )
        (margin,) = verify(table, with_body(exclusions=(rule,))).exclusions
        expected = sign * (edge - math.radians(limit_deg))
        assert margin.margin_rad == pytest.approx(expected, abs=2e-4)
        tight = dataclasses.replace(rule, **{name: math.degrees(edge) + sign * 0.1})
        (finding,) = verify(table, with_body(exclusions=(tight,))).findings
        assert finding.limit == "exclusion"
        assert '"axis"' in finding.detail


def test_cells_passed_by_hold_no_nearest_exclusion(table, monkeypatch):
    """Beside every cell looked at; the same but for how sums of many numbers are rounded."""
    rng = np.random.default_rng(44)
    excluded = tuple(
        Exclusion(
            name=f"{away_from} {n}",
            direction_body=tuple(rng.normal(size=3).tolist()),
            away_from=away_from,
            min_deg=1.0,
        )
        for away_from in ("sun", "moon", "limb", "glint")
        for n in range(4)
    )
    body = dataclasses.replace(BODY, exclusions=excluded)
    told = BodyJudge(table, body_scenario(body)).exclusions()
    every = dataclasses.replace(body_exclusions.OPTIONS, stride=len(table.t_s))
    monkeypatch.setattr(body_exclusions, "OPTIONS", every)
    whole = BodyJudge(table, body_scenario(body)).exclusions()
    for one, other in zip(told, whole, strict=True):
        assert one.margin_rad == pytest.approx(other.margin_rad, abs=1e-12), one.name


def test_only_imaging_counts_where_so_asked(table):
    """The boresight on its way from nadir is nearer to the limb's inside than on the target."""
    rule = Exclusion(name="limb", of="camera", away_from="limb", min_deg=0.0)
    always = verify(table, with_body(exclusions=(rule,))).exclusions[0]
    imaging = dataclasses.replace(rule, when="imaging")
    while_imaging = verify(table, with_body(exclusions=(imaging,))).exclusions[0]
    assert always.margin_rad < while_imaging.margin_rad < 0.0
    assert always.t_s < 10.0
    assert 60.0 <= while_imaging.t_s <= 100.0


def test_nothing_that_only_a_look_must_meet_is_asked_at_a_station(table):
    """The same table is judged by what its session is for."""
    limb = Exclusion(name="limb", of="camera", away_from="limb", min_deg=0.0, when="imaging")
    down = StarTracker(name="down", boresight_body=(0.0, 0.0, 1.0), limb_deg=10.0)
    camera = {"off_nadir_max_deg": 20.0, "star_trackers": StarTrackers(needed=1, each=(down,))}
    conditions = Conditions(max_ground_sample_m=0.1, sun_keep_out_deg=180.0)
    place = (LAS_VEGAS.latitude_deg, LAS_VEGAS.longitude_deg, LAS_VEGAS.height_m)

    def judged(target, exclusion=limb):
        body = dataclasses.replace(BODY, exclusions=(exclusion,), **camera)
        return verify(table, body_scenario(body, target, conditions=conditions))

    def station(latitude_deg, longitude_deg, height_m):
        return StationTarget(
            latitude_deg=latitude_deg, longitude_deg=longitude_deg, height_m=height_m
        )

    assert limits_of(judged(LAS_VEGAS)) == {
        "off_nadir", "exclusion", "ground_sample", "sun_keep_out"
    }  # fmt: skip
    report = judged(station(*place))
    assert report.passed
    assert report.taken_as_given == ("orbit",)
    assert report.exclusions[0].margin_rad is None
    always = dataclasses.replace(limb, when="always")
    assert limits_of(judged(station(*place), always)) == {"exclusion"}
    assert limits_of(judged(station(place[0] + 1e-3, *place[1:]))) == {"pointing"}


def test_star_trackers_need_the_second_best_of_two(table):
    up = StarTracker(name="up", boresight_body=(0.0, 0.0, -1.0), limb_deg=10.0)
    down = StarTracker(name="down", boresight_body=(0.0, 0.0, 1.0), limb_deg=10.0)
    one = StarTrackers(needed=1, each=(down, up))
    assert verify(table, with_body(star_trackers=one)).passed
    both = dataclasses.replace(one, needed=2)
    (finding,) = verify(table, with_body(star_trackers=both)).findings
    assert finding.limit == "exclusion"


def test_the_mirror_of_the_sun_obeys_the_law_of_reflection():
    """At the point where the line of sight meets the ellipsoid, whose normal is its gradient."""
    random = np.random.default_rng(5)
    sun = unit(random.normal(size=(400, 3)))
    zenith = unit(random.normal(size=(400, 3)))
    r_m = zenith * (6378e3 + random.uniform(300e3, 36000e3, size=(400, 1)))
    towards, is_there = mirror_direction(sun, r_m)
    axes = np.array([6378137.0, 6378137.0, 6356752.314245])
    o, d = r_m / axes, towards / axes
    a, b, c = np.sum(d * d, 1), np.sum(o * d, 1), np.sum(o * o, 1) - 1.0
    root = b * b - a * c
    assert (root[is_there] > 0.0).all()
    point = r_m + ((-b - np.sqrt(np.maximum(root, 0.0))) / a)[:, None] * towards
    normal = unit(point / axes**2)
    reflected = towards - 2.0 * np.sum(towards * normal, 1)[:, None] * normal
    off = np.linalg.norm(np.cross(reflected, sun), axis=1)
    high = is_there & (np.sum(sun * normal, axis=1) > 0.05)
    assert np.count_nonzero(high) > 100
    assert off[high].max() < 1e-6
    # and none is missed: where the Sun is within 80 deg of the zenith there always is one
    assert is_there[np.sum(sun * zenith, axis=1) > 0.2].all()


def test_what_is_hidden_counts_for_nothing():
    """The Sun, 30 deg below the limb."""
    instants = Instants(EPOCH_UTC, np.array([0.0, 0.2]))
    states = ORBIT.states(instants)
    around = Surroundings(instants, states)
    sun = unit(around._sun.apparent_eci)
    behind = dataclasses.replace(
        states, r_sat_eci_m=-sun * 6.8e6, v_sat_eci_m_s=np.cross(sun, [0.0, 0.0, 7.6e3])
    )
    assert np.isinf(Surroundings(instants, behind).away_rad(sun, "sun")).all()
    assert Surroundings(instants, behind).away_rad(-sun, "limb")[0] > 1.0


def with_gyros(torque_max_n_m=0.2, momentum_max_n_m_s=1.5, start_n_m_s=(0.0, 0.0, 0.0)):
    """The body of the tables, turned by gyros that are asked for so much at most."""
    turns = GyroTurns(
        rate_max_deg_s=0.01,  # so that no rate takes torque or momentum from the other limits
        torque_max_n_m=torque_max_n_m,
        torque_rate_max_n_m_s=1.0,
        momentum_max_n_m_s=momentum_max_n_m_s,
    )
    array = ScissoredPairs(rotor_n_m_s=2.0, gimbal_rate_max_deg_s=60.0)
    gyros = GyroSet(array=array, turns=turns, start_n_m_s=start_n_m_s)
    return with_body(agility=None, gyros=gyros, inertia_kg_m2=INERTIA_KG_M2)


def gyros_asked(table, start_n_m_s):
    """Largest torque and momentum, by SciPy's spline of the rows' attitudes: gravity's part is
    below 1e-5 N m for such a body."""
    spline = RotationSpline(table.t_s, Rotation.from_quat(table.position))
    t_s = np.arange(round(table.t_s[-1] * 200.0) + 1) / 200.0
    q_eci_from_body, omega, alpha = spline(t_s), spline(t_s, 1), spline(t_s, 2)
    inertia = np.array(INERTIA_KG_M2)
    begun = q_eci_from_body[0].apply(inertia @ omega[0] + start_n_m_s)
    total = q_eci_from_body.inv().apply(begun)
    torque = alpha @ inertia + np.cross(omega, total)
    return [np.linalg.norm(part, axis=1).max() for part in (torque, total - omega @ inertia)]


def with_gimbals(table, start_n_m_s=(0.0, 0.0, 0.0)):
    """The table with gimbals turned by the least rates that change their momentum as the rows ask,
    of rotors of 2 N m s: H = h [s3 + s4, s1 + s2, c1 + c2 + c3 + c4]."""
    q, inertia = Rotation.from_quat(table.position), np.array(INERTIA_KG_M2)
    total = q[0].apply(inertia @ table.rate_rad_s[0] + start_n_m_s)
    wanted = (q.inv().apply(total) - table.rate_rad_s @ inertia) / 2.0

    def held(a):
        return np.array([*(np.sin(a[i]) + np.sin(a[i + 1]) for i in (2, 0)), np.cos(a).sum()])

    def least(a, change):
        c, s = np.cos(a), np.sin(a)
        return np.linalg.pinv([[0.0, 0.0, c[2], c[3]], [c[0], c[1], 0.0, 0.0], -s]) @ change

    angle = np.radians([60.0, -60.0, 120.0, -120.0])
    for _ in range(30):
        angle = angle + least(angle, wanted[0] - held(angle))
    rows = []
    for there in [*wanted[1:], wanted[-1]]:
        turn = np.zeros(4)
        for _ in range(4):
            turn = turn + least(angle + turn, there - held(angle + turn))
        rows.append([*angle, *(turn / COMMAND_STEP_S)])
        angle = angle + turn
    channels = with_gyros().platform.channels
    return dataclasses.replace(table, channels=channels, extra_rad=np.array(rows))


@pytest.mark.parametrize(
    ("column", "off", "limits"),
    [
        (0, 0.0, []),
        (0, 1e-6, ["table"]),
        (0, 0.01, ["table", "momentum"]),
        (5, 2e-8, ["table"]),
        (6, 1.1, ["table", "rate"]),
        (7, np.nan, ["table"]),
    ],
)
def test_gimbals_that_are_not_the_motions_are_found(table, column, off, limits):
    turned = with_gimbals(table)
    turned.extra_rad[100, column] += off
    findings = verify(turned, with_gyros()).findings
    assert [one.limit for one in findings if "gimbal" in one.detail] == limits


def test_gimbals_are_columns_of_the_table_of_gyros(table):
    (finding,) = verify(
        dataclasses.replace(with_gimbals(table), extra_rad=None), with_gyros()
    ).findings
    assert finding.limit == "table"
    assert limits_of(verify(table, with_gyros())) == {"table"}


def test_gimbals_near_a_singularity_give_no_torque(table):
    """All four along z: no rate changes the momentum along it."""
    turned = with_gimbals(table)
    turned.extra_rad[:] = [1e-4, -1e-4, np.pi + 1e-4, np.pi - 1e-4, 0.0, 0.0, 0.0, 0.0]
    findings = verify(turned, with_gyros()).findings
    assert any("the torque takes a gimbal to" in one.detail for one in findings)


@pytest.mark.parametrize("start_n_m_s", [(0.0, 0.0, 0.0), (0.4, -0.3, 0.6)])
def test_what_gyros_are_asked_for_is_judged_by_their_momentum(table, start_n_m_s):
    torque, momentum = gyros_asked(table, start_n_m_s)
    table = with_gimbals(table, start_n_m_s)
    ample = {"torque_max_n_m": 0.2, "momentum_max_n_m_s": 1.5, "start_n_m_s": start_n_m_s}
    assert not limits_of(verify(table, with_gyros(**ample))) & {"torque", "momentum"}
    for limit, name, most in (
        ("torque", "torque_max_n_m", torque),
        ("momentum", "momentum_max_n_m_s", momentum),
    ):
        for share, broken in ((1.01, set()), (0.99, {limit})):  # gravity and splines: below 1 %
            report = verify(table, with_gyros(**ample | {name: share * most}))
            assert limits_of(report) & {"torque", "momentum"} == broken
