"""How is a numerical kernel compiled without losing its type?"""

from collections.abc import Callable
from typing import TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """Compile to machine code at the first call, cached on disk, free of the interpreter lock.

    Numba recompiles what was edited, not its callers in other files: after editing a kernel,
    remove the caches (`__pycache__`).  Divisions follow IEEE 754
    (Python's check of each divisor costs a sixth of a flight's time).
    """
    return cast(F, numba.njit(cache=True, nogil=True, error_model="numpy")(function))
