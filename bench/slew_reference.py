"""The least squared jerk of one axis by a programme that shares nothing with the planner.

The jerk is constant on cells, limits hold at every instant, PIQP solves.
"""

import numpy as np
import piqp
from numpy.typing import NDArray

from planner.motion.slew import AxisState
from planner.world.platforms import AxisLimits

Array = NDArray[np.float64]
Integers = NDArray[np.int_]

CELLS = 400
FINEST_S = 0.02  # of the first cells, at both ends
SPREAD = 0.2  # of the cells are spread evenly, the others lie where the jerk changes
BROKEN = 1e-8  # of a limit's range
EXCHANGES = 30


class ReferenceError(RuntimeError):
    """The reference could not be solved, which says nothing of the slew."""


class Reference:
    """The least integral of squared jerk between two states with the jerk constant on cells.

    edges_s: (n + 1,), of the cells.  Limits on angle, rate and acceleration are added at the
    instants where the motion so far breaks them, until it breaks none.  The unknowns are jerk
    times root of cell width, in units of the least that meets the end.  States are counted from
    the nearer end, so that those beside an end keep their digits.
    """

    def __init__(
        self, start: AxisState, end: AxisState, limits: AxisLimits, edges_s: Array
    ) -> None:
        self.edges_s, self.h = edges_s, np.diff(edges_s)
        self.bounds = np.array(limits.bounds)
        self.at = [
            np.array([at.angle_rad, at.rate_rad_s, at.acceleration_rad_s2]) for at in (start, end)
        ]
        orders = np.arange(3)
        before = np.full(3, self._half_s)  # where the two halves meet
        after = np.nextafter(before, np.inf)
        self.ends = self._rows(before, orders) - self._rows(after, orders)
        self.wanted = self._drift(after, orders) - self._drift(before, orders)
        size = np.linalg.norm(self.ends, axis=1)
        self.ends, self.wanted = self.ends / size[:, None], self.wanted / size
        self.unit = float(np.linalg.norm(np.linalg.pinv(self.ends) @ self.wanted))
        nodes_s = np.tile(edges_s[1:-1], 3)
        orders = np.repeat(orders, len(self.h) - 1)
        self.node_rows, self.node_drift = self._rows(nodes_s, orders), self._drift(nodes_s, orders)

    @property
    def _half_s(self) -> float:
        return float(self.edges_s[-1] / 2.0)

    def jerk(self) -> Array | None:
        """The jerk (n,) of the cells, rad/s^3; None where no such motion keeps the limits.

        Raises ReferenceError.
        """
        if self.unit == 0.0:
            return np.zeros(len(self.h))
        held_s, orders = np.empty(0), np.empty(0, dtype=int)
        for _ in range(EXCHANGES):
            jerk = self._solved(held_s, orders)
            if jerk is None:
                return None
            broken_s, broken_orders = self._broken(jerk)
            if not len(broken_s):
                return jerk
            held_s = np.concatenate([held_s, broken_s])
            orders = np.concatenate([orders, broken_orders])
        raise ReferenceError(f"limits are still broken after {EXCHANGES} exchanges")

    def _rows(self, t_s: Array, orders: Integers) -> Array:
        """What the unknowns add to the derivative of an order at a time."""
        early, t = t_s[:, None] <= self._half_s, t_s[:, None]
        since = np.clip(np.where(early, t - self.edges_s[:-1], self.edges_s[1:] - t), 0.0, None)
        w = np.minimum(since, self.h)
        sign = np.where(early, 1.0, -1.0)
        angle = sign * w * (3.0 * since**2 - 3.0 * since * w + w**2) / 6.0
        rate = w * (2.0 * since - w) / 2.0
        return np.choose(orders[:, None], (angle, rate, sign * w)) / np.sqrt(self.h)

    def _drift(self, t_s: Array, orders: Integers) -> Array:
        """The same derivatives without jerk."""
        early = t_s <= self._half_s
        t = np.where(early, t_s, t_s - self.edges_s[-1])
        q, v, a = np.where(early, self.at[0][:, None], self.at[1][:, None])
        return np.choose(orders, (q + t * (v + t * a / 2.0), v + t * a, a))

    def _broken(self, jerk: Array) -> tuple[Array, Integers]:
        """Instants at which a limit is passed, at nodes or at turns between them; and which."""
        states = self.node_rows @ (jerk * np.sqrt(self.h)) + self.node_drift
        states = states.reshape(3, -1)
        q, v, a = np.column_stack([self.at[0], states])
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(a * a - 2.0 * jerk * v)
            turns = [(0, (-a + root) / jerk), (0, (-a - root) / jerk), (0, -v / a), (1, -a / jerk)]
        times_s, values = [self.edges_s[1:-1]] * 3, list(states)
        orders = [np.full(states.shape[1], order) for order in range(3)]
        for order, t in turns:
            inside = (t > 0.0) & (t < self.h)
            t, q0, v0, a0, j = (x[inside] for x in (t, q, v, a, jerk))
            angle = q0 + t * (v0 + t * (a0 / 2.0 + t * j / 6.0))
            values.append(v0 + t * (a0 + t * j / 2.0) if order else angle)
            times_s.append(self.edges_s[:-1][inside] + t)
            orders.append(np.full(len(t), order))
        low, high = self.bounds[np.concatenate(orders)].T
        value = np.concatenate(values)
        outside = np.maximum(value - high, low - value) > BROKEN * (high - low)
        return np.concatenate(times_s)[outside], np.concatenate(orders)[outside]

    def _solved(self, held_s: Array, orders: Integers) -> Array | None:
        n, jerk_max = len(self.h), self.bounds[3, 1] * np.sqrt(self.h) / self.unit
        bounds = {"x_l": -jerk_max, "x_u": jerk_max}
        if len(held_s):
            rows, drift = self._rows(held_s, orders), self._drift(held_s, orders)
            size = np.linalg.norm(rows, axis=1)
            low, high = self.bounds[orders].T
            bounds["G"] = rows / size[:, None]
            bounds["h_l"] = (low - drift) / size / self.unit
            bounds["h_u"] = (high - drift) / size / self.unit
        solver = piqp.DenseSolver()
        solver.settings.eps_abs = solver.settings.eps_rel = 1e-9
        solver.setup(np.eye(n), np.zeros(n), self.ends, self.wanted / self.unit, **bounds)
        status = solver.solve()
        if status == piqp.PIQP_PRIMAL_INFEASIBLE:
            return None
        if status != piqp.PIQP_SOLVED:
            raise ReferenceError(f"PIQP ends with {status}")
        return np.asarray(solver.result.x) * self.unit / np.sqrt(self.h)


def least_costs(
    start: AxisState, end: AxisState, limits: AxisLimits, duration_s: float, step_s: float
) -> tuple[float | None, float | None]:
    """The least integral of squared jerk, rad^2/s^5, and that of jerks that change on rows only.

    Both on at most 400 cells, which lie where the jerk of a first solution changes.  None where
    there is no such motion.  Raises ReferenceError.
    """
    rows = round(duration_s / step_s)

    def solved(edges_s: Array) -> tuple[float | None, Array | None]:
        jerk = Reference(start, end, limits, edges_s).jerk()
        return (None, None) if jerk is None else (float(np.diff(edges_s) @ jerk**2), jerk)

    edges_s = _fine_ends(duration_s)
    first, jerk = solved(edges_s)
    free, cells = first, CELLS
    if jerk is not None:
        again, _ = solved(_where_the_jerk_changes(edges_s, jerk, CELLS))
        free = first if again is None else min(first, again)
    if rows <= CELLS:
        return free, solved(np.arange(rows + 1) * step_s)[0]
    if jerk is None:
        return free, None
    on_rows = edges_s
    while True:  # so many that 400 are left on rows
        finer = np.unique(np.rint(_where_the_jerk_changes(edges_s, jerk, cells) / step_s)) * step_s
        if len(finer) > CELLS + 1 or len(finer) == len(on_rows):
            break
        on_rows, cells = finer, cells * 5 // 4
    return free, solved(on_rows)[0]


def _fine_ends(duration_s: float) -> Array:
    """Half of the cells equal, a quarter at each end growing from FINEST_S."""
    widest_s = 2.0 * duration_s / CELLS
    near = np.geomspace(min(FINEST_S, widest_s / 2.0), widest_s, CELLS // 4 + 1)[:-1]
    even = np.linspace(0.0, duration_s, CELLS // 2 + 1)
    return np.unique(np.concatenate([even, near, duration_s - near]))


def _where_the_jerk_changes(edges_s: Array, jerk: Array, count: int) -> Array:
    """Cells whose widths let each of them miss a smooth jerk by as much."""
    change = np.abs(np.diff(jerk)) / (edges_s[2:] - edges_s[:-2])
    at_edges = np.concatenate([change[:1], change, change[-1:]]) ** (2.0 / 3.0)
    density = (at_edges[1:] + at_edges[:-1]) / 2.0
    density /= density @ np.diff(edges_s)
    density += SPREAD / edges_s[-1]
    share = np.concatenate([[0.0], np.cumsum(density * np.diff(edges_s))])
    return np.interp(np.linspace(0.0, share[-1], count + 1), share, edges_s)
