"""The lower bound of a slew's cost is one, whatever the multipliers it is made from."""

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize
from slew_cases import draw_cases, least_shared_s

from planner.motion.slew import optimal_slew
from planner.motion.slew.lower_bound import lower_bound

KNOTS = np.linspace(0.0, 1.0, 9)
CONTACTS = np.array([[0.2, 1.0, 300.0], [0.45, 0.0, -500.0], [0.7, 2.0, 20.0], [0.97, 1.0, -900.0]])


def dual_by_quadrature(prices, ends, limits, contacts):
    """The least of half the squared jerk less what prices pay, written from the start's side alone.

    prices: of the end's acceleration, rate, angle.
    """
    (q0, v0, a0), end = ends
    drift = (
        lambda t: q0 + v0 * t + a0 * t * t / 2.0,
        lambda t: v0 + a0 * t,
        lambda _: a0,
    )

    def costate(tau):
        left = 1.0 - tau
        w = prices[0] + prices[1] * left + prices[2] * left**2 / 2.0
        for at, order, multiplier in contacts:
            if tau < at:
                w -= multiplier * ((at - tau) ** 2 / 2.0, at - tau, 1.0)[int(order)]
        return w

    def cheapest(tau):
        w = costate(tau)
        u = np.clip(w, *limits[3])
        return u * u / 2.0 - u * w

    owed = sum(
        multiplier * (drift[int(order)](at) - limits[int(order), 1 if multiplier > 0.0 else 0])
        for at, order, multiplier in contacts
    )
    moved = [end[2] - drift[2](1.0), end[1] - drift[1](1.0), end[0] - drift[0](1.0)]
    integral = quad(cheapest, 0.0, 1.0, points=contacts[:, 0], limit=400, epsabs=1e-9)[0]
    return integral + owed + np.dot(prices, moved)


@pytest.mark.parametrize("jerk_max", [40.0, 1e3])
def test_it_is_the_dual_at_its_best_prices(jerk_max):
    """Against quadrature and a general minimiser; they agree to what the quadrature is good for."""
    ends = np.array([[0.0, 0.4, -1.0], [1.0, -0.2, 0.5]])
    limits = np.array([[-0.5, 1.1], [-1.6, 1.6], [-9.0, 9.0], [-jerk_max, jerk_max]])
    bound, _ = lower_bound(ends, limits, CONTACTS, KNOTS, np.zeros((8, 2)))

    def less(prices):
        return -dual_by_quadrature(prices, ends, limits, CONTACTS)

    found = minimize(
        less,
        np.zeros(3),
        method="Nelder-Mead",
        options={"maxiter": 4000, "xatol": 1e-6, "fatol": 1e-9},
    )
    assert bound == pytest.approx(-2.0 * found.fun, rel=1e-5, abs=1e-4)


def test_no_motion_on_a_fine_grid_costs_less():
    """Jerk constant on 300 cells, limits kept at their ends, is a motion up to 1e-4 of a limit."""
    rng = np.random.default_rng(5)
    for _ in range(20):
        jerk = rng.uniform(-1.0, 1.0, 300).cumsum() + rng.uniform(-10.0, 10.0)
        rate_and_angle = np.zeros((301, 3))
        for k, u in enumerate(jerk):
            q, v, a = rate_and_angle[k]
            h = 1.0 / 300.0
            rate_and_angle[k + 1] = (
                q + h * (v + h * (a / 2.0 + h * u / 6.0)),
                v + h * (a + h * u / 2.0),
                a + h * u,
            )
        limits = np.array(
            [
                *([x.min() - 1e-3, x.max() + 1e-3] for x in rate_and_angle.T),
                [jerk.min(), jerk.max()],
            ]
        )
        limits[3] = np.array([-1.0, 1.0]) * np.abs(jerk).max()
        contacts = np.column_stack(
            [rng.uniform(0.0, 1.0, 6), rng.integers(0, 3, 6), rng.normal(0.0, 50.0, 6)]
        )
        bound, _ = lower_bound(rate_and_angle[[0, -1]], limits, contacts, KNOTS, np.zeros((8, 2)))
        assert bound <= np.mean(jerk**2) * (1.0 + 1e-9)


def test_what_is_called_optimal_is_within_a_thousandth_of_it():
    for number, case in enumerate(draw_cases(seed=21, count=12)):
        problem = case.problem(least_shared_s(case) * (1.02, 1.2, 3.0)[number % 3])
        solution = optimal_slew(problem)
        for profile, status, bound in zip(
            solution.profiles, solution.status, solution.lower_bounds_rad2_s5, strict=True
        ):
            cost = profile.jerk_squared_integral
            assert bound <= cost * (1.0 + 1e-9)
            assert (status == "optimal") == (cost - bound <= 1e-3 * cost)
