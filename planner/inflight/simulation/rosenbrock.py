"""One step of RODAS, a stiffly accurate Rosenbrock method of order 4 with an estimate of its error.

Coefficients: Hairer, Wanner, Solving Ordinary Differential Equations II, section VI.4 and the
authors' code RODAS.  It stays stable however fast the bristles follow a quick axis, costs one
small matrix a step and needs no start-up after a new command.
"""

import math
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.compiled import compiled, lean
from planner.inflight.simulation.plant import (
    AXIS_STATES,
    MODE_STATES,
    AxesPlant,
    derivative,
    jacobian,
)

_GAMMA = 0.25
_STAGES = 6
_A = np.array(
    (
        (0.0, 0.0, 0.0, 0.0),
        (1.544, 0.0, 0.0, 0.0),
        (0.9466785280815826, 0.2557011698983284, 0.0, 0.0),
        (3.314825187068521, 2.896124015972201, 0.9986419139977817, 0.0),
        (1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950),
    )
)
_C = np.array((
    (0.0, 0.0, 0.0, 0.0, 0.0),
    (-5.6688, 0.0, 0.0, 0.0, 0.0),
    (-2.430093356833875, -0.2063599157091915, 0.0, 0.0, 0.0),
    (-0.1073529058151375, -9.594562251023355, -20.47028614809616, 0.0, 0.0),
    (7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160, 0.0),
    (
        8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136,
        -6.058818238834054,
    ),
))  # fmt: skip
_ALPHA = np.array((0.0, 0.386, 0.21, 0.63, 1.0, 1.0))
_GAMMA_SUM = np.array((0.25, -0.1043, 0.1035, -0.03620000000000023, 0.0, 0.0))
_D = np.array((
    (
        10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823,
        1.025137723295662,
    ),
    (
        -0.6762803392801253, 6.087714651680015, 16.43084320892478, 24.76722511418386,
        -6.594389125716872,
    ),
))  # fmt: skip


class Torque(NamedTuple):
    """What the drives give at time t of a control step: command + (start - command) exp(-t / lag).

    Arrays (2,); a lag of zero follows at once.
    """

    command_rad_s2: Array
    start_rad_s2: Array
    lag_s: Array


class Scratch(NamedTuple):
    """A step's scratch, of n states; and what it leaves.

    end_state, end_error: (n,).  bend_states: (2, n), of `between`.
    """

    k_states: Array  # (stages, n)
    slope_states: Array  # (n,)
    rise_states: Array  # (n,)
    stage_states: Array  # (n,)
    matrix: Array  # (n, n)
    pivots: Indices  # (n,)
    torque_rad_s2: Array  # (2,)
    rubbed_parameters: Array  # (6,)
    end_states: Array
    error_states: Array
    bend_states: Array


@compiled
def scratch_for(modes: int) -> Scratch:
    """Scratch of a platform with this many modes."""
    n = 2 * AXIS_STATES + MODE_STATES * modes
    return Scratch(
        np.zeros((_STAGES, n)), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros((n, n)),
        np.zeros(n, dtype=np.intp), np.zeros(2), np.zeros(6), np.zeros(n), np.zeros(n),
        np.zeros((2, n)),
    )  # fmt: skip


@lean
def torque_at(torque: Torque, t_s: float, torque_rad_s2: Array) -> None:
    """Of both axes, into torque_rad_s2 (2,)."""
    for axis in range(2):
        torque_rad_s2[axis] = torque.command_rad_s2[axis]
        if torque.lag_s[axis] > 0.0:
            missing = torque.start_rad_s2[axis] - torque.command_rad_s2[axis]
            torque_rad_s2[axis] += missing * math.exp(-t_s / torque.lag_s[axis])


@lean
def _subtract_from_diagonal(matrix: Array, diagonal_value: float) -> None:
    """diagonal - matrix, in place."""
    for i in range(len(matrix)):
        for j in range(len(matrix)):
            matrix[i, j] = -matrix[i, j]
        matrix[i, i] += diagonal_value


@lean
def _factorise(matrix: Array, pivots: Indices) -> None:
    """LU in place, with partial pivoting."""
    n = len(matrix)
    for k in range(n):
        best = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[best, k]):
                best = i
        pivots[k] = best
        if best != k:
            for j in range(n):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
        inverse = 1.0 / matrix[k, k]
        for i in range(k + 1, n):
            if matrix[i, k] != 0.0:
                matrix[i, k] *= inverse
                for j in range(k + 1, n):
                    matrix[i, j] -= matrix[i, k] * matrix[k, j]


@lean
def _substitute(matrix: Array, pivots: Indices, solved_states: Array) -> None:
    """Solve in place with what `_factorise` left."""
    n = len(matrix)
    for k in range(n):
        if pivots[k] != k:
            solved_states[k], solved_states[pivots[k]] = solved_states[pivots[k]], solved_states[k]
    for i in range(1, n):
        for j in range(i):
            solved_states[i] -= matrix[i, j] * solved_states[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            solved_states[i] -= matrix[i, j] * solved_states[j]
        solved_states[i] /= matrix[i, i]


@compiled
def step(
    plant: AxesPlant,
    states: Array,
    signs: Array,
    torque: Torque,
    t_s: float,
    step_s: float,
    scratch: Scratch,
) -> None:
    """From states at t_s over step_s; the end, its error and its way are left in scratch."""
    n = len(states)
    torque_at(torque, t_s, scratch.torque_rad_s2)
    derivative(
        plant, states, scratch.torque_rad_s2, signs, scratch.rubbed_parameters, scratch.slope_states
    )
    jacobian(plant, states, scratch.slope_states, signs, scratch.rubbed_parameters, scratch.matrix)
    _subtract_from_diagonal(scratch.matrix, 1.0 / (_GAMMA * step_s))
    _factorise(scratch.matrix, scratch.pivots)
    _set_rise(plant, states, torque, t_s, scratch.rise_states)
    for stage in range(_STAGES):
        if stage > 0:
            _set_stage(states, scratch, stage)
            torque_at(torque, t_s + _ALPHA[stage] * step_s, scratch.torque_rad_s2)
            derivative(
                plant, scratch.stage_states, scratch.torque_rad_s2, signs,
                scratch.rubbed_parameters, scratch.slope_states,
            )  # fmt: skip
        k = scratch.k_states[stage]
        for i in range(n):
            total = 0.0
            for before in range(stage):
                total += _C[stage, before] * scratch.k_states[before, i]
            rise = _GAMMA_SUM[stage] * step_s * scratch.rise_states[i]
            k[i] = scratch.slope_states[i] + rise + total / step_s
        _substitute(scratch.matrix, scratch.pivots, k)
    _finish(scratch)


@lean
def _finish(scratch: Scratch) -> None:
    """The step's end, its error and its bends from the stages."""
    for i in range(len(scratch.end_states)):
        scratch.end_states[i] = scratch.stage_states[i] + scratch.k_states[5, i]
        scratch.error_states[i] = scratch.k_states[5, i]
        for bend in range(2):
            total = 0.0
            for stage in range(5):
                total += _D[bend, stage] * scratch.k_states[stage, i]
            scratch.bend_states[bend, i] = total


@lean
def _set_stage(states: Array, scratch: Scratch, stage: int) -> None:
    """The states at which a stage is taken."""
    for i in range(len(states)):
        if stage == _STAGES - 1:
            scratch.stage_states[i] += scratch.k_states[4, i]
            continue
        total = states[i]
        for before in range(stage):
            total += _A[stage, before] * scratch.k_states[before, i]
        scratch.stage_states[i] = total


@lean
def _set_rise(
    plant: AxesPlant, states: Array, torque: Torque, t_s: float, rise_states: Array
) -> None:
    """How fast the derivative rises with the drives' torques, into rise_states (n,)."""
    rise_states[:] = 0.0
    for axis in range(2):
        if torque.lag_s[axis] == 0.0:
            continue
        missing = torque.command_rad_s2[axis] - torque.start_rad_s2[axis]
        rise = missing * math.exp(-t_s / torque.lag_s[axis]) / torque.lag_s[axis]
        rise_states[AXIS_STATES * axis + 1] = rise
        for j in range(len(plant.mode_rad_s)):
            if axis == 0:
                share = plant.outer_share[j] * plant.c_outer_parameters[j]
            else:
                c = plant.c_inner_parameters[j]
                share = plant.inner_share[j] * (
                    c[0] + c[1] * math.cos(states[0]) + c[2] * math.sin(states[0])
                )
            rise_states[2 * AXIS_STATES + MODE_STATES * j + 1] -= share * rise


@lean
def between(states: Array, scratch: Scratch, share: float, middle_states: Array) -> None:
    """The states at a share of the step just taken from `states`, to order 3."""
    for i in range(len(states)):
        bend = scratch.bend_states[0, i] + share * scratch.bend_states[1, i]
        middle_states[i] = (1.0 - share) * states[i] + share * (
            scratch.end_states[i] + (1.0 - share) * bend
        )
