"""Compiles a numerical kernel without losing its type, or the last edit."""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.extending import register_jitable

F = TypeVar("F", bound=Callable[..., object])

# Which have kernels, and those whose values or tuples are compiled into them: a test finds them.
SOURCES = [
    "base/commands.py",
    "base/compiled.py",
    "base/interpolation.py",
    "base/vectors.py",
    "inflight/simulation/gyros/closed_loop.py",
    "inflight/simulation/gyros/dynamics.py",
    "inflight/simulation/gyros/onboard.py",
    "inflight/simulation/loop.py",
    "inflight/simulation/plant.py",
    "inflight/simulation/rosenbrock.py",
    "motion/pointing/line_of_sight.py",
    "motion/pointing/reach.py",
    "planning/campaigns/displaced.py",
    "planning/campaigns/network.py",
    "planning/campaigns/path.py",
    "planning/campaigns/platforms/axis_slew_time.py",
    "planning/campaigns/platforms/body.py",
    "planning/campaigns/platforms/body_slew_time.py",
    "planning/campaigns/platforms/follower.py",
    "planning/campaigns/platforms/slew_fits.py",
    "planning/campaigns/smooth_turns.py",
    "planning/label_search.py",
    "planning/opportunities/looks.py",
    "planning/opportunities/margins.py",
    "planning/opportunities/sessions.py",
    "planning/opportunities/sweep.py",
    "planning/opportunities/telling.py",
    "planning/opportunities/tracking.py",
    "spacecraft/imaging/session.py",
    "verification/unloading.py",
    "world/frames/earth_orientation.py",
    "world/frames/geodesy.py",
    "world/frames/time_scales.py",
    "world/platforms/cmg_array.py",
    "world/platforms/drive.py",
    "world/platforms/polygon_kernel.py",
    "world/platforms/steering.py",
    "world/platforms/wheels.py",
    "world/targets/apparent.py",
    "world/targets/limb_kernel.py",
    "world/targets/standard_atmosphere.py",
]


def _digest(planner: Path) -> str:
    sources = b"".join((planner / source).read_bytes() for source in SOURCES)
    return hashlib.sha256(sources).hexdigest()[:16]


# Numba compiles anew what was edited but not its callers in other files, which would go on
# flying the old code: each state of the sources has a cache of its own.
_PLANNER = Path(__file__).parents[1]
_CACHE = Path(os.environ.get("NUMBA_CACHE_DIR", _PLANNER / "__pycache__"))
numba.config.CACHE_DIR = str(_CACHE / _digest(_PLANNER))  # type: ignore[attr-defined]  # set as it is loaded


def compiled(function: F) -> F:
    """Compile to machine code at the first call, cached on disk, free of the interpreter lock.

    Divisions follow IEEE 754 (Python's check of each divisor costs a sixth of a flight's time).
    """
    return _to_machine_code(function, cache=True)


def nested(function: F) -> F:
    """The same for what compiled code calls in a place or two: it becomes a part of its caller,
    or it would be compiled by itself, and once more with each caller's caller."""
    return _to_machine_code(function, inline="always")


def lean(function: F) -> F:
    """The same for what only kernels call and makes no arrays: it need not count who holds those it
    is given, which takes several times as long as to look at a target once.  From Python, for which
    no door is compiled, it is Python."""
    return _part_of_callers(function)


def inlined(function: F) -> F:
    """The same, as a part of each caller: a call would copy the tables' descriptors."""
    return _part_of_callers(function, forceinline=True)


# Nobody in C calls ours; a door for that is a fifth of what the windows take to compile.
_OPTIONS = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}


def _to_machine_code(function: F, **options: bool | str) -> F:
    njit = cast(Any, numba.njit)  # whose types don't list all of its options
    return cast(F, njit(**_OPTIONS, **options)(function))


def _part_of_callers(function: F, **options: bool) -> F:
    return register_jitable(_nrt=False, **_OPTIONS, **options)(function)
