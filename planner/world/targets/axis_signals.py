"""The test signals an axis can be given.

Every motion gives angle, rate and acceleration in closed form, in the units of the request:
`motion_deg(t_s)` has shape (3, n) for t_s of shape (n,).  angle_deg is where the signal is
centred or starts.
"""

import math
from typing import Annotated, Literal

import numpy as np

from planner.base.arrays import Array
from planner.base.spec import Within, spec
from planner.world.targets.smooth_step import ramp, step

COMPONENTS_MAX = 100
_FrequencyHz = Annotated[float, Within(1e-4, 2.5)]  # to the Nyquist frequency of the 0.2 s table
_AngleDeg = Annotated[float, Within(-360.0, 360.0)]
_AmplitudeDeg = Annotated[float, Within(0.0, 360.0)]
_DurationS = Annotated[float, Within(1e-3, 86400.0)]


@spec
class ConstantRate:
    """angle_deg + rate_deg_s t.

    angle_deg: axis angle at t = 0.
    rate_deg_s: of the axis; 0 keeps it still. E.g. `0.5`.
    """

    kind: Literal["constant_rate"] = "constant_rate"
    angle_deg: _AngleDeg = 0.0
    rate_deg_s: _AngleDeg

    def shortest_period_s(self) -> float:
        return math.inf

    def motion_deg(self, t_s: Array) -> Array:
        rate = np.full_like(t_s, self.rate_deg_s)
        return np.stack([self.angle_deg + rate * t_s, rate, np.zeros_like(t_s)])


@spec
class Sine:
    """angle_deg + amplitude_deg sin(2 pi frequency_hz t + phase_deg).

    angle_deg: axis angle about which it swings.
    amplitude_deg: to either side. E.g. `2.0`.
    frequency_hz: whole swings a second. E.g. `0.05`.
    phase_deg: of the sine at t = 0.
    """

    kind: Literal["sine"] = "sine"
    angle_deg: _AngleDeg = 0.0
    amplitude_deg: _AmplitudeDeg
    frequency_hz: _FrequencyHz
    phase_deg: _AngleDeg = 0.0

    def shortest_period_s(self) -> float:
        return 1.0 / self.frequency_hz

    def motion_deg(self, t_s: Array) -> Array:
        omega = 2.0 * math.pi * self.frequency_hz
        phase = omega * t_s + math.radians(self.phase_deg)
        motion = self.amplitude_deg * _sine_signal(phase, omega)
        motion[0] += self.angle_deg
        return motion


@spec
class Chirp:
    """A sine whose frequency goes from start_ to stop_frequency_hz in sweep_s and stays there.

    angle_deg: axis angle about which it swings.
    amplitude_deg: to either side.
    start_frequency_hz: at t = 0.
    stop_frequency_hz: at `sweep_s` and after.
    sweep_s: time for which the frequency changes.
    sweep: "linear" in time, or "logarithmic" (equal time per octave).
    """

    kind: Literal["chirp"] = "chirp"
    angle_deg: _AngleDeg = 0.0
    amplitude_deg: _AmplitudeDeg
    start_frequency_hz: _FrequencyHz
    stop_frequency_hz: _FrequencyHz
    sweep_s: _DurationS
    sweep: Literal["linear", "logarithmic"] = "linear"

    def __post_init__(self) -> None:
        if self.start_frequency_hz == self.stop_frequency_hz:
            raise ValueError("a chirp needs two different frequencies; a sine has one")

    def shortest_period_s(self) -> float:
        return 1.0 / max(self.start_frequency_hz, self.stop_frequency_hz)

    def motion_deg(self, t_s: Array) -> Array:
        """Before t = 0 at the start frequency; the acceleration steps where the sweep ends."""
        turns, frequency, sweeping = self._sweep_phase(np.clip(t_s, 0.0, self.sweep_s))
        still = t_s - np.clip(t_s, 0.0, self.sweep_s)
        phase = 2.0 * math.pi * (turns + frequency * still)
        moving = np.where(still == 0.0, sweeping, 0.0)
        motion = self.amplitude_deg * _sine_signal(
            phase, 2.0 * math.pi * frequency, 2.0 * math.pi * moving
        )
        motion[0] += self.angle_deg
        return motion

    def _sweep_phase(self, t_s: Array) -> tuple[Array, Array, Array]:
        """Turns since t = 0, frequency (Hz) and its rate (Hz/s) within the sweep."""
        if self.sweep == "linear":
            slope = (self.stop_frequency_hz - self.start_frequency_hz) / self.sweep_s
            frequency = self.start_frequency_hz + slope * t_s
            turns = (self.start_frequency_hz + slope * t_s / 2.0) * t_s
            return turns, frequency, np.full_like(t_s, slope)
        growth = math.log(self.stop_frequency_hz / self.start_frequency_hz) / self.sweep_s
        frequency = self.start_frequency_hz * np.exp(growth * t_s)
        turns = self.start_frequency_hz * np.expm1(growth * t_s) / growth
        return turns, frequency, growth * frequency


@spec
class Step:
    """From angle_deg by step_deg, leaving at at_s and arriving rise_s later.

    Continuous jerk; peaks: rate 2.2 step/rise, acceleration 7.5 step/rise^2, jerk 52.5 step/rise^3.

    angle_deg: axis angle before it.
    step_deg: size of the step. E.g. `5.0`.
    at_s: start of the step, after t = 0.
    rise_s: duration of the step. E.g. `20.0`.
    """

    kind: Literal["step"] = "step"
    angle_deg: _AngleDeg = 0.0
    step_deg: _AngleDeg
    at_s: Annotated[float, Within(0.0, 86400.0)] = 0.0
    rise_s: _DurationS

    def shortest_period_s(self) -> float:
        return self.rise_s

    def motion_deg(self, t_s: Array) -> Array:
        rise = step((t_s - self.at_s) / self.rise_s)
        motion = self.step_deg * rise / np.array([[1.0], [self.rise_s], [self.rise_s**2]])
        motion[0] += self.angle_deg
        return np.asarray(motion)


@spec
class Triangle:
    """Constant rate up and down around angle_deg, a period in period_s, rising at t = 0.

    The turn has continuous jerk, stays 0.14 rate turn_s inside the tip, and its acceleration peaks
    at 4.4 rate/turn_s with rate = 4 amplitude_deg/period_s.

    angle_deg: axis angle in the middle.
    amplitude_deg: of the sharp triangle. E.g. `10.0`.
    period_s: once up and down. E.g. `60.0`.
    turn_s: duration of each reversal. E.g. `5.0`.
    """

    kind: Literal["triangle"] = "triangle"
    angle_deg: _AngleDeg = 0.0
    amplitude_deg: _AmplitudeDeg
    period_s: _DurationS
    turn_s: _DurationS

    def __post_init__(self) -> None:
        if self.turn_s > self.period_s / 2.0:
            raise ValueError(
                f"turn_s must be at most half of period_s, {self.period_s / 2.0:g}, "
                f"not {self.turn_s:g}"
            )

    def shortest_period_s(self) -> float:
        return self.turn_s

    def motion_deg(self, t_s: Array) -> Array:
        rate = 4.0 * self.amplitude_deg / self.period_s
        half_s = self.period_s / 2.0
        tip = np.round((t_s - half_s / 2.0) / half_s)
        side = np.where(tip % 2.0 == 0.0, 1.0, -1.0)  # +1 at the upper tips
        since_tip_s = t_s - half_s / 2.0 - tip * half_s
        turn, slope, _ = step(since_tip_s / self.turn_s + 0.5)
        falling = since_tip_s - 2.0 * ramp(since_tip_s, self.turn_s)
        motion: Array = np.stack(
            [
                self.angle_deg + side * (self.amplitude_deg + rate * falling),
                side * rate * (1.0 - 2.0 * turn),
                side * rate * -2.0 * slope / self.turn_s,
            ]
        )
        return motion


@spec
class Multisine:
    """angle_deg + the sum of amplitudes_deg[k] sin(2 pi frequencies_hz[k] t + phases_deg[k]).

    angle_deg: axis angle about which it swings.
    amplitudes_deg: of each sine.
    frequencies_hz: of each sine, as many as amplitudes.
    phases_deg: Schroeder's -pi k (k - 1)/N unless given, which keep the peak low for equal
    amplitudes (Schroeder 1970, IEEE Trans. Inf. Theory 16, 85). E.g. `[0.0, 90.0]`.
    """

    kind: Literal["multisine"] = "multisine"
    angle_deg: _AngleDeg = 0.0
    amplitudes_deg: tuple[_AmplitudeDeg, ...]
    frequencies_hz: tuple[_FrequencyHz, ...]
    phases_deg: tuple[_AngleDeg, ...] | None = None

    def __post_init__(self) -> None:
        count = len(self.frequencies_hz)
        if not 1 <= count <= COMPONENTS_MAX:
            raise ValueError(f"frequencies_hz must hold 1 to {COMPONENTS_MAX}, not {count}")
        for name in ("amplitudes_deg", "phases_deg"):
            values = getattr(self, name)
            if values is not None and len(values) != count:
                raise ValueError(
                    f"{name} must hold one for each of the {count} frequencies, not {len(values)}"
                )

    def shortest_period_s(self) -> float:
        return 1.0 / max(self.frequencies_hz)

    def motion_deg(self, t_s: Array) -> Array:
        motion = np.zeros((3, len(t_s)))
        motion[0] = self.angle_deg
        count = len(self.frequencies_hz)
        phases = [-math.pi * (k + 1) * k / count for k in range(count)]
        if self.phases_deg is not None:
            phases = [math.radians(phase_deg) for phase_deg in self.phases_deg]
        components = zip(self.amplitudes_deg, self.frequencies_hz, phases, strict=True)
        for amplitude_deg, frequency_hz, phase in components:
            omega = 2.0 * math.pi * frequency_hz
            motion += amplitude_deg * _sine_signal(omega * t_s + phase, omega)
        return motion


def _sine_signal(
    phase_rad: Array,
    phase_rate_rad_s: Array | float,
    phase_acceleration_rad_s2: Array | float = 0.0,
) -> Array:
    """A sine and its first two derivatives by time, shape (3, n)."""
    sin, cos = np.sin(phase_rad), np.cos(phase_rad)
    curvature = phase_acceleration_rad_s2 * cos - phase_rate_rad_s**2 * sin
    return np.stack([sin, phase_rate_rad_s * cos, curvature])
