"""A table as a platform's drives really fly it."""

import math
from dataclasses import dataclass

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.commands import COMMAND_STEP_S, CommandTable
from planner.inflight.simulation.loop import Command, Loop, LoopLog, close_loops
from planner.inflight.simulation.plant import AXIS_STATES, MODE_STATES, plant_of
from planner.world.platforms import AxisDrive, TwoAxisPlatform
from planner.world.platforms.drive import CONTROL_STEP_S

_ARCSEC_RAD = math.radians(1.0 / 3600.0)


@dataclass(frozen=True, kw_only=True, eq=False)
class FlownMotion:
    """What the axes did, and what the sensors reported; columns in the order of `axis_names`.

    t_s: (k,), true seconds since the table's epoch, from its first row to its last.
    angle_rad, rate_rad_s: (k, 2), of the shafts relative to the platform's base.
    structure_rad: (k, 3), the base's small turn with the carrier's structure, platform frame:
    directions fixed to the base become d + structure_rad x d.
    measured_angle_rad: (k, 2), of the encoders, on the drive's side of the gear.
    measured_rate_rad_s: (k, 2), of rate gyros on the payload: about each axis, the structure's
    turn included, the carrier's own motion taken out.
    is_saturated: (k, 2), whether each drive is commanded all the torque it has.
    """

    t_s: Array
    angle_rad: Array
    rate_rad_s: Array
    structure_rad: Array
    measured_angle_rad: Array
    measured_rate_rad_s: Array
    is_saturated: Mask

    @property
    def saturated_s(self) -> Array:
        """How long each drive gives all it has, (2,)."""
        return np.asarray(np.diff(self.t_s) @ self.is_saturated[:-1])

    def rate_errors_rad_s(self, t_s: Array) -> None:
        """None: no gyros turn it."""

    def steadiness(self, start_s: float, stop_s: float) -> Array:
        """Nothing, (0,): no gyros turn it."""
        return np.zeros(0)

    def at(self, t_s: Array) -> tuple[Array, Array]:
        """True angles, (n, 2), and the structure's turn, (n, 3), at n instants.

        Linear between samples 0.02 s apart: a mode of 2.5 Hz is told 0.4 % too small at most.
        """
        return _between(t_s, self.t_s, self.angle_rad), _between(t_s, self.t_s, self.structure_rad)


def _between(t_s: Array, known_s: Array, angle_rad: Array) -> Array:
    return np.stack([np.interp(t_s, known_s, column) for column in angle_rad.T], axis=1)


def fly(
    table: CommandTable,
    platform: TwoAxisPlatform,
    *,
    drives: tuple[AxisDrive, AxisDrive] | None = None,
    seed: int | tuple[int, ...] = 0,
    clock_offset_s: float = 0.0,
    output_step_s: float = CONTROL_STEP_S,
) -> FlownMotion:
    """Fly from the table's first row, settled there, to its last.

    drives: the platform's unless given.  clock_offset_s: how far the drive's clock is ahead.
    output_step_s: a whole multiple of the 0.02 s in which the loops work.  Before its first row
    and after its last a table goes on at that row's rate.
    """
    every = round(output_step_s / CONTROL_STEP_S)
    if every < 1 or not math.isclose(every * CONTROL_STEP_S, output_step_s, rel_tol=1e-9):
        raise ValueError(
            f"output_step_s must be a whole multiple of {CONTROL_STEP_S:g}, not {output_step_s:g}"
        )
    drives = platform.drives if drives is None else drives
    rows = round(COMMAND_STEP_S / CONTROL_STEP_S)
    steps = rows * (len(table.position) - 1) + 1
    t_s = np.arange(steps) / round(1.0 / CONTROL_STEP_S)
    command = _command(table, drives, t_s + clock_offset_s)
    noise = np.random.default_rng(seed)
    encoder_noise_rad = _in_rad(drives, "encoder_noise_arcsec") * noise.standard_normal((steps, 2))
    plant = plant_of(platform, drives)
    loop = _drive_loop(platform, drives)
    log = close_loops(plant, loop, command, encoder_noise_rad)
    e = np.array([mode.axis_platform for mode in platform.structural_modes]).reshape(-1, 3)
    first = 2 * AXIS_STATES
    turn = log.states[:, first::MODE_STATES] @ e
    gyro_rad_s = _gyro_rates(platform, log, log.states[:, first + 1 :: MODE_STATES] @ e)
    gyro_rad_s += _in_rad(drives, "gyro_bias_arcsec_s") * noise.standard_normal(2)
    gyro_rad_s += _in_rad(drives, "gyro_noise_arcsec_s") * noise.standard_normal((steps, 2))
    count_rad_s = _in_rad(drives, "gyro_step_arcsec_s")
    counted = np.where(count_rad_s > 0.0, count_rad_s, 1.0)
    return FlownMotion(
        t_s=t_s[::every],
        angle_rad=log.angle_rad[::every],
        rate_rad_s=log.rate_rad_s[::every],
        structure_rad=turn[::every],
        measured_angle_rad=log.encoder_rad[::every],
        measured_rate_rad_s=np.where(
            count_rad_s > 0.0, np.round(gyro_rad_s / counted) * counted, gyro_rad_s
        )[::every],
        is_saturated=(np.abs(log.torque_rad_s2) >= loop.torque_max_rad_s2)[::every],
    )


def _in_rad(drives: tuple[AxisDrive, AxisDrive], name: str) -> Array:
    """Arcseconds of both drives in radians."""
    return np.array([getattr(drive, name) * _ARCSEC_RAD for drive in drives])


def _command(table: CommandTable, drives: tuple[AxisDrive, AxisDrive], clock_s: Array) -> Command:
    """clock_s: (n,), what the drive's clock says when each control step begins."""
    angle = np.empty((len(clock_s), 2))
    rate, next_rate = np.empty_like(angle), np.empty_like(angle)
    for axis, drive in enumerate(drives):
        since = clock_s - drive.command_latency_s
        angle[:, axis], rate[:, axis] = _between_rows(table, axis, since)
        next_rate[:, axis] = _between_rows(table, axis, since + CONTROL_STEP_S)[1]
    return Command(angle, rate, (next_rate - rate) / CONTROL_STEP_S)


def _between_rows(table: CommandTable, axis: int, t_s: Array) -> tuple[Array, Array]:
    """Angle and rate of the table's cubic Hermite, (n,) each.

    Not by `axes_motion_at`, whose last digits friction makes an image's 0.001 px.
    """
    angle, rate = table.position[:, axis], table.rate_rad_s[:, axis]
    last = len(angle) - 1
    rows = t_s / COMMAND_STEP_S
    row = np.clip(np.floor(rows).astype(np.intp), 0, last - 1)
    share = np.clip(rows - row, 0.0, 1.0)
    before, after = COMMAND_STEP_S * rate[row], COMMAND_STEP_S * rate[row + 1]
    change = angle[row + 1] - angle[row]
    c2, c3 = 3.0 * change - 2.0 * before - after, before + after - 2.0 * change
    found = angle[row] + share * (before + share * (c2 + share * c3))
    found_rate = (before + share * (2.0 * c2 + share * 3.0 * c3)) / COMMAND_STEP_S
    outside_s = COMMAND_STEP_S * (rows - np.clip(rows, 0.0, last))
    return found + outside_s * found_rate, found_rate


def _drive_loop(platform: TwoAxisPlatform, drives: tuple[AxisDrive, AxisDrive]) -> Loop:
    gains = np.array([drive.gains_per_s for drive in drives]).T.copy()
    reserve = np.array([drive.torque_reserve for drive in drives])
    most_rad_s2 = np.array([limits.acceleration_max_rad_s2 for limits in platform.axis_limits])
    return Loop(
        integral_per_s3=gains[0],
        proportional_per_s2=gains[1],
        derivative_per_s=gains[2],
        derivative_share=np.array([drive.derivative_share for drive in drives]),
        torque_max_rad_s2=reserve * most_rad_s2,
        lag_s=np.array([drive.lag_s for drive in drives]),
        play_rad=0.5 * _in_rad(drives, "backlash_arcsec"),
        encoder_step_rad=_in_rad(drives, "encoder_step_arcsec"),
    )


def _gyro_rates(platform: TwoAxisPlatform, log: LoopLog, swing_rad_s: Array) -> Array:
    """True rate about each axis, (n, 2), where the base swings at (n, 3) in the platform frame."""
    outer, inner = platform.axes_platform
    alpha = log.angle_rad[:, :1]
    along = np.dot(outer, inner) * outer
    turned = along + np.cos(alpha) * (inner - along) + np.sin(alpha) * np.cross(outer, inner)
    about = np.stack([swing_rad_s @ outer, np.sum(turned * swing_rad_s, axis=1)], axis=1)
    return np.asarray(log.rate_rad_s + about)
