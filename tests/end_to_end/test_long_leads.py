"""With time to spare the axes brake, wait and slew within every limit, and rest in the end."""

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest
from scenarios import LAS_VEGAS, SALT_LAKE, at, scenario, session
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from planner.base.commands import COMMAND_STEP_S
from planner.base.errors import InfeasibleSlew, Refusal
from planner.motion.slew import AxisState, SlewProblem, optimal_slew
from planner.planning.sessions.pipeline import make_plan
from planner.planning.sessions.platforms.two_axis.slew_timing import (
    at_rest_after,
    least_slew_s,
    slew_within_lead,
)
from planner.verification import verify
from planner.world.frames.time_scales import elapsed_s
from planner.world.platforms import ISS_HRC, AxisLimits, StructuralMode
from planner.world.rules.keep_out import KeepOut
from planner.world.scenario import BoundedLead, FinalAngles, SlewOptions
from planner.world.targets import BenchMotionTarget
from planner.world.targets.axis_signals import ConstantRate

LIMITS = ISS_HRC.axis_limits
HOUR_S = 3600
RATE_MIN_DEG_S = 1.0 / 60.0


def standing(angle_deg):
    return ConstantRate(angle_deg=angle_deg, rate_deg_s=0.0)


STANDING = {"alpha": standing(20.0), "beta": standing(-5.0)}


def length_s(segment):
    return elapsed_s(segment.stop_utc, segment.start_utc)


def rows_of(plan, segment):
    first, last = (
        round(elapsed_s(moment, plan.table.epoch_utc) / COMMAND_STEP_S)
        for moment in (segment.start_utc, segment.stop_utc)
    )
    return slice(first, last + 1)


def assert_whole(plan):
    """Segments follow each other from the first row to the last; the axes rest in waits."""
    assert plan.segments[0].start_utc == plan.table.epoch_utc
    for before, after in pairwise(plan.segments):
        assert before.stop_utc == after.start_utc
    last_s = elapsed_s(plan.segments[-1].stop_utc, plan.table.epoch_utc)
    assert last_s == pytest.approx(plan.table.t_s[-1], abs=1e-6)
    for segment in plan.segments:
        if segment.kind == "wait":
            rows = rows_of(plan, segment)
            # The row that it shares with a slew is the slew's own, to rounding.
            assert np.ptp(plan.table.position[rows], axis=0).max() < 1e-12
            assert np.abs(plan.table.rate_rad_s[rows]).max() < 1e-12


def steps_of_acceleration(plan):
    """By SciPy's Hermite, deg/s2 from cell to cell."""
    t_s = plan.table.t_s
    curve = CubicHermiteSpline(
        t_s, np.degrees(plan.table.position), np.degrees(plan.table.rate_rad_s)
    )
    return np.abs(curve(t_s[1:-1], 2) - curve(t_s[1:-1] - 1e-9, 2)).max()


@pytest.mark.parametrize("lead", ["all", BoundedLead(), BoundedLead(max_duration_s=90.0)], ids=str)
@pytest.mark.parametrize("objective", ["smooth", "minimum_time"])
def test_random_leads_are_flown_within_every_limit(lead, objective):
    """From rest or moving, from 40 s to four hours before sessions that lie far apart or near."""
    rng = np.random.default_rng(20261123)
    flown = kinds = 0
    for _ in range(10):
        before_s = 10.0 ** rng.uniform(1.6, 4.1)
        gap_s = rng.uniform(20.0, 110.0)
        moving = rng.integers(2)
        asked = scenario(
            session(LAS_VEGAS, 140.0, 150.0),
            session(SALT_LAKE, 150.0 + gap_s, 165.0 + gap_s),
            alpha=(rng.uniform(-150, 150), moving * rng.uniform(-2.5, 2.5), moving * 0.2),
            beta=(rng.uniform(-150, 150), moving * rng.uniform(-2.5, 2.5), 0.0),
            epoch_s=round(140.0 - before_s),
            slew=SlewOptions(objective=objective, lead=lead),
        )
        try:
            plan = make_plan(asked)
        except Refusal:
            continue
        flown += 1
        assert plan.verification.passed
        assert_whole(plan)
        assert steps_of_acceleration(plan) < 2.0 * 8.0 / 27.0 * COMMAND_STEP_S  # 1 deg/s3
        for segment in plan.segments:
            kinds |= {"wait": 1, "brake": 2}.get(segment.kind, 0)
            if lead != "all" and lead.max_duration_s and segment.kind == "slew":
                assert length_s(segment) <= lead.max_duration_s + 1e-6
    assert flown >= 5
    assert kinds == (0 if lead == "all" else 3)


def test_a_slew_with_hours_to_spare_is_as_gentle_as_a_track_and_no_slower():
    asked = scenario(session(LAS_VEGAS, 140.0, 230.0), epoch_s=-3 * HOUR_S)
    plan = make_plan(asked)
    wait, slew, track = plan.segments
    assert [wait.kind, slew.kind, track.kind] == ["wait", "slew", "track"]
    assert length_s(slew) == pytest.approx(10.0 * plan.slews[0].minimum_s, abs=COMMAND_STEP_S)
    acceleration = np.gradient(np.degrees(plan.table.rate_rad_s), COMMAND_STEP_S, axis=0)
    on_track = np.abs(acceleration[rows_of(plan, track)][2:-2]).max()
    on_slew = np.abs(acceleration[rows_of(plan, slew)]).max()
    assert on_slew < 1.5 * on_track
    crawling = make_plan(replace(asked, slew=SlewOptions(lead="all")))
    slow_s = [
        sum(slow.stop_s - slow.start_s for slow in one.verification.slow_stretches)
        for one in (plan, crawling)
    ]
    assert slow_s[0] < 0.1 * slow_s[1]


def test_short_leads_are_flown_as_ever():
    asked = scenario(session(LAS_VEGAS, 140.0, 230.0), alpha=(10.0, 0.5, 0.1))
    whole = make_plan(replace(asked, slew=SlewOptions(lead="all")))
    np.testing.assert_array_equal(make_plan(asked).table.position, whole.table.position)


def test_braking_to_rest_anywhere_has_the_least_jerk():
    """Against jerk constant on 600 cells, by least squares with the end angle free."""
    cells, duration_s = 600, 20.0
    state = AxisState(angle_rad=0.3, rate_rad_s=0.02, acceleration_rad_s2=-0.004)
    [rest] = at_rest_after((state,), LIMITS[:1], duration_s)
    h = duration_s / cells
    left_s = duration_s - h * (np.arange(cells) + 0.5)
    # What each cell's jerk adds to rate and acceleration at the end; to the angle likewise.
    ends = np.stack([h * left_s, np.full(cells, h)])
    coasted = state.rate_rad_s + duration_s * state.acceleration_rad_s2, state.acceleration_rad_s2
    jerk = np.linalg.lstsq(ends, -np.array(coasted), rcond=None)[0]
    angle_rad = (
        state.angle_rad
        + duration_s * (state.rate_rad_s + duration_s * state.acceleration_rad_s2 / 2.0)
        + np.sum(jerk * h * (left_s**2 / 2.0 + h**2 / 24.0))
    )
    assert rest.rate_rad_s == rest.acceleration_rad_s2 == 0.0
    assert rest.angle_rad == pytest.approx(angle_rad, abs=1e-6)  # (h / T)^2 of the way


@pytest.mark.parametrize("gap_deg", [0.6, 1.0, 3.0])
def test_an_axis_that_moves_towards_its_stop_rests_before_it(gap_deg):
    """1 deg/s takes 1 deg and the stop is nearer than smooth braking would go."""
    stop = LIMITS[0].angle_max_rad
    start = AxisState(angle_rad=stop - np.deg2rad(gap_deg), rate_rad_s=np.deg2rad(0.5))
    options = SlewOptions()
    problem = SlewProblem(
        axis_names=("alpha",), limits=LIMITS[:1], start=(start,),
        end=(AxisState(angle_rad=0.0),), duration_s=2000.0,
    )  # fmt: skip
    led = slew_within_lead(problem, options, lambda part: optimal_slew(part, on_rows=True))
    angle, rate, _, _ = led.brake.motion(np.linspace(0.0, led.brake.duration_s, 2001))
    assert angle.max() <= stop
    assert abs(rate[-1, 0]) < 1e-12
    assert led.slew.problem.start[0].angle_rad == pytest.approx(angle[-1, 0], abs=1e-12)


def test_slow_stretches_of_a_slew_are_those_of_the_quintic():
    """20 deg from rest to rest in 60 s: the rate is 30 D/T s^2 (1-s)^2."""
    motion = BenchMotionTarget(axes=STANDING)
    asked = scenario(
        session(motion, 600.0, 610.0), slew=SlewOptions(lead=BoundedLead(max_duration_s=60.0))
    )
    plan = make_plan(asked)
    slow = [found for found in plan.verification.slow_stretches if found.axis == "alpha"]

    def beyond(s):
        return 30.0 * 20.0 / 60.0 * s**2 * (1.0 - s) ** 2 - RATE_MIN_DEG_S

    edge_s = 60.0 * brentq(beyond, 0.0, 0.5)
    # The Hermite's rate leaves the quintic's by 1e-6 deg/s, which rises by 6e-3 deg/s2 there.
    expected = [(540.0, 540.0 + edge_s), (600.0 - edge_s, 600.0)]
    found = [(stretch.start_s, stretch.stop_s) for stretch in slow]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-3)


ENDS = ("rest", FinalAngles(park="zero"), FinalAngles(angles_deg={"alpha": -30.0, "beta": 50.0}))
LEADS = ("all", BoundedLead(), BoundedLead(max_duration_s=60.0))
HOW = list(product(("smooth", "minimum_time"), ("ocp", "spline")))


# Each two of them meet, and every end each way of slewing.
@pytest.mark.parametrize(
    ("final", "lead", "objective", "method"),
    [(ENDS[i], LEADS[(i + k) % 3], *how) for i in range(3) for k, how in enumerate(HOW)],
)
def test_the_table_ends_at_rest_where_it_was_asked_to(final, lead, objective, method):
    slew = SlewOptions(method=method, objective=objective, lead=lead, filter_cutoff_hz=None)
    plan = make_plan(scenario(session(LAS_VEGAS, 140.0, 230.0), slew=slew, final_state=final))
    assert_whole(plan)
    last = plan.segments[-1]
    assert (last.kind, last.session) == ("slew", None)
    assert last.start_utc == at(230.0)
    assert np.abs(plan.table.rate_rad_s[-1]).max() < 1e-9
    wanted = {"park": (0.0, 0.0), "angles": (-30.0, 50.0)}
    if final != "rest":
        name = "park" if final.park else "angles"
        np.testing.assert_allclose(np.degrees(plan.table.position[-1]), wanted[name], atol=1e-9)
    run = plan.slews[-1]
    assert run.session is None
    if method == "ocp":
        assert plan.verification.passed
        if objective == "minimum_time":
            assert run.duration_s <= run.minimum_s + 2.0 * COMMAND_STEP_S
        elif final != "rest":
            most_s = getattr(lead, "max_duration_s", None) or np.inf
            assert run.duration_s == pytest.approx(
                min(10.0 * run.minimum_s, most_s), abs=COMMAND_STEP_S
            )


def test_no_slew_is_added_where_the_axes_rest_already():
    motion = BenchMotionTarget(axes=STANDING)
    for final in ("rest", FinalAngles(angles_deg={"alpha": 20.0, "beta": -5.0})):
        plan = make_plan(scenario(session(motion, 140.0, 150.0), final_state=final))
        assert [segment.kind for segment in plan.segments] == ["wait", "slew", "track"]


def test_the_judge_finds_a_table_that_ends_elsewhere():
    asked = scenario(session(LAS_VEGAS, 140.0, 230.0), final_state=FinalAngles(park="zero"))
    table = make_plan(asked).table
    assert verify(table, asked).passed
    cut = replace(table, position=table.position[:-10], rate_rad_s=table.rate_rad_s[:-10])
    found = [finding for finding in verify(cut, asked).findings if finding.limit == "final_state"]
    assert {finding.axis for finding in found} == {"alpha", "beta"}
    elsewhere = replace(asked, final_state=FinalAngles(angles_deg={"alpha": 0.0, "beta": 0.001}))
    assert [one.axis for one in verify(table, elsewhere).findings] == ["beta"]


def test_a_bound_below_the_least_time_is_refused_with_the_field_and_what_suffices():
    asked = scenario(session(LAS_VEGAS, 140.0, 230.0), epoch_s=-HOUR_S)
    bounded = replace(asked, slew=SlewOptions(lead=BoundedLead(max_duration_s=15.0)))
    with pytest.raises(InfeasibleSlew, match=r"alpha needs 20\.9.*slew\.lead\.max_") as refused:
        make_plan(bounded)
    assert refused.value.field == "sessions.0.start"
    assert refused.value.earliest_feasible_start_utc is not None
    enough = replace(asked, slew=SlewOptions(lead=BoundedLead(max_duration_s=21.2)))
    assert make_plan(enough).verification.passed
    parked = replace(
        bounded,
        slew=SlewOptions(lead=BoundedLead(max_duration_s=40.0)),
        final_state=FinalAngles(angles_deg={"alpha": -170.0, "beta": 0.0}),
    )
    with pytest.raises(InfeasibleSlew, match="final_state") as refused:
        make_plan(parked)
    assert refused.value.field == "slew.lead.max_duration_s"


def test_a_final_state_inside_a_cone_is_refused_as_such():
    ahead = KeepOut(half_angle_deg=20.0, direction_lvlh=(1.0, 0.0, 0.0))
    asked = scenario(
        session(LAS_VEGAS, 140.0, 230.0),
        slew=SlewOptions(keep_out=(ahead,)),
        final_state=FinalAngles(angles_deg={"alpha": -90.0, "beta": 0.0}),
    )
    with pytest.raises(InfeasibleSlew, match="inside the cone") as refused:
        make_plan(asked)
    assert refused.value.field == "final_state"
    assert make_plan(replace(asked, final_state="rest")).verification.passed


def test_a_cone_that_passes_over_waiting_axes_is_slewn_away_from_or_refused():
    """A star crosses the sky of a carrier that turns with its orbit."""
    star = KeepOut(half_angle_deg=15.0, ra_deg=200.0, dec_deg=10.0)
    asked = scenario(
        session(LAS_VEGAS, 140.0, 230.0),
        alpha=(150.0, 0.3, 0.0),
        beta=(60.0, 0.0, 0.0),
        epoch_s=-HOUR_S,
        slew=SlewOptions(keep_out=(star,)),
    )
    plan = make_plan(asked)
    assert plan.verification.passed
    assert [segment.kind for segment in plan.segments] == ["slew", "track"]
    bounded = SlewOptions(keep_out=(star,), lead=BoundedLead(max_duration_s=100.0))
    with pytest.raises(InfeasibleSlew, match=r"would wait .* inside the cone.*slew\.lead"):
        make_plan(replace(asked, slew=bounded))
    elsewhere = replace(asked, slew=bounded, initial_state=scenario(
        session(LAS_VEGAS, 140.0, 230.0), beta=(60.0, 0.0, 0.0), epoch_s=-HOUR_S
    ).initial_state)  # fmt: skip
    waited = make_plan(elsewhere)
    assert waited.verification.passed
    assert waited.segments[0].kind == "wait"


def test_modes_are_suppressed_after_a_wait_too():
    """A mode of 20 s asks for 80 s at least, more than ten times a short slew's least time."""
    mode = StructuralMode(frequency_hz=0.05)
    motion = BenchMotionTarget(axes={"alpha": standing(2.0), "beta": standing(-1.0)})
    plan = make_plan(scenario(session(motion, 900.0, 910.0), slew=SlewOptions(avoid_modes=(mode,))))
    run = plan.slews[0]
    assert 10.0 * run.minimum_s < run.duration_s == pytest.approx(80.0)
    [residual] = run.comparison.residual_vibration
    assert max(residual.ocp_rad.values()) < 0.01 * max(residual.spline_rad.values())


def test_bounds_hold_for_axes_that_share_no_least_time():
    start, end = (
        (AxisState(angle_rad=0.0),) * 2,
        (AxisState(angle_rad=1.0), AxisState(angle_rad=0.1)),
    )
    slow = AxisLimits(
        angle_min_rad=-3.0, angle_max_rad=3.0, rate_max_rad_s=0.001,
        acceleration_max_rad_s2=0.001, jerk_max_rad_s3=0.001,
    )  # fmt: skip
    assert least_slew_s(start, end, (LIMITS[0], slow)) == pytest.approx(0.1 / 0.001 + 2.0, rel=1e-9)


def test_axes_that_cannot_be_brought_to_rest_are_refused_as_such():
    """A test motion ends 0.05 deg before the stop, at 1 deg/s: braking takes a degree."""
    motion = BenchMotionTarget(
        axes={"alpha": ConstantRate(angle_deg=174.95 - 10.0, rate_deg_s=1.0), "beta": standing(0.0)}
    )
    asked = scenario(session(motion, 200.0, 210.0))
    assert make_plan(asked).verification.passed
    for final in ("rest", FinalAngles(park="zero")):
        with pytest.raises(InfeasibleSlew, match="after the last session") as refused:
            make_plan(replace(asked, final_state=final))
        assert (refused.value.field, refused.value.axis) == ("final_state", "alpha")
