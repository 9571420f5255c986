"""CasADi's solvers: the one place where they are made, asked and heard.

A programme is stated in CasADi's symbols and solved by Ipopt; where many like it are solved only
to learn where to look next, by PIQP.  What a solver says of itself is told, and decides no more
than whether its answer is looked at: who asks judges the answer by what it is.
"""

import ctypes
from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from planner.base import effort
from planner.base.answer_members import Count, answer
from planner.base.arrays import Array

if TYPE_CHECKING:
    import casadi

Plugin = Literal["ipopt", "piqp"]
Options = Mapping[str, str | float | int]
IPOPT: Options = {
    "print_level": 0,
    "sb": "yes",
    "linear_solver": "mumps",  # others crash or are not packaged everywhere
    "bound_relax_factor": 0.0,  # else limits are passed by a little
    "acceptable_iter": 0,
}
# Ends after which an answer may be right.  Of PIQP "solved", of Ipopt the others: rounding kept the
# last two from what was asked.
PROMISING = (
    "Solve_Succeeded",
    "solved",
    "Solved_To_Acceptable_Level",
    "Search_Direction_Becomes_Too_Small",
)
OVERDETERMINED = "Not_Enough_Degrees_Of_Freedom"  # Ipopt's own word
STRAINED = 1e8  # a dual infeasibility, beside a cost of about 1


@answer
class SolverRun:
    """The solver whose motion is flown.

    name: of the solver.
    version: of the solver.
    status: in its own words how it ended, each once where there were several motions.
    iterations: that led to these motions, all together.
    """

    name: str
    version: str
    status: str
    iterations: Count = 0

    @property
    def is_promising(self) -> bool:
        """Whether the answer is worth a look."""
        return self.status in PROMISING

    def after(self, before: "SolverRun") -> "SolverRun":
        """This run, with the iterations of what it began at."""
        return replace(self, iterations=self.iterations + before.iterations)


def merged(runs: Iterable[SolverRun | None]) -> SolverRun | None:
    """Several runs of one solver as one: each status once, the iterations of all; None: of none."""
    made = [run for run in runs if run is not None]
    if not made:
        return None
    statuses = "; ".join(dict.fromkeys(run.status for run in made))
    return replace(made[0], status=statuses, iterations=sum(run.iterations for run in made))


class Answer(NamedTuple):
    """x, and the multipliers of its bounds and of the constraints' in CasADi's sign: positive
    at an upper bound."""

    x_numbers: Array
    lam_x_numbers: Array
    lam_g_numbers: Array
    run: SolverRun


class Work(NamedTuple):
    """What a solver costs, of `effort`: each time it is asked, and each iteration.

    What more: strained_cost each iteration once the dual infeasibility was large, where factors
    fill; failed_cost a run that fails.
    """

    solve_cost: float
    iteration_cost: float
    strained_cost: float = 0.0
    failed_cost: float = 0.0


class Solver:
    """A programme's solver, to be made once and kept.

    programme: symbols x and p, cost f and constraints g.  options: of the plugin; Ipopt's add to
    and take precedence over IPOPT.  hessian: of the Lagrangian, jacobian: the constraints and
    theirs, where CasADi would take long to find them.  PIQP needs both, of a programme whose cost
    and constraints are nothing where x is.  multiplier_bound: of a bound of x, beyond which Ipopt
    gives up; without end they grow where nothing keeps the constraints.
    """

    def __init__(
        self,
        programme: "dict[str, casadi.SX] | dict[str, casadi.MX]",
        options: Options,
        work: Work,
        *,
        plugin: Plugin = "ipopt",
        hessian: "casadi.Function | None" = None,
        jacobian: "casadi.Function | None" = None,
        multiplier_bound: float | None = None,
    ) -> None:
        # CasADi takes 0.1 s to import, which only a process that solves should pay.
        import casadi

        self._plugin, self._work, self._lock = plugin, work, Lock()
        settings: dict[str, Any] = {"print_time": False, "record_time": False}
        if plugin == "ipopt":
            # The sensitivity to parameters, which nobody asks for, takes longest to prepare.
            settings |= {"no_nlp_grad": True} | dict.fromkeys(
                ("calc_lam_p", "calc_f", "calc_g"), False
            )
            settings |= {"ipopt": {**IPOPT, **options}}
            given = {"hess_lag": hessian, "jac_g": jacobian}
            if multiplier_bound is not None:
                given["iteration_callback"] = _diverged(programme, multiplier_bound)
            settings |= {name: of for name, of in given.items() if of is not None}
            function = casadi.nlpsol("programme", plugin, programme, settings)
            self._programme, self._matrices = _Buffered(function, ("x", "lam_x", "lam_g")), None
            return
        if hessian is None or jacobian is None:
            raise ValueError(f"{plugin} needs the programme's derivatives")
        settings |= {"error_on_fail": False, plugin: dict(options)}
        p: Any = programme["p"]
        upper, rows = hessian(0, p, 1, 0), jacobian(0, p)[1]
        matrices = {"h": casadi.triu2symm(upper), "a": rows}
        structure = {name: matrix.sparsity() for name, matrix in matrices.items()}
        function = casadi.conic("programme", plugin, structure, settings)
        self._programme = _Buffered(function, ("x", "lam_x", "lam_a"))
        of_p = casadi.Function("matrices", [p], list(matrices.values()), ["p"], list(matrices))
        self._matrices = _Buffered(of_p, matrices, self._programme.given)

    def solve(
        self,
        *,
        x0: Array,
        p: Array | float = 0.0,
        lbx: Array | float = -np.inf,
        ubx: Array | float = np.inf,
        lbg: Array | float = -np.inf,
        ubg: Array | float = np.inf,
        lam_x0: Array | float = 0.0,
        lam_g0: Array | float = 0.0,
    ) -> Answer:
        """The answer, begun at x0; warm, where multipliers are given too.

        Ipopt isn't asked where there are more equations than unknowns: it would relax the bounds
        that fix the others, and crash in the callback that watches its multipliers.
        """
        effort.charge(self._work.solve_cost)
        if np.sum(np.equal(lbg, ubg)) > np.sum(np.broadcast_to(np.less(lbx, ubx), np.shape(x0))):
            run = self._run(OVERDETERMINED, 0)
            return Answer(np.array(x0), np.zeros(np.size(x0)), np.zeros(np.size(lbg)), run)
        given: dict[str, Array | float] = {"x0": x0, "lbx": lbx, "ubx": ubx}
        with self._lock:
            if self._matrices is not None:
                self._matrices.evaluate(p=p)
                found = self._programme.evaluate(**given, lba=lbg, uba=ubg)
            else:
                given |= {"lbg": lbg, "ubg": ubg}
                found = self._programme.evaluate(**given, p=p, lam_x0=lam_x0, lam_g0=lam_g0)
            stats = self._programme.stats()
        x, lam_x, lam_g = found
        iterations = int(stats["iter_count"])
        effort.count(self._work.iteration_cost * max(iterations, 0))
        effort.count(self._work.strained_cost * _strained_iterations(stats))
        status = str(stats["return_status"]) if np.all(np.isfinite(x)) else "not finite"
        run = self._run(status, max(iterations, 0))
        if not run.is_promising:
            effort.count(self._work.failed_cost)
        return Answer(x, lam_x, lam_g, run)

    def _run(self, status: str, iterations: int) -> SolverRun:
        version = _version(self._plugin)
        return SolverRun(name=self._plugin, version=version, status=status, iterations=iterations)


class _Buffered:
    """A function of CasADi in memory of its own: a short solve takes a fifth less than by a call.

    given: by name what it reads, nonzeros in CasADi's order; what isn't said anew stays.
    wanted: what it writes, by name; in memory of others where they have it.
    """

    def __init__(
        self,
        function: "casadi.Function",
        wanted: Iterable[str],
        others: "Mapping[str, Array] | None" = None,
    ) -> None:
        self._buffer: Any
        self._buffer, self._evaluate = function.buffer()
        self.given = {name: np.zeros(function.nnz_in(name)) for name in function.name_in()}
        written = {name: np.zeros(function.nnz_out(name)) for name in wanted} | dict(others or {})
        self._found = [written[name] for name in wanted]
        for name, numbers in self.given.items():
            self._buffer.set_arg(function.index_in(name), numbers.data)
        for name, numbers in zip(wanted, self._found, strict=True):
            self._buffer.set_res(function.index_out(name), numbers.data)

    def evaluate(self, **numbers: Array | float) -> list[Array]:
        """What is wanted, in this order."""
        for name, values in numbers.items():
            self.given[name][:] = values
        self._evaluate()
        return [found.copy() for found in self._found]

    def stats(self) -> dict[str, Any]:
        """Of the last evaluation."""
        return dict(self._buffer.stats())


def _strained_iterations(stats: "Mapping[str, Any]") -> int:
    """How many followed one of large dual infeasibility, of those that Ipopt counts."""
    is_large = np.array(stats.get("iterations", {}).get("inf_du", ())) > STRAINED
    return int(np.count_nonzero(np.maximum.accumulate(is_large)))


def _diverged(
    programme: "dict[str, casadi.SX] | dict[str, casadi.MX]", multiplier_bound: float
) -> "casadi.Function":
    """Asked after each iteration: other than 0 where it is to be the last."""
    import casadi

    sizes = [programme[name].numel() for name in "xfg"]
    sizes += [programme[name].numel() for name in "xgp"]
    answer = [casadi.MX.sym(casadi.nlpsol_out(i), size) for i, size in enumerate(sizes)]
    return casadi.Function("diverged", answer, [casadi.norm_inf(answer[3]) > multiplier_bound])


@cache
def has_piqp() -> bool:
    """Whether this build of CasADi brings PIQP."""
    import casadi

    return bool(casadi.has_conic("piqp"))


@cache
def _version(plugin: Plugin) -> str:
    """Ipopt's own; PIQP tells none, so CasADi's, which brings it."""
    import casadi

    if plugin != "ipopt":
        return f"CasADi {casadi.CasadiMeta.version()}"
    library = min(Path(casadi.__file__).parent.glob("libipopt.so*"))
    numbers = [ctypes.c_int() for _ in range(3)]
    ctypes.CDLL(str(library)).GetIpoptVersion(*map(ctypes.byref, numbers))
    return ".".join(str(number.value) for number in numbers)
