"""Friction behaves as where its law was published.

Canudas de Wit, Olsson, Astrom, Lischinsky: A New Model for Control of Systems with Friction, IEEE
Trans. Automatic Control 40 (1995), table I: sigma_0 1e5 N/m, sigma_1 sqrt(1e5) N s/m, sigma_2
0.4 N s/m, Fc 1 N, Fs 1.5 N, vs 0.001 m/s; a mass of 1 kg.  The simulator's radians are metres here.
The reference integrates the published equations with SciPy's LSODA.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from planner.inflight.simulation.loop import advance, tolerances
from planner.inflight.simulation.plant import plant_of
from planner.inflight.simulation.rosenbrock import Torque, scratch_for
from planner.world.platforms import IDEAL_DRIVE, ISS_HRC

SIGMA_0, SIGMA_1, SIGMA_2, COULOMB, BREAKAWAY, STRIBECK = 1e5, math.sqrt(1e5), 0.4, 1.0, 1.5, 1e-3
SPRING_N_M, PULL_M_S = 2.0, 0.1
# A force that follows its command with this time constant rises evenly, to 2e-6 within 30 s.
LONG_S = 1e7
PRECISION_SHARE = 0.01  # of the simulator's tolerances: presliding is 1e-5 m


def friction_n(v, z):
    g = COULOMB + (BREAKAWAY - COULOMB) * math.exp(-((v / STRIBECK) ** 2))
    dz = v - SIGMA_0 * abs(v) * z / g
    return SIGMA_0 * z + SIGMA_1 * dz + SIGMA_2 * v, dz


def published_motion(force_n, stops_s, start, output_s):
    """x, v, z at output_s by LSODA, begun anew where the force has a kink."""
    states, t_s, y = [np.array([start])], 0.0, np.array(start)
    for stop_s in stops_s:
        inside = output_s[(output_s > t_s) & (output_s <= stop_s)]

        def slope(t, y):
            friction, dz = friction_n(y[1], y[2])
            return [y[1], force_n(t, y[0]) - friction, dz]

        flown = solve_ivp(
            slope, (t_s, stop_s), y, method="LSODA", rtol=1e-9, atol=1e-12, t_eval=inside
        )
        states.append(flown.y.T)
        t_s, y = stop_s, flown.y[:, -1]
    return np.concatenate(states)


def our_motion(spring_n_m, ramps_n_s, output_s):
    """The same by the simulator; ramps_n_s: (rate, until) of a force that begins at zero."""
    one = np.array([1.0, 0.0])
    plant = plant_of(ISS_HRC, (IDEAL_DRIVE, IDEAL_DRIVE))._replace(
        bristle_per_s2=SIGMA_0 * one, bristle_per_s=SIGMA_1 * one, coulomb_rad_s2=COULOMB * one,
        breakaway_rad_s2=BREAKAWAY * one, stribeck_rad_s=np.full(2, STRIBECK),
        viscous_per_s=SIGMA_2 * one, stiffness_per_s2=spring_n_m * one,
        c_outer_parameters=np.zeros(0), c_inner_parameters=np.zeros((0, 3)),
        outer_share=np.zeros(0), inner_share=np.zeros(0), mode_rad_s=np.zeros(0),
        mode_damping_per_s=np.zeros(0),
    )  # fmt: skip
    y, signs, scratch = np.zeros(6), np.ones(2), scratch_for(0)
    found, force_n, t_s, step_s, tried = [y[:3].copy()], 0.0, 0.0, 1e-4, 0
    for next_s in output_s[1:]:
        rate_n_s = next(rate for rate, until_s in ramps_n_s if next_s <= until_s + 1e-9)
        start = np.array([force_n, 0.0])
        torque = Torque(start + rate_n_s * LONG_S * one, start, np.full(2, LONG_S))
        step_s, count = advance(
            plant, y, signs, torque, PRECISION_SHARE * tolerances(0), np.zeros(2), np.zeros(2),
            next_s - t_s, step_s, scratch,
        )  # fmt: skip
        force_n += rate_n_s * (next_s - t_s)
        t_s = next_s
        tried += count
        found.append(y[:3].copy())
    return np.array(found), tried


def test_stick_slip_of_a_mass_pulled_by_a_spring():
    """The paper's: m = 1 kg, k = 2 N/m, the spring's end at 0.1 m/s."""
    t_s = np.linspace(0.0, 30.0, 3001)
    published = published_motion(
        lambda t, x: SPRING_N_M * (PULL_M_S * t - x), [30.0], np.zeros(3), t_s
    )
    ours, tried = our_motion(SPRING_N_M, [(SPRING_N_M * PULL_M_S, 30.0)], t_s)
    np.testing.assert_allclose(ours[:, 0], published[:, 0], rtol=0, atol=1e-5)  # of 2.6 m
    np.testing.assert_allclose(ours[:, 1], published[:, 1], rtol=0, atol=1e-4)  # of 0.3 m/s
    assert tried < 20_000  # a slip takes 10^4 of the bristles' time constants
    # What the paper shows: rest until the spring pulls with Fs, then slips with rests between.
    spring_n = SPRING_N_M * (PULL_M_S * t_s - ours[:, 0])
    is_stuck = np.abs(ours[:, 1]) < 1e-3 * PULL_M_S
    slips = np.flatnonzero(is_stuck[:-1] & ~is_stuck[1:])
    assert len(slips) >= 3
    np.testing.assert_allclose(spring_n[slips], BREAKAWAY, rtol=0.05)
    assert np.mean(is_stuck) > 0.5
    assert np.max(np.abs(spring_n)) < 1.02 * BREAKAWAY


def test_presliding_is_a_stiff_spring_with_hysteresis():
    """The paper's: to 95 % of Fs at 0.1 N/s, held, and to the opposite and back."""
    top_n, rate_n_s = 0.95 * BREAKAWAY, 0.1
    up_s = top_n / rate_n_s
    stops_s = np.cumsum([up_s, 5.0, 2.0 * up_s, 5.0, 2.0 * up_s])
    ramps = list(zip([rate_n_s, 0.0, -rate_n_s, 0.0, rate_n_s], stops_s, strict=True))
    knots = ([0.0, *stops_s], [0.0, top_n, top_n, -top_n, -top_n, top_n])
    t_s = np.unique(np.concatenate([np.linspace(0.0, stops_s[-1], 1500), stops_s]))
    published = published_motion(lambda t, _: np.interp(t, *knots), stops_s, np.zeros(3), t_s)
    ours, _ = our_motion(0.0, ramps, t_s)
    size_m = np.abs(published[:, 0]).max()
    np.testing.assert_allclose(ours[:, 0], published[:, 0], rtol=0, atol=1e-3 * size_m)
    force_n = np.interp(t_s, *knots)
    small = (t_s < up_s) & (np.abs(force_n) < 0.1)
    stiffness_n_m = np.polyfit(ours[small, 0], force_n[small], 1)[0]
    assert stiffness_n_m == pytest.approx(SIGMA_0, rel=0.05)
    falling, rising = (t_s > stops_s[1]) & (t_s < stops_s[2]), t_s > stops_s[3]
    apart_m = np.interp(0.0, force_n[rising], ours[rising, 0]) - np.interp(
        0.0, -force_n[falling], ours[falling, 0]
    )
    assert abs(apart_m) > 0.1 * size_m
