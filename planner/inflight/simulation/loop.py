"""The drives' loops closed about the axes, one control step after the other, compiled."""

import math
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array, Indices
from planner.base.compiled import compiled, lean
from planner.inflight.simulation.plant import (
    AXIS_STATES,
    BRISTLE,
    MODE_STATES,
    RATE,
    AxesPlant,
    derivative,
    friction,
    relative_rate_rad_s,
    steady_bristle,
)
from planner.inflight.simulation.rosenbrock import (
    Scratch,
    Torque,
    between,
    scratch_for,
    step,
    torque_at,
)
from planner.world.platforms.drive import CONTROL_STEP_S

# Absolute, per step: a thousandth of an arcsecond, and a hundredth over an exposure of 0.3 s.
ANGLE_TOLERANCE_RAD = 5e-9
RATE_TOLERANCE_RAD_S = 2e-7
REVERSAL_RAD_S = 1e-10  # at which a rate counts as none: 2e-5 arcsec/s
_LEAST_STEP_S = 1e-7
_SAFETY, _SHRINK, _GROW = 0.9, 0.2, 5.0


class Loop(NamedTuple):
    """The control law of both axes and what their drives can give; arrays (2,)."""

    integral_per_s3: Array
    proportional_per_s2: Array
    derivative_per_s: Array
    derivative_share: Array
    torque_max_rad_s2: Array
    lag_s: Array
    play_rad: Array  # half the backlash
    encoder_step_rad: Array


class Command(NamedTuple):
    """What n control steps follow: the table between rows, as late as it is received."""

    angle_rad: Array  # (n, 2)
    rate_rad_s: Array  # (n, 2)
    acceleration_rad_s2: Array  # (n, 2), mean over the step that begins here


class LoopLog(NamedTuple):
    """What n control steps began with."""

    angle_rad: Array  # (n, 2), of the shaft
    rate_rad_s: Array  # (n, 2), of the shaft
    encoder_rad: Array  # (n, 2)
    torque_rad_s2: Array  # (n, 2), commanded in the step
    states: Array  # (n, k)
    steps: Indices  # (1,), of the integration, those taken again included


@compiled
def advance(
    plant: AxesPlant,
    state: Array,
    signs: Array,
    torque: Torque,
    tolerance_limits: Array,
    play_rad: Array,
    shaft_rad: Array,
    duration_s: float,
    first_step_s: float,
    scratch: Scratch,
) -> tuple[float, int]:
    """Integrate over a duration; returns the step to try next and how many were tried.

    Where an axis comes to rest the friction's law has a kink, and a step ends.
    """
    t_s, step_s, tried = 0.0, first_step_s, 0
    while t_s < duration_s:
        left_s = duration_s - t_s
        whole = step_s >= 0.999 * left_s
        trial_s = left_s if whole else step_s
        step(plant, state, signs, torque, t_s, trial_s, scratch)
        tried += 1
        error = 0.0
        for i in range(len(state)):
            error = max(error, abs(scratch.error_states[i]) / tolerance_limits[i])
        scale = _SAFETY * error**-0.25 if error > 0.0 else _GROW
        if not error <= 1.0 and trial_s > _LEAST_STEP_S:
            step_s = trial_s * max(_SHRINK, scale)
            continue
        reversal = _first_reversal(plant, state, signs, scratch)
        if reversal < 1.0:
            # Again, up to where the first axis comes to rest.
            trial_s = max(reversal * trial_s, _LEAST_STEP_S)
            whole = trial_s >= left_s
            step(plant, state, signs, torque, t_s, trial_s, scratch)
            tried += 1
        for i in range(len(state)):
            state[i] = scratch.end_states[i]
        t_s = duration_s if whole else t_s + trial_s
        step_s = max(trial_s, step_s) * min(_GROW, max(_SHRINK, scale))
        _take_up_play(state, play_rad, shaft_rad)
        _set_signs(plant, state, signs, torque, t_s, scratch)
    return step_s, tried


@lean
def _first_reversal(plant: AxesPlant, state: Array, signs: Array, scratch: Scratch) -> float:
    """Share of the step at which an axis first comes to rest; 1 if none does."""
    first = 1.0
    for axis in range(2):
        end = signs[axis] * relative_rate_rad_s(plant, scratch.end_states, axis)
        start = signs[axis] * relative_rate_rad_s(plant, state, axis)
        if end >= -REVERSAL_RAD_S or start <= REVERSAL_RAD_S:
            continue
        low, high = 0.0, 1.0
        while high - low > 1e-12:
            middle = 0.5 * (low + high)
            between(state, scratch, middle, scratch.stage_states)
            if signs[axis] * relative_rate_rad_s(plant, scratch.stage_states, axis) > 0.0:
                low = middle
            else:
                high = middle
        first = min(first, high)
    return first


@lean
def _set_signs(
    plant: AxesPlant, state: Array, signs: Array, torque: Torque, t_s: float, scratch: Scratch
) -> None:
    """Each axis's: of its rate, or of its acceleration where it has come to rest."""
    known = True
    for axis in range(2):
        rate = relative_rate_rad_s(plant, state, axis)
        if abs(rate) > REVERSAL_RAD_S:
            signs[axis] = 1.0 if rate > 0.0 else -1.0
        else:
            known = False
    if known:
        return
    torque_at(torque, t_s, scratch.torque_rad_s2)
    derivative(
        plant, state, scratch.torque_rad_s2, signs, scratch.rubbed_parameters, scratch.slope_states
    )
    for axis in range(2):
        if abs(relative_rate_rad_s(plant, state, axis)) <= REVERSAL_RAD_S:
            signs[axis] = 1.0 if scratch.slope_states[AXIS_STATES * axis + RATE] > 0.0 else -1.0


@lean
def _take_up_play(state: Array, play_rad: Array, shaft_rad: Array) -> None:
    """The shaft stays until the gear has crossed its play."""
    for axis in range(2):
        gear = state[AXIS_STATES * axis]
        shaft_rad[axis] = min(max(shaft_rad[axis], gear - play_rad[axis]), gear + play_rad[axis])


@compiled
def tolerances(modes: int) -> Array:
    """What a step's error may be, of each state."""
    out = np.empty(2 * AXIS_STATES + MODE_STATES * modes)
    for axis in range(2):
        first = AXIS_STATES * axis
        out[first] = out[first + BRISTLE] = ANGLE_TOLERANCE_RAD
        out[first + RATE] = RATE_TOLERANCE_RAD_S
    for j in range(modes):
        out[2 * AXIS_STATES + MODE_STATES * j] = ANGLE_TOLERANCE_RAD
        out[2 * AXIS_STATES + MODE_STATES * j + 1] = RATE_TOLERANCE_RAD_S
    return out


@compiled
def close_loops(plant: AxesPlant, loop: Loop, command: Command, noise_rad: Array) -> LoopLog:
    """Fly n control steps from the first one's command, settled there.

    noise_rad: (n, 2), of the encoders.
    """
    n, modes = len(command.angle_rad), len(plant.mode_rad_s)
    scratch, tolerance = scratch_for(modes), tolerances(modes)
    state, signs = np.zeros(2 * AXIS_STATES + MODE_STATES * modes), np.ones(2)
    torque = Torque(np.zeros(2), np.zeros(2), loop.lag_s)
    integral, slope, last = np.zeros(2), np.zeros(2), np.zeros(2)
    rubbed = np.zeros(6)
    for axis in range(2):
        first, rate = AXIS_STATES * axis, command.rate_rad_s[0, axis]
        state[first], state[first + RATE] = command.angle_rad[0, axis], rate
        state[first + BRISTLE] = steady_bristle(plant, axis, rate)
        signs[axis] = -1.0 if rate < 0.0 else 1.0
        friction(plant, axis, rate, state[first + BRISTLE], signs[axis], rubbed)
        pull = plant.tension_rad_s2[axis] + plant.stiffness_per_s2[axis] * state[first]
        integral[axis] = rubbed[0] + pull
        torque.command_rad_s2[axis] = integral[axis] + command.acceleration_rad_s2[0, axis]
        torque.start_rad_s2[axis] = torque.command_rad_s2[axis]
    shaft_rad = np.array([state[0], state[AXIS_STATES]])
    log = LoopLog(
        np.empty((n, 2)), np.empty((n, 2)), np.empty((n, 2)), np.empty((n, 2)),
        np.empty((n, len(state))), np.zeros(1, dtype=np.intp),
    )  # fmt: skip
    step_s = CONTROL_STEP_S
    for tick in range(n):
        for axis in range(2):
            gear = state[AXIS_STATES * axis]
            # Where the play is taken up, the shaft turns with the gear.
            rate = relative_rate_rad_s(plant, state, axis)
            pushed = rate * (gear - shaft_rad[axis]) >= abs(rate) * loop.play_rad[axis]
            log.angle_rad[tick, axis] = shaft_rad[axis]
            log.rate_rad_s[tick, axis] = rate if pushed else 0.0
            log.encoder_rad[tick, axis] = _count(
                gear + noise_rad[tick, axis], loop.encoder_step_rad[axis]
            )
            error = command.angle_rad[tick, axis] - log.encoder_rad[tick, axis]
            if tick > 0:
                keep = loop.derivative_share[axis]
                rise = (error - last[axis]) / CONTROL_STEP_S
                slope[axis] = keep * slope[axis] + (1.0 - keep) * rise
            last[axis] = error
            wanted = (
                command.acceleration_rad_s2[tick, axis]
                + integral[axis]
                + loop.proportional_per_s2[axis] * error
                + loop.derivative_per_s[axis] * slope[axis]
            )
            most = loop.torque_max_rad_s2[axis]
            given = min(max(wanted, -most), most)
            if given == wanted:  # else the integral would wind up
                integral[axis] += loop.integral_per_s3[axis] * error * CONTROL_STEP_S
            if tick > 0:
                missing = torque.start_rad_s2[axis] - torque.command_rad_s2[axis]
                torque.start_rad_s2[axis] = torque.command_rad_s2[axis]
                if loop.lag_s[axis] > 0.0:
                    torque.start_rad_s2[axis] += missing * math.exp(
                        -CONTROL_STEP_S / loop.lag_s[axis]
                    )
            torque.command_rad_s2[axis] = given
            log.torque_rad_s2[tick, axis] = given
        log.states[tick] = state
        _set_signs(plant, state, signs, torque, 0.0, scratch)
        step_s, tried = advance(
            plant,
            state,
            signs,
            torque,
            tolerance,
            loop.play_rad,
            shaft_rad,
            CONTROL_STEP_S,
            step_s,
            scratch,
        )
        log.steps[0] += tried
    return log


@lean
def _count(angle_rad: float, step_rad: float) -> float:
    """The nearest whole count."""
    return angle_rad if step_rad == 0.0 else step_rad * math.floor(angle_rad / step_rad + 0.5)
