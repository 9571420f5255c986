"""CasADi's solvers: the one place where they are made, asked and heard.

A programme is stated in CasADi's symbols and solved by Ipopt; where many like it are solved only
to learn where to look next, by PIQP.  What a solver says of itself is told, and decides no more
than whether its answer is looked at: who asks judges the answer by what it is.
"""

import ctypes
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from planner.base import effort
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
STRAINED = 1e8  # a dual infeasibility, beside a cost of about 1


class SolverRun(NamedTuple):
    """One answer of a solver: status is its own word for how it ended.

    iterations: None where it doesn't count them.
    """

    name: str
    version: str
    status: str
    iterations: int | None

    @property
    def is_promising(self) -> bool:
        """Whether the answer is worth a look."""
        return self.status in PROMISING

    def after(self, before: "SolverRun") -> "SolverRun":
        """This run, with the iterations of what it began at."""
        iterations = (self.iterations or 0) + (before.iterations or 0)
        return self._replace(iterations=iterations)


def merged(runs: Iterable[SolverRun | None]) -> SolverRun | None:
    """Several runs of one solver as one: each status once, the iterations of all; None: of none."""
    made = [run for run in runs if run is not None]
    if not made:
        return None
    statuses = "; ".join(dict.fromkeys(run.status for run in made))
    return made[0]._replace(status=statuses, iterations=sum(run.iterations or 0 for run in made))


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
    and constraints are nothing where x is.  multiplier_most: of a bound of x, beyond which Ipopt
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
        multiplier_most: float | None = None,
    ) -> None:
        # CasADi takes 0.1 s to import, which only a process that solves should pay.
        import casadi

        self._plugin, self._work = plugin, work
        settings: dict[str, Any] = {"print_time": False}
        self._matrices: casadi.Function | None = None
        if plugin == "ipopt":
            # The sensitivity to parameters, which nobody asks for, takes longest to prepare.
            settings |= {"no_nlp_grad": True} | dict.fromkeys(
                ("calc_lam_p", "calc_f", "calc_g"), False
            )
            settings |= {"ipopt": {**IPOPT, **options}}
            given = {"hess_lag": hessian, "jac_g": jacobian}
            if multiplier_most is not None:
                given["iteration_callback"] = _diverged(programme, multiplier_most)
            settings |= {name: of for name, of in given.items() if of is not None}
            self._function = casadi.nlpsol("programme", plugin, programme, settings)
            return
        if hessian is None or jacobian is None:
            raise ValueError(f"{plugin} needs the programme's derivatives")
        settings |= {"error_on_fail": False, plugin: dict(options)}
        p: Any = programme["p"]
        upper, rows = hessian(0, p, 1, 0), jacobian(0, p)[1]
        matrices = {"h": casadi.triu2symm(upper), "a": rows}
        self._matrices = casadi.Function("matrices", [p], list(matrices.values()))
        structure = {name: matrix.sparsity() for name, matrix in matrices.items()}
        self._function = casadi.conic("programme", plugin, structure, settings)

    def solve(self, **numbers: Array) -> Answer:
        """The answer for x0, p, lbx, ubx, lbg, ubg and, to begin warm, lam_x0 and lam_g0."""
        effort.charge(self._work.solve_cost)
        found = self._found(numbers)
        stats = self._function.stats()
        iterations = int(stats["iter_count"])
        effort.count(self._work.iteration_cost * max(iterations, 0))
        effort.count(self._work.strained_cost * _strained_iterations(stats))
        x, lam_x, lam_g = (np.asarray(found[name]).ravel() for name in ("x", "lam_x", "lam_g"))
        status = str(stats["return_status"]) if np.all(np.isfinite(x)) else "not finite"
        counted = iterations if iterations >= 0 else None
        run = SolverRun(self._plugin, _version(self._plugin), status, counted)
        if not run.is_promising:
            effort.count(self._work.failed_cost)
        return Answer(x, lam_x, lam_g, run)

    def _found(self, numbers: "Mapping[str, Array]") -> "Mapping[str, Any]":
        if self._matrices is None:
            return dict(self._function(**numbers))
        h, a = self._matrices(numbers["p"])
        bounds = {"lba": numbers["lbg"], "uba": numbers["ubg"]}
        begin = {name: numbers[name] for name in ("x0", "lbx", "ubx")}
        found = self._function(h=h, a=a, **bounds, **begin)
        return {**found, "lam_g": found["lam_a"]}


def _strained_iterations(stats: "Mapping[str, Any]") -> int:
    """How many followed one of large dual infeasibility, of those that Ipopt counts."""
    is_large = np.array(stats.get("iterations", {}).get("inf_du", ())) > STRAINED
    return int(np.count_nonzero(np.maximum.accumulate(is_large)))


def _diverged(
    programme: "dict[str, casadi.SX] | dict[str, casadi.MX]", multiplier_most: float
) -> "casadi.Function":
    """Asked after each iteration: other than 0 where it is to be the last."""
    import casadi

    sizes = [programme[name].numel() for name in "xfg"]
    sizes += [programme[name].numel() for name in "xgp"]
    answer = [casadi.MX.sym(casadi.nlpsol_out(i), size) for i, size in enumerate(sizes)]
    return casadi.Function("diverged", answer, [casadi.norm_inf(answer[3]) > multiplier_most])


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
