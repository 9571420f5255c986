"""What is the smoothest detour near a given guess, flown from rows and checked?

First the cones are kept at few instants, which far guesses suit; from there at many, which
leaves no play between them for a dozen optima that differ only in how they straddle instants.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from planner.arrays import Array
from planner.detour.ocp import DetourOcp, Start, detour_ocp
from planner.pointing.keep_out import ConeEntry, KeepOutView, deepest_entry
from planner.slew.backends.spline_ocp import SplineOcp
from planner.slew.grid import reproduces, rows_in
from planner.slew.solution import AxisProfile, SlewSolution, obeys

Profiles = tuple[AxisProfile, AxisProfile]
TOUCH_RAD = 1e-6  # the flown Hermite may leave the plan by half of it
ROUGH_MARGIN_RAD = math.radians(0.1)
MARGINS_RAD = (math.radians(0.02), math.radians(0.1))  # the first one between many instants
MARGIN_GROWTHS_RAD = np.radians([0.002, 0.01, 0.05, 0.1])  # in a gap 0.02 at once costs 5 %
MARGIN_RISE = 0.05  # share of the slew over which the margin grows from its ends
SINKING = 8  # looks between two instants of few
HOPELESS_RAD = math.radians(4.0)  # deeper than a path can sink between two of few instants
DEARER, PLAYS = 1.01, 4.0  # than the best one found, and its plays: not worth a second look
ALIKE = 1e-3  # in cost: the same optimum again
REFINED_MAX = 4  # of the guesses tried at once
SHALLOW_RAD = math.radians(0.02)  # may need a wider margin only near an end, where it is cut
SUNK_RAD = math.radians(1.0)  # half of it is deeper than a path can sink between many instants
STUCK = 0.5  # share of a depth that a margin wider by it leaves only to a path through the cone


class Detour(NamedTuple):
    """cost: infinite where the result is not good.  off_rows: good but for flying it from rows.

    play_share: share by which many instants cost more or less than few; where it is large, so was
    the play between these, and other optima may be near.  sunk_rad: how much deeper than the
    margin a path goes between few instants.  cut_short: whether the search for a better one was.
    """

    profiles: Profiles
    cost: float
    off_rows: bool
    iterations: int
    play_share: float = 0.0
    sunk_rad: float = 0.0
    cut_short: bool = False


class DetourSearch:
    """Detours of one slew on one basis of splines.

    share: of the acceleration limit they may use.
    """

    def __init__(
        self, straight: SlewSolution, view: KeepOutView, spline: SplineOcp, share: float = 1.0
    ) -> None:
        self._straight, self._view, self.spline = straight, view, spline
        self._problem = problem = straight.problem
        T = straight.duration_s
        self._states = list(zip(problem.start, problem.end, strict=True))
        moves = [abs(end.angle_rad - start.angle_rad) for start, end in self._states]
        scale_rad = max(*moves, *(cone.half_angle_rad for cone in view.cones), 0.1)
        limits = [
            replace(axis, acceleration_max_rad_s2=share * axis.acceleration_max_rad_s2)
            for axis in problem.limits
        ]
        posed = [
            spline.pose(*ends, limit, T, scale_rad=scale_rad, avoid_modes=problem.avoid_modes)
            for ends, limit in zip(self._states, limits, strict=True)
        ]
        self._axes = (posed[0], posed[1])
        angle = np.array(
            [[axis.angle_rad for axis in side] for side in (problem.start, problem.end)]
        )
        self._gap_rad = -view.depths_rad(np.array([0.0, T]), angle) / 2.0

    def near(self, asides: tuple[Array, ...], *, start: Start = "far") -> list[Detour]:
        """The best of those that guesses lead to, and what else was refined, not in order.

        asides: (2, k) each, how far a guess lies off the straight slew at the `greville`
        instants.
        """
        rough = sorted((self._rough(aside, start) for aside in asides), key=lambda one: one.cost)
        refined: list[float] = []
        found: list[Detour] = []
        dearest = math.inf
        for one in rough:
            again = any(abs(one.cost / cost - 1.0) < ALIKE for cost in refined)
            good = sum(math.isfinite(detour.cost) for detour in found)
            enough = good == REFINED_MAX or one.cost > dearest
            if not math.isfinite(one.cost) or enough or again:
                found.append(one._replace(cost=math.inf))
                continue
            refined.append(one.cost)
            found.append(self._refined(one))
            if math.isfinite(found[-1].cost):
                dearest = min(dearest, one.cost * (DEARER + PLAYS * found[-1].play_share))
        return found

    def _rough(self, aside: Array, start: Start) -> Detour:
        ocp = self._ocp(start)
        guess = self._guess(self._straight.profiles, aside)
        profiles, iterations = self._solve(ocp, guess, ROUGH_MARGIN_RAD)
        t_s = np.linspace(0.0, self._straight.duration_s, SINKING * (len(ocp.tau) + 1) + 1)
        angle = np.stack([profile.evaluate(t_s)[0] for profile in profiles], axis=1)
        depth_rad = float(self._view.depths_rad(t_s, angle).max())
        return Detour(
            profiles=profiles,
            cost=math.inf if depth_rad > HOPELESS_RAD else _cost(profiles),
            off_rows=False,
            iterations=iterations,
            sunk_rad=depth_rad + ROUGH_MARGIN_RAD,
        )

    def _refined(self, rough: Detour) -> Detour:
        ocp = self._ocp("near")
        profiles, iterations = rough.profiles, rough.iterations
        # Between instants so much nearer a path that curves alike sinks less by the square.
        nearer = (len(self._ocp("far").tau) + 1) / (len(ocp.tau) + 1)
        margin_rad = float(np.clip(nearer**2 * rough.sunk_rad, *MARGINS_RAD))
        depth_rad = SUNK_RAD
        for growth_rad in MARGIN_GROWTHS_RAD:
            guess = self._guess(profiles, np.zeros((2, self.spline.free_count)))
            profiles, used = self._solve(ocp, guess, margin_rad)
            iterations += used
            before_rad, depth_rad = depth_rad, entered(profiles, self._view).depth_rad
            if depth_rad <= -TOUCH_RAD or depth_rad > max(STUCK * before_rad, SHALLOW_RAD):
                break
            margin_rad += max(depth_rad, 0.0) + growth_rad
        limits, rows = self._problem.limits, rows_in(self._straight.duration_s)
        keeps = depth_rad <= -TOUCH_RAD and all(
            obeys(profile, *ends, limit)
            for profile, ends, limit in zip(profiles, self._states, limits, strict=True)
        )
        fits = keeps and all(
            reproduces(profile, rows, limit)
            for profile, limit in zip(profiles, limits, strict=True)
        )
        return Detour(
            profiles=profiles,
            cost=_cost(profiles) if fits else math.inf,
            off_rows=keeps and not fits,
            iterations=iterations,
            play_share=abs(_cost(profiles) / rough.cost - 1.0),
        )

    def _ocp(self, start: Start) -> DetourOcp:
        calm = bool(self._problem.avoid_modes)
        return detour_ocp(self.spline, len(self._view.cones), calm=calm, start=start)

    def _solve(self, ocp: DetourOcp, guess: Array, margin_rad: float) -> tuple[Profiles, int]:
        margins = self._margins(ocp.tau, margin_rad)
        return ocp.solve(self._view.platform, self._axes, self._view.cones, margins, guess)

    def _guess(self, profiles: tuple[AxisProfile, ...], aside: Array) -> Array:
        return np.stack(
            [
                self.spline.guess(axis, profile, off)
                for axis, profile, off in zip(self._axes, profiles, aside, strict=True)
            ]
        )

    def _margins(self, tau: Array, margin_rad: float) -> Array:
        """Beside each cone at each instant, less near an end that is nearer to the cone itself."""
        rising = self._gap_rad[:, :1] + margin_rad / MARGIN_RISE * tau
        falling = self._gap_rad[:, 1:] + margin_rad / MARGIN_RISE * (1.0 - tau)
        return np.minimum(margin_rad, np.minimum(rising, falling))


def entered(profiles: tuple[AxisProfile, ...], view: KeepOutView) -> ConeEntry:
    """How deep a slew goes into the cones."""

    def motion(t_s: Array) -> tuple[Array, Array]:
        values = [profile.evaluate(t_s) for profile in profiles]
        return (
            np.stack([value[0] for value in values], axis=1),
            np.stack([value[1] for value in values], axis=1),
        )

    return deepest_entry(view, motion, 0.0, profiles[0].duration_s)


def _cost(profiles: Profiles) -> float:
    return sum(profile.jerk_squared_integral for profile in profiles)
