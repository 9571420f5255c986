"""The axes on their carrier: equations of motion and their derivatives, compiled.

Of axis i: angle theta_i, its rate relative to the base w_i, the rate about the axis in inertial
space s_i, the friction's bristle z_i.  Of mode j: the base's small turn q_j about e_j.
    w_1 = s_1 - sum c_1j q_j'        c_1j = outer . e_j
    w_2 = s_2 - sum c_2j q_j'        c_2j = R(outer, theta_1) inner . e_j
    a_i = u_i - F_i(z_i, w_i) - tension_i - stiffness_i theta_i
    s_1' = a_1 + (J_2 / J_1) s_2 sum dc_2j/dtheta_1 q_j'        s_2' = a_2
    q_j'' = -W_j^2 q_j - 2 d_j W_j q_j' - (J_1 / M_j) c_1j s_1'
            - (J_2 / M_j) (c_2j a_2 + s_2 dc_2j/dtheta_1 w_1)
These are Lagrange's, of J_1 s_1^2 / 2 + J_2 s_2^2 / 2 + sum M_j q_j'^2 / 2 and the springs: without
friction and damping they keep energy, and each free mode its momentum
M_j q_j' + J_1 c_1j s_1 + J_2 c_2j s_2.  Neglected: centrifugal and Coriolis torques between the
axes, unbalanced masses, the axes' share in the carrier's turn about other directions.
Friction is LuGre's (Canudas de Wit 1995, IEEE Trans. Automatic Control 40, 419):
    z' = w - sigma_0 |w| z / g(w)     g = coulomb + (breakaway - coulomb) exp(-(w / stribeck)^2)
    F = sigma_0 z + sigma_1 z' + viscous w
"""

import math
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.compiled import compiled, lean
from planner.world.platforms import AxisDrive, TwoAxisPlatform

ANGLE, RATE, BRISTLE = 0, 1, 2  # of an axis's three states
AXIS_STATES, MODE_STATES = 3, 2
_ARCSEC_RAD = math.radians(1.0 / 3600.0)


class AxesPlant(NamedTuple):
    """Two axes and m modes; friction and cable over the axis's inertia.

    c_outer: (m,).  c_inner: (m, 3), the constant part, the cosine's and the sine's of theta_1.
    outer_share, inner_share: (m,), the axis's inertia over the mode's.
    """

    bristle_per_s2: Array  # (2,), zero where there is no friction
    bristle_per_s: Array  # (2,)
    coulomb_rad_s2: Array  # (2,)
    breakaway_rad_s2: Array  # (2,)
    stribeck_rad_s: Array  # (2,)
    viscous_per_s: Array  # (2,)
    tension_rad_s2: Array  # (2,)
    stiffness_per_s2: Array  # (2,)
    inertia_ratio: float  # inner over outer
    c_outer_parameters: Array  # (m,)
    c_inner_parameters: Array  # (m, 3)
    outer_share: Array  # (m,)
    inner_share: Array  # (m,)
    mode_rad_s: Array  # (m,)
    mode_damping_per_s: Array  # (m,), 2 d W


def plant_of(platform: TwoAxisPlatform, drives: tuple[AxisDrive, AxisDrive]) -> AxesPlant:
    """The platform's, with these drives."""

    def each(name: str, unit_value: float = 1.0) -> Array:
        return np.array([unit_value * getattr(drive, name) for drive in drives])

    modes = platform.structural_modes
    e = np.array([mode.axis_platform for mode in modes]).reshape(-1, 3)
    outer, inner = platform.axes_platform
    along = np.dot(outer, inner) * outer
    inertia_kg_m2 = np.array([mode.inertia_kg_m2 for mode in modes])
    mode_rad_s = 2.0 * math.pi * np.array([mode.frequency_hz for mode in modes])
    return AxesPlant(
        bristle_per_s2=each("bristle_per_s2"),
        bristle_per_s=each("bristle_per_s"),
        coulomb_rad_s2=each("coulomb_deg_s2", math.radians(1.0)),
        breakaway_rad_s2=each("breakaway_deg_s2", math.radians(1.0)),
        stribeck_rad_s=each("stribeck_arcmin_s", 60.0 * _ARCSEC_RAD),
        viscous_per_s=each("viscous_per_s"),
        tension_rad_s2=each("cable_tension_deg_s2", math.radians(1.0)),
        stiffness_per_s2=each("cable_stiffness_per_s2"),
        inertia_ratio=drives[1].inertia_kg_m2 / drives[0].inertia_kg_m2,
        c_outer_parameters=e @ outer,
        c_inner_parameters=np.stack(
            [e @ along, e @ (inner - along), e @ np.cross(outer, inner)], axis=1
        ),
        outer_share=drives[0].inertia_kg_m2 / inertia_kg_m2,
        inner_share=drives[1].inertia_kg_m2 / inertia_kg_m2,
        mode_rad_s=mode_rad_s,
        mode_damping_per_s=2.0 * np.array([mode.damping for mode in modes]) * mode_rad_s,
    )


@lean
def steady_bristle(plant: AxesPlant, axis: int, rate_rad_s: float) -> float:
    """Of an axis that has long turned at this rate, rad."""
    if plant.bristle_per_s2[axis] == 0.0 or rate_rad_s == 0.0:
        return 0.0
    swept = rate_rad_s / plant.stribeck_rad_s[axis]
    coulomb = plant.coulomb_rad_s2[axis]
    g = coulomb + (plant.breakaway_rad_s2[axis] - coulomb) * math.exp(-swept * swept)
    return math.copysign(g / plant.bristle_per_s2[axis], rate_rad_s)


@lean
def relative_rate_rad_s(plant: AxesPlant, states: Array, axis: int) -> float:
    """w of the axis."""
    rate: float = states[AXIS_STATES * axis + RATE]
    modes = len(plant.mode_rad_s)
    if modes == 0:
        return float(rate)
    cosine, sine = math.cos(states[ANGLE]), math.sin(states[ANGLE])
    for j in range(modes):
        swing = states[2 * AXIS_STATES + MODE_STATES * j + 1]
        if axis == 0:
            rate -= plant.c_outer_parameters[j] * swing
        else:
            c = plant.c_inner_parameters[j]
            rate -= (c[0] + c[1] * cosine + c[2] * sine) * swing
    return float(rate)


@lean
def friction(
    plant: AxesPlant,
    axis: int,
    rate_rad_s: float,
    bristle_rad: float,
    sign: float,
    found_parameters: Array,
) -> None:
    """F and z', then their derivatives by w and by z, into found_parameters (6,).

    sign: +1 or -1, of the rate: |w| is taken as sign * w, so that it stays smooth in a step
    that runs over a reversal.
    """
    found_parameters[:] = 0.0
    sigma_0, sigma_1 = plant.bristle_per_s2[axis], plant.bristle_per_s[axis]
    if sigma_0 > 0.0:
        coulomb = plant.coulomb_rad_s2[axis]
        swept = rate_rad_s / plant.stribeck_rad_s[axis]
        fall = (plant.breakaway_rad_s2[axis] - coulomb) * math.exp(-swept * swept)
        g = coulomb + fall
        dg = -2.0 * swept * fall / plant.stribeck_rad_s[axis]
        loaded = sigma_0 * sign * bristle_rad / g
        found_parameters[1] = rate_rad_s * (1.0 - loaded)
        found_parameters[3] = 1.0 - loaded + rate_rad_s * loaded * dg / g
        found_parameters[5] = -sigma_0 * sign * rate_rad_s / g
    viscous = plant.viscous_per_s[axis]
    found_parameters[0] = (
        sigma_0 * bristle_rad + sigma_1 * found_parameters[1] + viscous * rate_rad_s
    )
    found_parameters[2] = sigma_1 * found_parameters[3] + viscous
    found_parameters[4] = sigma_0 + sigma_1 * found_parameters[5]


@compiled
def derivative(
    plant: AxesPlant,
    states: Array,
    torque_rad_s2: Array,
    signs: Array,
    rubbed_parameters: Array,
    slope_states: Array,
) -> None:
    """d states / dt into slope_states; rubbed_parameters is a scratch array (6,)."""
    modes = len(plant.mode_rad_s)
    cosine, sine = (math.cos(states[0]), math.sin(states[0])) if modes else (1.0, 0.0)
    outer_rate, inner_rate = states[RATE], states[AXIS_STATES + RATE]
    sweep = 0.0  # sum dc_2j/dtheta_1 q_j'
    for j in range(modes):
        swing = states[2 * AXIS_STATES + MODE_STATES * j + 1]
        c = plant.c_inner_parameters[j]
        outer_rate -= plant.c_outer_parameters[j] * swing
        inner_rate -= (c[0] + c[1] * cosine + c[2] * sine) * swing
        sweep += (c[2] * cosine - c[1] * sine) * swing
    for axis in range(2):
        first = AXIS_STATES * axis
        rate = outer_rate if axis == 0 else inner_rate
        friction(plant, axis, rate, states[first + BRISTLE], signs[axis], rubbed_parameters)
        pull = plant.tension_rad_s2[axis] + plant.stiffness_per_s2[axis] * states[first]
        slope_states[first] = rate
        slope_states[first + RATE] = torque_rad_s2[axis] - rubbed_parameters[0] - pull
        slope_states[first + BRISTLE] = rubbed_parameters[1]
    s_2, a_2 = states[AXIS_STATES + RATE], slope_states[AXIS_STATES + RATE]
    slope_states[RATE] += plant.inertia_ratio * s_2 * sweep
    for j in range(modes):
        k = 2 * AXIS_STATES + MODE_STATES * j
        c = plant.c_inner_parameters[j]
        c_2 = c[0] + c[1] * cosine + c[2] * sine
        dc_2 = c[2] * cosine - c[1] * sine
        slope_states[k] = states[k + 1]
        slope_states[k + 1] = (
            -(plant.mode_rad_s[j] ** 2) * states[k]
            - plant.mode_damping_per_s[j] * states[k + 1]
            - plant.outer_share[j] * plant.c_outer_parameters[j] * slope_states[RATE]
            - plant.inner_share[j] * (c_2 * a_2 + s_2 * dc_2 * outer_rate)
        )


@compiled
def jacobian(
    plant: AxesPlant,
    states: Array,
    slope_states: Array,
    signs: Array,
    rubbed_parameters: Array,
    slope_matrix: Array,
) -> None:
    """d derivative / d states into slope_matrix (n, n); slope_states is the derivative itself."""
    modes = len(plant.mode_rad_s)
    slope_matrix[:] = 0.0
    o_s, i_s = RATE, AXIS_STATES + RATE
    cosine, sine = (math.cos(states[0]), math.sin(states[0])) if modes else (1.0, 0.0)
    sweep, turn = 0.0, 0.0  # sums of dc_2j/dtheta_1 q_j' and d2c_2j/dtheta_1^2 q_j'
    outer_rate, inner_rate = states[o_s], states[i_s]
    slope_matrix[0, o_s] = slope_matrix[AXIS_STATES, i_s] = 1.0
    for j in range(modes):
        k = 2 * AXIS_STATES + MODE_STATES * j
        c, swing = plant.c_inner_parameters[j], states[k + 1]
        c_2 = c[0] + c[1] * cosine + c[2] * sine
        outer_rate -= plant.c_outer_parameters[j] * swing
        inner_rate -= c_2 * swing
        sweep += (c[2] * cosine - c[1] * sine) * swing
        turn -= (c[1] * cosine + c[2] * sine) * swing
        slope_matrix[0, k + 1] = -plant.c_outer_parameters[j]
        slope_matrix[AXIS_STATES, k + 1] = -c_2
    slope_matrix[AXIS_STATES, 0] = -sweep
    for axis in range(2):
        first = AXIS_STATES * axis
        rate = outer_rate if axis == 0 else inner_rate
        friction(plant, axis, rate, states[first + BRISTLE], signs[axis], rubbed_parameters)
        for k in range(len(states)):
            slope_matrix[first + BRISTLE, k] = rubbed_parameters[3] * slope_matrix[first, k]
            slope_matrix[first + RATE, k] = -rubbed_parameters[2] * slope_matrix[first, k]
        slope_matrix[first + BRISTLE, first + BRISTLE] += rubbed_parameters[5]
        slope_matrix[first + RATE, first + BRISTLE] -= rubbed_parameters[4]
        slope_matrix[first + RATE, first] -= plant.stiffness_per_s2[axis]
    s_2, a_2 = states[i_s], slope_states[i_s]
    slope_matrix[o_s, i_s] += plant.inertia_ratio * sweep
    slope_matrix[o_s, 0] += plant.inertia_ratio * s_2 * turn
    for j in range(modes):
        k = 2 * AXIS_STATES + MODE_STATES * j
        c = plant.c_inner_parameters[j]
        slope_matrix[o_s, k + 1] += plant.inertia_ratio * s_2 * (c[2] * cosine - c[1] * sine)
    for j in range(modes):
        k = 2 * AXIS_STATES + MODE_STATES * j
        c = plant.c_inner_parameters[j]
        c_2 = c[0] + c[1] * cosine + c[2] * sine
        dc_2 = c[2] * cosine - c[1] * sine
        outer, inner = plant.outer_share[j] * plant.c_outer_parameters[j], plant.inner_share[j]
        for m in range(len(states)):
            slope_matrix[k + 1, m] = -outer * slope_matrix[o_s, m] - inner * (
                c_2 * slope_matrix[i_s, m] + s_2 * dc_2 * slope_matrix[0, m]
            )
        slope_matrix[k + 1, 0] -= inner * (dc_2 * a_2 + s_2 * (c[0] - c_2) * outer_rate)
        slope_matrix[k + 1, i_s] -= inner * dc_2 * outer_rate
        slope_matrix[k + 1, k] -= plant.mode_rad_s[j] ** 2
        slope_matrix[k + 1, k + 1] -= plant.mode_damping_per_s[j]
        slope_matrix[k, k + 1] = 1.0
