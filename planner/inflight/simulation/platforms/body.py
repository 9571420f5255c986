"""The flight of a spacecraft that turns as a whole: its envelope, or its gyros' control loop."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from planner.base.arrays import Array, Mask
from planner.base.commands import ROWS_PER_S, CommandTable
from planner.base.rotation import Rotation
from planner.base.table_motion import motion_at
from planner.inflight.simulation.gyros.dispersed import (
    as_designed,
    camera_on,
    draw_dispersion,
    fly_table,
)
from planner.inflight.simulation.gyros.steadiness import errors_over_time, steadiness_figures
from planner.inflight.simulation.platforms.flyer import CLOCK, EARTH, ORBIT
from planner.planning.sessions.platforms.body_budget import CONTROL, KNOWLEDGE, VIBRATION
from planner.planning.sessions.probability import decay_rate_per_s
from planner.planning.sessions.track_branches import session_rows
from planner.world.attitude import AttitudeErrors
from planner.world.frames.iers import RAD_PER_ARCSEC
from planner.world.frames.time_scales import Instants
from planner.world.orbits import OrbitStates
from planner.world.platforms.body import BodyPlatform
from planner.world.platforms.gyro_craft import gyro_craft
from planner.world.scenario import Scenario


@dataclass(frozen=True, kw_only=True)
class BodyFlyerOptions:
    """How many tones an error is made of."""

    tones: int = 16  # each of Gauss's distribution and a rate of its own, so that few will do
    # Of vibration, in an exposure: faster than it, and no faster than its 16 instants tell.
    cycles: tuple[float, float] = (1.0, 7.0)


OPTIONS = BodyFlyerOptions()


class Tones(NamedTuple):
    """Small turns about the body axes as a sum of m tones each, (3, m)."""

    size_rad: Array
    rate_rad_s: Array
    phase_rad: Array

    def at(self, t_s: Array) -> Array:
        """At n instants, (n, 3)."""
        by_axis = [
            np.cos(np.multiply.outer(t_s, rate_rad_s) + phase_rad) @ size_rad
            for size_rad, rate_rad_s, phase_rad in zip(*self, strict=True)
        ]
        return np.stack(by_axis, axis=1)


class FlownGyros(NamedTuple):
    """A closed-loop run; columns of m instants of the table's clock.

    figures: of the steadiness between two times of it.
    """

    t_s: Array
    error_body_rad: Array
    rate_error_rad_s: Array
    figures: Callable[[float, float], Array]


class FlownBody(NamedTuple):
    """A table flown with errors; from_s: of its first row on the errors' clock."""

    table: CommandTable
    from_s: float
    errors: tuple[Tones, ...]
    gyros: FlownGyros | None = None

    @property
    def saturated_s(self) -> Array:
        """Never: the table keeps within what agility allows."""
        return np.zeros(3)

    def rate_errors_rad_s(self, t_s: Array) -> Array | None:
        """Of gyros' control at n instants, linear between 5 ms, (n, 3); None without gyros."""
        return None if self.gyros is None else _at(t_s, self.gyros.t_s, self.gyros.rate_error_rad_s)

    def steadiness(self, start_s: float, stop_s: float) -> Array:
        """While the camera images, as `worst_of` reads them; (0,) without gyros."""
        return np.zeros(0) if self.gyros is None else self.gyros.figures(start_s, stop_s)

    def at(self, t_s: Array) -> tuple[Array, Array]:
        """Attitude as commanded, (n, 4), and the turn from it in GCRF axes, (n, 3)."""
        position = motion_at(self.table, t_s).position
        turned_body_rad = sum(
            (tones.at(self.from_s + t_s) for tones in self.errors), np.zeros((len(t_s), 3))
        )
        if self.gyros is not None:
            turned_body_rad += _at(t_s, self.gyros.t_s, self.gyros.error_body_rad)
        return position, np.asarray(Rotation.from_quat(position).apply(turned_body_rad))


def _at(t_s: Array, known_s: Array, numbers: Array) -> Array:
    """Linear between known instants, (n, 3)."""
    return np.stack([np.interp(t_s, known_s, column) for column in numbers.T], axis=1)


class BodyFlyer:
    """As `Flyer` says; the base is GCRF, which is known."""

    causes: ClassVar[tuple[str, ...]] = (
        ORBIT, EARTH, CLOCK, KNOWLEDGE.cause, CONTROL.cause, VIBRATION.cause,
    )  # fmt: skip
    flown_causes: ClassVar[tuple[str, ...]] = causes[3:]

    def __init__(self, scenario: Scenario) -> None:
        platform = scenario.platform
        assert isinstance(platform, BodyPlatform)  # by the registry
        self.scenario, self.platform = scenario, platform
        self._prepared: dict[float, tuple[Mask, OrbitStates]] = {}

    @property
    def lead_s(self) -> float:
        """Of gyros, in which what a slew leaves of the structure's slowest mode fades to 2 %."""
        return 10.0 if self.platform.gyros is None else 60.0

    def q_base_from_eci(
        self, instants: Instants, states: OrbitStates, turned_body_rad: Array | None = None
    ) -> Rotation:
        return Rotation.identity(len(instants))

    def base_errors(self, instants: Instants) -> AttitudeErrors:
        none = np.zeros(3)
        return AttitudeErrors(
            sigma_body_rad=none,
            swing_rms_body_rad=none,
            basis="",
            better="",
            forgotten_body_rad=none,
        )

    def fly(
        self, table: CommandTable, from_s: float, session: int, seeds: Mapping[str, int] | None
    ) -> FlownBody:
        """A seed draws an error over the plan's whole time; as planned there is vibration alone.

        Knowledge and control wander as the budget has it (`probability_wandering`), vibration has
        tones of all frequencies from one cycle of an exposure on.  Each is a sum of tones of
        random frequency, drawn from its spectrum.
        Source: Shinozuka 1971, Simulation of multivariate and multidimensional random processes.
        Of gyros the control's error is that of their loop, a spacecraft drawn by its seed, or the
        one designed; what its sensors measure wrongly is in it, beside the knowledge's error.
        """
        errors = []
        for cause in self.flown_causes if seeds is not None else (VIBRATION.cause,):
            if cause == CONTROL.cause and self.platform.gyros is not None:
                continue
            random = np.random.default_rng(session if seeds is None else seeds[cause])
            errors.append(self._draw(cause, random))
        flown = None
        if self.platform.gyros is not None:
            flown = self._fly_gyros(table, from_s, session, seeds)
        return FlownBody(table, from_s, tuple(errors), flown)

    def _fly_gyros(
        self, table: CommandTable, from_s: float, session: int, seeds: Mapping[str, int] | None
    ) -> FlownGyros:
        craft = gyro_craft(self.platform)
        if seeds is None:
            drawn = as_designed(craft, session)
        else:
            drawn = draw_dispersion(craft, seeds[CONTROL.cause])
        if from_s not in self._prepared:
            sessions = [session_rows(one, table.epoch_utc) for one in self.scenario.sessions]
            spans = [(rows.start, rows.stop) for rows in sessions]
            imaging = camera_on(spans, len(table.position))
            self._prepared[from_s] = imaging, self._states(table)
        log = fly_table(craft, table, *self._prepared[from_s], drawn)

        def figures(start_s: float, stop_s: float) -> Array:
            first_row, last_row = round(start_s * ROWS_PER_S), round(stop_s * ROWS_PER_S)
            return steadiness_figures(log, craft.array, table.rate_rad_s, first_row, last_row)

        return FlownGyros(*errors_over_time(log), figures)

    def _states(self, table: CommandTable) -> OrbitStates:
        instants = Instants(table.epoch_utc, table.t_s)
        ephemeris = self.scenario.orbit.ephemeris(instants.utc(0), instants.utc(-1))
        return ephemeris.states(instants)

    def _draw(self, cause: str, random: np.random.Generator) -> Tones:
        knowledge, shape = self.platform.knowledge, (3, OPTIONS.tones)
        sigma_arcsec = {
            KNOWLEDGE.cause: knowledge.sigma_arcsec,
            CONTROL.cause: knowledge.control_sigma_arcsec,
            VIBRATION.cause: knowledge.jitter_arcsec,
        }[cause]
        if cause == VIBRATION.cause:
            per_s = 2.0 * math.pi / self.platform.camera.exposure_s
            rate_rad_s = per_s * random.uniform(*OPTIONS.cycles, shape)
        else:
            # The spectrum 1 / (decay^2 + rate^2)^2 is Student's distribution of 3 degrees.
            decay_per_s = decay_rate_per_s(knowledge.correlation_s)
            rate_rad_s = decay_per_s / math.sqrt(3.0) * random.standard_t(3, shape)
        sigma_rad = sigma_arcsec * RAD_PER_ARCSEC / math.sqrt(OPTIONS.tones)
        return Tones(
            size_rad=sigma_rad * random.rayleigh(size=shape),
            rate_rad_s=rate_rad_s,
            phase_rad=random.uniform(0.0, 2.0 * math.pi, shape),
        )
