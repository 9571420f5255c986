"""Every request ends by the work that one may make, with the best found by then.

data/cases: requests of an adversary's fuzzing, which took 68 s of CPU, failed, or took 20 to 70 s
where so much less was counted that nothing ended them.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scenarios import EPOCH, LARAMIE, LAS_VEGAS, SALT_LAKE, advised, at, moved, scenario, session

from app.requests.plan import read_plan_request
from planner.base import effort
from planner.base.commands import ROWS_PER_S
from planner.base.effort import WorkLimitReached, at_most, charge, count_once
from planner.base.errors import Refusal, SearchEnded, Unreachable
from planner.base.solvers import has_piqp
from planner.motion.slew import AxisState, SlewProblem, optimal_slew
from planner.motion.slew.ocp import Begin, Rows, SpanProgramme, Vibration, solve
from planner.planning.sessions import nearest_start
from planner.planning.sessions.assembly import table_work
from planner.planning.sessions.pipeline import make_plan
from planner.planning.sessions.platforms.registry import mover_of
from planner.planning.sessions.sequence import SessionRefused, sequence_sessions
from planner.world.frames.time_scales import elapsed_s
from planner.world.platforms import AxisLimits, StructuralMode
from planner.world.rules.keep_out import KeepOut
from planner.world.scenario import SlewOptions
from planner.world.targets import GroundTarget

CASES = Path(__file__).parents[1] / "data" / "cases"
QUICK = SlewOptions(objective="minimum_time")
PASS = (session(LAS_VEGAS, 140.0, 160.0), session(SALT_LAKE, 200.0, 230.0))


def case(name):
    return read_plan_request((CASES / f"{name}.json").read_bytes())


def counted(asked):
    """The plan, or the refusal, and the work it took."""
    with at_most(np.inf) as work:
        try:
            made = make_plan(asked)
        except Refusal as refusal:
            made = refusal
    return made, work.done_rows


def test_a_search_among_many_ways_around_a_cone_ends_with_a_plan():
    plan, work = counted(case("minimum_time_cone_68s"))
    assert plan.verification.passed
    assert work < effort.PLAN


@pytest.mark.parametrize("name", ["seed300286", "seed301127"])
def test_dear_requests_end_within_what_one_may_make(name):
    """One solve may be begun just before the bound, and is finished."""
    _, work = counted(case(name))
    assert work < 1.1 * effort.PLAN


def test_a_slew_is_not_cut_ever_finer():
    """Its rate's limit is met within a thousandth of it: spans grew to many thousands."""
    _, work = counted(case("seed302114"))
    assert work < 0.3 * effort.PLAN


def slewed(modes):
    """Work counted for a slew at its rate limit."""
    limits = AxisLimits(
        angle_min_rad=-3.0,
        angle_max_rad=3.0,
        rate_max_rad_s=0.05,
        acceleration_max_rad_s2=0.02,
        jerk_max_rad_s3=0.02,
    )
    problem = SlewProblem(
        axis_names=("alpha",),
        limits=(limits,),
        start=(AxisState(angle_rad=0.0),),
        end=(AxisState(angle_rad=1.0),),
        duration_s=28.0,
        avoid_modes=tuple(StructuralMode(frequency_hz=0.2 + 0.1 * k) for k in range(modes)),
    )
    with at_most(np.inf) as work:
        optimal_slew(problem)
    return work.done_rows


def test_modes_are_counted_as_they_cost():
    """To weigh five takes several times the slew without; both counted alike, 53 s passed for 4."""
    assert slewed(modes=5) > 3.0 * slewed(modes=0)


def solved(start, *, rate_max, spans, on_rows):
    """The run, and its counted work, of a move by 1 in 1 from rest to rest; the mean rate is 1."""
    limits = np.array([[-2.0, 2.0], [-rate_max, rate_max], [-1e2, 1e2], [-1e4, 1e4]])
    ends = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    rows = Rows(np.zeros(spans, dtype=bool), np.full((spans, 2), 0.5)) if on_rows else None
    no_modes = Vibration(np.zeros((0, spans, 2)), np.zeros(0))
    widths = np.full(spans, 1.0 / spans)
    given = SpanProgramme(widths, ends, limits, rows, no_modes, weight=1.0 / 720.0)
    states = np.linspace(*ends, spans + 1)
    begin = Begin(states, np.zeros((spans, 2)))
    with at_most(np.inf) as work:
        solve(given, begin, start)
        once = work.done_rows  # and to make the solver
        run = solve(given, begin, start).run
    return run, work.done_rows - once


@pytest.mark.parametrize("on_rows", [False, True])
def test_ipopt_gives_up_where_no_motion_keeps_the_limits(on_rows):
    """The multipliers grow without end, factors fill, and 50 iterations cost five times as many."""
    run, _ = solved("cold", rate_max=0.9, spans=16, on_rows=on_rows)
    assert not run.is_promising
    assert run.iterations < 30


@pytest.mark.parametrize("on_rows", [False, True])
def test_iterations_that_strain_count_more(on_rows):
    cost = []
    for rate_max in (1.2, 0.9):
        run, work = solved("cold", rate_max=rate_max, spans=16, on_rows=on_rows)
        cost.append(work / run.iterations)
        assert run.is_promising == (rate_max > 1.0)
    assert cost[1] > 1.2 * cost[0]


@pytest.mark.skipif(not has_piqp(), reason="this CasADi brings no PIQP")
def test_piqp_that_fails_counts_twice():
    _, done = solved("quick", rate_max=3.0, spans=40, on_rows=True)
    run, failed = solved("quick", rate_max=0.9, spans=40, on_rows=True)
    assert not run.is_promising
    assert failed == pytest.approx(2.0 * done)


def test_what_is_made_once_is_counted_in_each_request():
    with at_most(np.inf) as first, at_most(np.inf):
        count_once("a solver", 5.0)
        with at_most(np.inf):
            count_once("a solver", 5.0)
            count_once("another", 2.0)
    with at_most(np.inf) as second:
        count_once("a solver", 5.0)
    assert (first.done_rows, second.done_rows) == (7.0, 5.0)


def test_what_follows_the_search_is_counted():
    plan, work = counted(scenario(*PASS))
    assert work > table_work(plan.scenario, len(plan.table.t_s) - 1)


def test_a_table_beyond_the_bound_is_refused_before_anything_is_searched(monkeypatch):
    asked = scenario(*PASS)
    monkeypatch.setattr(effort, "PLAN", table_work(asked, 1))
    refusal, work = counted(asked)
    assert isinstance(refusal, SearchEnded)
    assert work == 0.0


def test_a_track_that_a_slew_could_not_meet_is_refused_with_a_start_that_it_can():
    """Its acceleration on the first row is 0.34 % over the limit, as flown from rows it isn't."""
    asked = case("plausible_500")
    refusal, work = counted(asked)
    assert isinstance(refusal, Unreachable)
    assert work < effort.PLAN
    assert make_plan(advised(asked, refusal)).verification.passed


def test_one_request_always_takes_the_same_work():
    asked = scenario(*PASS, slew=QUICK)
    (_, first), (_, again) = counted(asked), counted(asked)
    assert first == again


def test_a_plan_cut_short_is_verified_and_warns(monkeypatch):
    asked = scenario(*PASS, slew=QUICK)
    whole, work = counted(asked)
    assert whole.warnings == ()
    after = table_work(asked, len(whole.table.t_s))
    monkeypatch.setattr(effort, "PLAN", after + 1.4 * (work - after))
    plan, _ = counted(asked)
    assert plan.verification.passed
    assert "perhaps not the quickest" in plan.warnings[0]
    lengths_s = [sum(run.duration_s for run in made.slews) for made in (whole, plan)]
    assert lengths_s[0] < lengths_s[1]


def test_a_request_beyond_the_bound_is_refused_with_the_way_out(monkeypatch):
    monkeypatch.setattr(effort, "PLAN", 2_000)
    refusal, _ = counted(scenario(*PASS, slew=QUICK))
    assert isinstance(refusal, SearchEnded)
    assert "ask for fewer" in refusal.detail


def test_an_outer_bound_ends_what_is_inside_and_the_inner_one_does_not_hide_it():
    with at_most(10.0) as outer:
        with at_most(5.0) as inner:
            charge(6.0)
            charge(1.0)
        assert inner.is_exhausted
        assert not outer.is_exhausted
        with at_most(100.0) as inner:
            charge(6.0)
            charge(1.0)
        pytest.fail("the outer bound was reached inside")
    assert outer.is_exhausted
    assert not inner.is_exhausted
    assert outer.done_rows == 12.0
    with pytest.raises(WorkLimitReached), at_most(1.0), at_most(2.0):
        raise WorkLimitReached(outer)


ABREAST = (GroundTarget(latitude_deg=33.45, longitude_deg=-112.07), SALT_LAKE, LARAMIE)
SUN = KeepOut(body="sun", half_angle_deg=25.0)


SLEWS = (SlewOptions(), QUICK, SlewOptions(keep_out=(SUN,)))
GAPS_S = (0.0, 0.2, 2.0)


# Every place with every gap, and each of both with every slew.
@pytest.mark.parametrize(
    ("place", "gap_s", "slew"),
    [(ABREAST[i], GAPS_S[j], SLEWS[(i + j) % 3]) for i in range(3) for j in range(3)],
)
def test_sessions_with_no_time_between_are_refused_at_once(place, gap_s, slew):
    """Within two seconds of a processor, most of them for what would help."""
    asked = scenario(
        session(LAS_VEGAS, 140.0, 200.0), session(place, 200.0 + gap_s, 260.0), slew=slew
    )
    ephemeris = asked.orbit.ephemeris(at(0.0), at(300.0))
    with at_most(np.inf) as work, pytest.raises(SessionRefused):
        sequence_sessions(asked, ephemeris, mover_of(asked), prove=False)
    assert work.done_rows < 0.05 * effort.PLAN
    refusal, work_rows = counted(asked)
    assert work_rows < 0.25 * effort.PLAN
    assert (refusal.limit, refusal.field) == ("duration", "sessions.1.start")
    # At the greatest rate the farther axis takes that long at least.
    start = refusal.earliest_feasible_start_utc
    plan = make_plan(moved(asked, start, asked.sessions[1].stop, 1))
    left, met = (
        plan.table.position[round(elapsed_s(when, EPOCH) * ROWS_PER_S)]
        for when in (asked.sessions[0].stop, start)
    )
    rates = [limits.rate_max_rad_s for limits in asked.platform.axis_limits]
    assert elapsed_s(start, asked.sessions[0].stop) >= np.max(np.abs(met - left) / rates)


def test_a_session_that_others_press_on_both_sides_is_not_sought_again_and_again(monkeypatch):
    """Wherever the second begins, the third begins when it ends: no start of it can be free."""
    tries = []
    monkeypatch.setattr(nearest_start, "_is_planned", lambda asked, _: tries.append(asked) or True)
    asked = scenario(
        *(
            session(place, *span)
            for place, span in zip(
                ABREAST, ((140.0, 180.0), (180.0, 220.0), (220.0, 260.0)), strict=True
            )
        )
    )
    refusal, _ = counted(asked)
    assert refusal.costs_sessions == (2,)
    assert len(tries[0].sessions) == 2
    kept_stop = [one for one in tries if one.sessions[1].stop == asked.sessions[1].stop]
    assert len(kept_stop) == 1


def refused_sequences(count):
    """Sequences over the western states that can't be flown as asked, and why not."""
    rng = np.random.default_rng(7)
    found = []
    while len(found) < count:
        sessions, start_s = [], rng.uniform(60.0, 150.0)
        for _ in range(rng.integers(2, 4)):
            stop_s = start_s + rng.uniform(5.0, 30.0)
            place = GroundTarget(
                latitude_deg=rng.uniform(33.0, 42.0),
                longitude_deg=rng.uniform(-120.0, -104.0),
                min_elevation_deg=rng.choice([0.0, 20.0]),
            )
            sessions.append(session(place, round(start_s, 1), round(stop_s, 1)))
            start_s = stop_s + rng.uniform(2.0, 25.0)
        asked = scenario(*sessions, slew=QUICK if len(found) % 2 else SlewOptions())
        made, _ = counted(asked)
        if isinstance(made, Refusal):
            found.append((asked, made))
    return found


def test_advice_that_is_followed_plans():
    """With the session moved, and those left out that this costs; with each offer as it stands."""
    followed = 0
    for asked, refusal in refused_sequences(7):
        if refusal.earliest_feasible_start_utc is not None:
            followed += 1
            number, costs = int(refusal.field.split(".")[1]), refusal.costs_sessions
            assert number not in costs
            times = refusal.earliest_feasible_start_utc, refusal.feasible_stop_utc
            sessions = list(asked.sessions)
            sessions[number] = replace(sessions[number], start=times[0], stop=times[1])
            kept = tuple(one for other, one in enumerate(sessions) if other not in costs)
            assert make_plan(replace(asked, sessions=kept)).verification.passed
        for mode in {offer.on_conflict for offer in getattr(refusal, "relaxations", ())}:
            assert make_plan(replace(asked, on_conflict=mode)).verification.passed
    assert followed >= 5


def test_a_start_that_costs_another_session_says_which():
    """Las Vegas for a minute up to the next session leaves no time for the slew between."""
    sessions = session(LAS_VEGAS, 1.0, 90.0), session(SALT_LAKE, 91.0, 150.0)
    refusal, _ = counted(scenario(*sessions, alpha=(150.0, 0.0, 0.0)))
    assert refusal.earliest_feasible_start_utc > at(1.0)
    assert refusal.costs_sessions == (1,)
    assert "session 2 can't be flown then as asked" in refusal.detail
