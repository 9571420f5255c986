"""Search for the smoothest detour near given guesses, each checked as rows carry it.

First the regions are kept out of at few instants, which far guesses suit; from there at many, which
leaves no gaps between them for a dozen optima that differ only in how they straddle instants.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from planner.base.arrays import Array
from planner.base.solvers import SolverRun
from planner.motion.detour.caps import cap_count, cone_caps, look_tau, mask_caps, mask_parts
from planner.motion.detour.ocp import Caps, DetourOcp, Start, detour_ocp
from planner.motion.detour.spline_ocp import SplineOcp
from planner.motion.pointing.keep_out import DeepestEntry, KeepOutView, deepest_entry
from planner.motion.slew.solution import AxisProfile, SlewSolution, obeys, reproduces, rows_in
from planner.world.platforms import AxisLimits

Profiles = tuple[AxisProfile, AxisProfile]


@dataclass(frozen=True, kw_only=True)
class DetourSearchOptions:
    """Margins by which a path keeps out, and which paths are worth refining."""

    touch_rad: float = 1e-6  # the flown Hermite may leave the plan by half of it
    # between few instants a path may sink so far into a cone
    rough_margin_rad: float = math.radians(0.1)
    # the first one between many instants
    margins_rad: tuple[float, float] = (math.radians(0.02), math.radians(0.1))
    margin_rise: float = 0.05  # share of the slew over which the margin grows from its ends
    samples_between: int = 8  # samples between two instants of few
    # deeper than a path can enter between two of few instants
    violation_max_rad: float = math.radians(4.0)
    # times the cost of a path: where that path was good, a dearer one isn't refined
    worth_share: float = 1.01
    worth_gaps: float = 4.0  # nor one dearer by so many times its sampling gap
    alike: float = 1e-3  # in cost: the same optimum again
    refined_max: int = 4  # of the guesses tried at once
    # may need a wider margin only near an end, where it is cut
    shallow_rad: float = math.radians(0.02)
    # half of it is deeper than a path can enter between many instants
    violation_between_samples_rad: float = math.radians(1.0)
    # share of a depth that a margin wider by it leaves only to a path through the cone
    unreduced_share: float = 0.5


OPTIONS = DetourSearchOptions()

MARGIN_GROWTHS_RAD = np.radians([0.002, 0.01, 0.05, 0.1])  # in a gap 0.02 at once costs 5 %
# How often a mask's caps are taken, at most: with 4 far ones 15 slews cost the same and took 1.4
# times as long, with 2 near ones they cost up to 4 % more.
EXCHANGES = {"far": 2, "wide": 2, "near": 3}
EXCHANGED = {"far": 0.05, "wide": 0.05, "near": 2e-3}  # share of the cost by which one must help


class Detour(NamedTuple):
    """cost: infinite where the result is not good.  off_rows: good but for flying it from rows.

    sampling_gap_share: share by which many instants cost more or less than few; where it is large,
    so was the room between these, and other optima may be near.  violation_between_samples_rad:
    how much deeper than the margin a path goes between few instants.  run: how the motion was
    solved; iterations: of all that was tried.  search_truncated: whether the bound of work ended
    the search.
    """

    profiles: Profiles
    cost: float
    off_rows: bool
    run: SolverRun
    iterations: int
    sampling_gap_share: float = 0.0
    violation_between_samples_rad: float = 0.0
    search_truncated: bool = False


class DetourSearch:
    """Detours of one slew on one basis of splines.

    share: of the acceleration limit they may use.
    """

    def __init__(
        self, straight: SlewSolution, view: KeepOutView, spline: SplineOcp, share: float = 1.0
    ) -> None:
        self._straight, self._view, self.spline = straight, view, spline
        problem = straight.problem
        T = straight.duration_s
        moves = [abs(axis.end.angle_rad - axis.start.angle_rad) for axis in problem.axes]
        sizes = [cone.half_angle_rad for cone in view.cones]
        sizes += [mask.polygon.reach_rad + mask.margin_rad for mask in view.masks]
        scale_rad = max(*moves, *sizes, 0.1)
        self._parts = mask_parts(view)
        outer, inner = (
            spline.pose_programme(
                replace(axis, duration_s=T, limits=_limits_with_share(axis.limits, share)),
                scale_rad=scale_rad,
            )
            for axis in problem.axes
        )
        self._axes = (outer, inner)
        angle = np.array(
            [[axis.angle_rad for axis in side] for side in (problem.start, problem.end)]
        )
        self._gap_rad = -view.depths_rad(np.array([0.0, T]), angle) / 2.0

    def solve_near(self, asides_rad: tuple[Array, ...], *, start: Start = "far") -> list[Detour]:
        """The best of those that guesses lead to, and what else was tried, not in order.

        asides_rad: (2, k) each, how far a guess lies off the straight slew at the
        `greville_tau` instants.
        """
        rough = sorted(
            (self._solve_roughly(aside, start) for aside in asides_rad), key=lambda one: one.cost
        )
        costs: list[float] = []
        found: list[Detour] = []
        dearest = math.inf
        for one in rough:
            again = any(abs(one.cost / cost - 1.0) < OPTIONS.alike for cost in costs)
            good = sum(math.isfinite(detour.cost) for detour in found)
            enough = good == OPTIONS.refined_max or one.cost > dearest
            if not math.isfinite(one.cost) or enough or again:
                found.append(one._replace(cost=math.inf))
                continue
            costs.append(one.cost)
            found.append(self._refine_detour(one))
            if math.isfinite(found[-1].cost):
                dearest = min(
                    dearest,
                    one.cost
                    * (OPTIONS.worth_share + OPTIONS.worth_gaps * found[-1].sampling_gap_share),
                )
        return found

    def _solve_roughly(self, aside_rad: Array, start: Start) -> Detour:
        ocp = self._ocp_with_caps(start)
        guess = self._guess_y(self._straight.profiles, aside_rad)
        profiles, run = self._solve_with_caps(ocp, guess, OPTIONS.rough_margin_rad)
        t_s = np.linspace(
            0.0, self._straight.duration_s, OPTIONS.samples_between * (len(ocp.tau) + 1) + 1
        )
        angle = np.stack([profile.evaluate(t_s)[0] for profile in profiles], axis=1)
        depth_rad = float(self._view.depths_rad(t_s, angle).max())
        return Detour(
            profiles=profiles,
            cost=math.inf if depth_rad > OPTIONS.violation_max_rad else _jerk_cost(profiles),
            off_rows=False,
            run=run,
            iterations=run.iterations,
            violation_between_samples_rad=depth_rad + OPTIONS.rough_margin_rad,
        )

    def _refine_detour(self, rough: Detour) -> Detour:
        ocp = self._ocp_with_caps("near")
        profiles, run, iterations = rough.profiles, rough.run, rough.iterations
        # Between instants so much nearer a path that curves alike enters less deep by the square.
        nearer = (len(self._ocp_with_caps("far").tau) + 1) / (len(ocp.tau) + 1)
        margin_rad = float(
            np.clip(nearer**2 * rough.violation_between_samples_rad, *OPTIONS.margins_rad)
        )
        depth_rad = OPTIONS.violation_between_samples_rad
        for growth_rad in MARGIN_GROWTHS_RAD:
            guess = self._guess_y(profiles, np.zeros((2, self.spline.free_count)))
            profiles, run = self._solve_with_caps(ocp, guess, margin_rad)
            iterations += run.iterations
            before_rad, depth_rad = depth_rad, slew_entry(profiles, self._view).depth_rad
            if depth_rad <= -OPTIONS.touch_rad or depth_rad > max(
                OPTIONS.unreduced_share * before_rad, OPTIONS.shallow_rad
            ):
                break
            margin_rad += max(depth_rad, 0.0) + growth_rad
        axes = list(zip(profiles, self._straight.problem.axes, strict=True))
        keeps = depth_rad <= -OPTIONS.touch_rad and all(
            obeys(profile, axis.start, axis.end, axis.limits) for profile, axis in axes
        )
        rows = rows_in(self._straight.duration_s)
        fits = keeps and all(reproduces(profile, rows, axis.limits) for profile, axis in axes)
        return Detour(
            profiles=profiles,
            cost=_jerk_cost(profiles) if fits else math.inf,
            off_rows=keeps and not fits,
            run=run,
            iterations=iterations,
            sampling_gap_share=abs(_jerk_cost(profiles) / rough.cost - 1.0),
        )

    def _ocp_with_caps(self, start: Start) -> DetourOcp:
        with_modes = bool(self._straight.problem.avoid_modes)
        caps = cap_count(self._view, self._parts)
        return detour_ocp(self.spline, caps, with_modes=with_modes, start=start)

    def _solve_with_caps(
        self, ocp: DetourOcp, guess_coefficients: Array, margin_rad: float
    ) -> tuple[Profiles, SolverRun]:
        """Solve again with the masks' caps where the last solution passed, while that helps."""
        outer, inner = map(self.spline.profile, self._axes, guess_coefficients)
        profiles, cost = (outer, inner), math.inf
        runs: list[SolverRun] = []
        for _ in range(EXCHANGES[ocp.start] if self._parts else 1):
            caps = self._caps_beside(ocp, margin_rad, profiles)
            profiles, last = ocp.solve(self._view.platform, self._axes, caps, guess_coefficients)
            runs.append(last.after(runs[-1]) if runs else last)
            guess_coefficients = self._guess_y(profiles, np.zeros((2, self.spline.free_count)))
            before, cost = cost, _jerk_cost(profiles)
            if abs(before - cost) < EXCHANGED[ocp.start] * cost:
                break
        return profiles, runs[-1]

    def _caps_beside(self, ocp: DetourOcp, margin_rad: float, path: Profiles) -> Caps:
        """path: beside which a mask's caps stand."""
        duration_s = self._straight.duration_s
        margins_rad = self._margins_rad(ocp.tau, margin_rad)
        caps = []
        if self._view.cones:
            of_cones = margins_rad[: len(self._view.cones)]
            caps.append(cone_caps(self._view, ocp.tau * duration_s, of_cones))
        if self._parts:
            t_s = look_tau(ocp.tau) * duration_s
            angle = np.stack([profile.evaluate(t_s.ravel())[0] for profile in path], axis=1)
            boresight = self._view.boresight(angle).reshape(*t_s.shape, 3)
            caps.append(mask_caps(self._parts, boresight, margins_rad))
        return Caps(*map(np.concatenate, zip(*caps, strict=True)))

    def _guess_y(self, profiles: tuple[AxisProfile, ...], aside_rad: Array) -> Array:
        return np.stack(
            [
                self.spline.guess_y(axis, profile, off)
                for axis, profile, off in zip(self._axes, profiles, aside_rad, strict=True)
            ]
        )

    def _margins_rad(self, tau: Array, margin_rad: float) -> Array:
        """Beside each region at each instant, less near an end that is nearer to it itself."""
        rising = self._gap_rad[:, :1] + margin_rad / OPTIONS.margin_rise * tau
        falling = self._gap_rad[:, 1:] + margin_rad / OPTIONS.margin_rise * (1.0 - tau)
        return np.minimum(margin_rad, np.minimum(rising, falling))


def slew_entry(profiles: tuple[AxisProfile, ...], view: KeepOutView) -> DeepestEntry:
    """How deep a slew goes into what it must keep out of."""

    def motion_at(t_s: Array) -> tuple[Array, Array]:
        values = [profile.lowest(t_s, 2) for profile in profiles]
        angle, rate = (np.stack(of_axes, axis=1) for of_axes in zip(*values, strict=True))
        return angle, rate

    return deepest_entry(view, motion_at, 0.0, profiles[0].duration_s)


def _limits_with_share(limits: AxisLimits, share: float) -> AxisLimits:
    acceleration_max_rad_s2 = share * limits.acceleration_max_rad_s2
    return replace(limits, acceleration_max_rad_s2=acceleration_max_rad_s2)


def _jerk_cost(profiles: Profiles) -> float:
    return sum(profile.jerk_squared_integral for profile in profiles)
