"""Every motion that `method: ocp` returns is Ipopt's, and Ipopt's failures are handled."""

import math
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from slew_cases import LIMITS, deg_state, sampled

from planner.base.errors import InfeasibleSlew
from planner.base.solvers import Solver, Work
from planner.motion.slew import SlewProblem, ocp, optimal_slew
from planner.motion.slew import smoothest as rounds
from planner.motion.slew.optimal import FEASIBLE
from planner.world.platforms import StructuralMode


def posed(start, end, duration_s, **more):
    return SlewProblem(
        axis_names=("alpha",),
        limits=(LIMITS,),
        start=(start,),
        end=(end,),
        duration_s=duration_s,
        **more,
    )


MODE = StructuralMode(frequency_hz=0.3, damping=0.005)
SLEWS = {
    "no limit near": posed(deg_state(5, 0.3), deg_state(60, -0.2), 120.0),
    "needn't move": posed(deg_state(5), deg_state(5), 60.0),
    "along the rate limit": posed(deg_state(-60, 0.8, 0.1), deg_state(75, 0.7), 54.0),
    "near a stop": posed(deg_state(-173.2, -1.3, -0.07), deg_state(138.8, 0.65, 0.15), 600.0),
    "braked at once": posed(deg_state(-20, 2.5, 1.0), deg_state(35), 60.0),
    "modes": posed(deg_state(5, 0.3), deg_state(60, -0.2), 60.0, avoid_modes=(MODE,)),
    "short": posed(deg_state(5), deg_state(5.1), 1.6),
}


@pytest.fixture
def answers(monkeypatch):
    """What the solvers answered: run and jerks, in order."""
    seen = []
    solve = ocp.solve

    def recorded(given, begin, start):
        found = solve(given, begin, start)
        seen.append((found.run, found.jerks))
        return found

    monkeypatch.setattr(rounds, "solve", recorded)
    return seen


def is_of(profile, jerks):
    """Whether the jerks at the begins of its spans, in its middle part, are these to a scale."""
    begins, wanted = 6.0 * profile.coefficients[:, 3], jerks[:, 0]
    for skipped in range(len(begins) - len(wanted) + 1):
        part = begins[skipped : skipped + len(wanted)]
        scale = part @ wanted / (wanted @ wanted)
        # Meeting the end exactly changes them by less.
        if np.abs(part - scale * wanted).max() <= 1e-3 * np.abs(part).max():
            return True
    return False


@pytest.mark.parametrize("name", SLEWS)
@pytest.mark.parametrize("on_rows", [False, True])
def test_each_motion_is_what_ipopt_answered(name, on_rows, answers):
    slew = optimal_slew(SLEWS[name], on_rows=on_rows)
    [profile], [run] = slew.profiles, slew.runs
    assert run.name == "ipopt"
    assert run.status == "Solve_Succeeded"
    of_ipopt = [jerks for one, jerks in answers if one == run]
    assert of_ipopt
    size = np.abs(profile.extremes[3]).max()
    assert size < 1e-12 or any(is_of(profile, jerks) for jerks in of_ipopt)


@pytest.mark.parametrize("name", ["no limit near", "along the rate limit", "modes", "short"])
@pytest.mark.parametrize("on_rows", [False, True])
def test_ipopt_solves_only_what_is_handed_back(name, on_rows, answers):
    """Where PIQP solves what only places knots, anywhere and on rows."""
    slew = optimal_slew(SLEWS[name], on_rows=on_rows)
    by = [run.name for run, _ in answers]
    assert by == sorted(by, reverse=True)  # piqp, then ipopt
    assert by.count("ipopt") == 1
    assert slew.iterations == slew.runs[0].iterations


@pytest.mark.parametrize("name", ["no limit near", "along the rate limit", "modes"])
def test_what_ipopt_changes_changes_the_motion(name, monkeypatch):
    plain = optimal_slew(SLEWS[name]).profiles[0]
    solve = ocp.solve

    def shifted(given, begin, start):
        found = solve(given, begin, start)
        if found.run.name != "ipopt":
            return found
        wave = np.sin(np.arange(found.jerks.size)).reshape(found.jerks.shape)
        return found._replace(jerks=found.jerks * (1.0 + 1e-4 * wave))

    monkeypatch.setattr(rounds, "solve", shifted)
    monkeypatch.setattr(rounds, "obeys", lambda *_: True)
    other = optimal_slew(SLEWS[name]).profiles[0]
    t_s = np.linspace(0.0, plain.duration_s, 301)
    change = np.abs(other.evaluate(t_s)[3] - plain.evaluate(t_s)[3]).max()
    assert change > 1e-6 * np.abs(plain.evaluate(t_s)[3]).max()


STATUSES = (
    "Solved_To_Acceptable_Level", "Search_Direction_Becomes_Too_Small",
    "Infeasible_Problem_Detected", "Maximum_Iterations_Exceeded", "Restoration_Failed",
    "Diverging_Iterates", "Invalid_Number_Detected", "Error_In_Step_Computation", "Internal_Error",
    "not finite",
)  # fmt: skip


def told(monkeypatch, status, starts):
    """Ipopt says so of these starts."""
    solve, asked = ocp.solve, []

    def answered(given, begin, start):
        asked.append(start)
        found = solve(given, begin, start)
        if start not in starts:
            return found
        run = replace(found.run, status=status)
        return found._replace(answer=found.answer._replace(run=run))

    monkeypatch.setattr(rounds, "solve", answered)
    return asked


@pytest.mark.parametrize("status", STATUSES)
@pytest.mark.parametrize("name", ["no limit near", "along the rate limit"])
def test_what_ipopt_does_not_solve_is_solved_once_more_cold(name, status, monkeypatch):
    first = "near" if name == "no limit near" else "warm"
    asked = told(monkeypatch, status, (first,))
    slew = optimal_slew(SLEWS[name])
    is_taken = status in ("Solved_To_Acceptable_Level", "Search_Direction_Becomes_Too_Small")
    assert asked[-1] == (first if is_taken else "cold")
    assert slew.runs[0].status == (status if is_taken else "Solve_Succeeded")
    assert slew.status == ("optimal",)


@pytest.mark.parametrize("status", STATUSES[2:])
@pytest.mark.parametrize("name", ["no limit near", "along the rate limit"])
def test_what_then_fails_is_flown_by_a_motion_that_is_named(name, status, monkeypatch):
    told(monkeypatch, status, ("near", "warm", "cold", "roomy"))
    slew = optimal_slew(SLEWS[name])
    assert slew.status == (FEASIBLE,)
    assert slew.runs == (None,)
    for values, (low, high) in zip(sampled(slew.profiles[0]), LIMITS.bounds, strict=True):
        assert low - 2e-9 * (high - low) <= values.min()
        assert values.max() <= high + 2e-9 * (high - low)


def test_what_rows_cannot_carry_then_is_refused(monkeypatch):
    told(monkeypatch, "Restoration_Failed", ("near", "warm", "cold", "roomy"))
    monkeypatch.setattr("planner.motion.slew.optimal.reproduces", lambda *_: False)
    with pytest.raises(InfeasibleSlew, match="one row more"):
        optimal_slew(SLEWS["along the rate limit"], on_rows=True)


def test_without_piqp_ipopt_places_the_knots_too(monkeypatch):
    with_piqp = optimal_slew(SLEWS["along the rate limit"])
    monkeypatch.setattr(rounds, "has_piqp", lambda: False)
    alone = optimal_slew(SLEWS["along the rate limit"])
    assert alone.status == ("optimal",)
    assert alone.iterations > with_piqp.iterations
    assert alone.jerk_squared_integral == pytest.approx(with_piqp.jerk_squared_integral, rel=1e-3)


def test_what_need_not_move_costs_nothing_and_is_optimal():
    still = optimal_slew(SLEWS["needn't move"])
    assert still.status == ("optimal",)
    assert math.isclose(still.profiles[0].extremes[0].greatest, math.radians(5.0), abs_tol=1e-12)
    moved = replace(SLEWS["needn't move"], end=(deg_state(5.0 + 1e-9),))
    assert optimal_slew(moved).status == ("optimal",)


@pytest.mark.parametrize("on_rows", [False, True])
def test_the_derivatives_that_solvers_are_given_are_those_of_the_programme(on_rows):
    """Those of modes, full rows in which CasADi would look for zeros, are written out."""
    given = ocp.slew_ocp(3, on_rows=on_rows, residuals=2)
    by_casadi = ca.Function("g_by_x", [given.x, given.p], [ca.jacobian(given.g, given.x)])
    rng = np.random.default_rng(1)
    x, p = rng.normal(size=given.x.numel()), rng.normal(size=given.p.numel())
    g, g_by_x = given.jacobian()(x, p)
    assert np.asarray(g_by_x) == pytest.approx(np.asarray(by_casadi(x, p)), rel=1e-12, abs=1e-12)
    # No constant is left out of a quadratic programme, which has no place for one.
    assert np.asarray(g).ravel() == pytest.approx(np.asarray(g_by_x) @ x, rel=1e-9, abs=1e-9)


def test_piqp_and_ipopt_spare_modes_alike(monkeypatch):
    by_both = optimal_slew(SLEWS["modes"])
    monkeypatch.setattr(rounds, "has_piqp", lambda: False)
    by_ipopt = optimal_slew(SLEWS["modes"])
    assert by_both.status == by_ipopt.status == ("modes suppressed",)
    assert by_both.jerk_squared_integral == pytest.approx(by_ipopt.jerk_squared_integral, rel=1e-2)


def test_a_slew_of_one_row_leaves_nothing_to_choose():
    """Three equations for the two jerks of its span: Ipopt, asked with modes, would crash."""
    for end in (deg_state(5.1, 0.5), deg_state(5.1001, 0.501)):
        slew = optimal_slew(posed(deg_state(5, 0.5), end, 0.2, avoid_modes=(MODE,)), on_rows=True)
        assert slew.status == ("optimal",)
    with pytest.raises(InfeasibleSlew):
        optimal_slew(posed(deg_state(5, 0.5), deg_state(5.2, 0.5), 0.2, avoid_modes=(MODE,)))


def test_more_equations_than_unknowns_are_not_solved():
    x = ca.SX.sym("x", 2)
    programme = {"x": x, "p": ca.SX.sym("p"), "f": ca.sumsqr(x), "g": ca.vertcat(x, x[0] + x[1])}
    solver = Solver(programme, {}, Work(0.0, 0.0), multiplier_bound=1e12)
    answer = solver.solve(x0=np.ones(2), lbx=[-1.0, -1.0], lbg=np.zeros(3), ubg=np.zeros(3))
    assert answer.run.status == "Not_Enough_Degrees_Of_Freedom"
    assert not answer.run.is_promising
