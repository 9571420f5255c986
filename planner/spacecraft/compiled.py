"""How is a numerical kernel compiled without losing its type?"""

from collections.abc import Callable
from typing import TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., object])


def compiled(function: F) -> F:
    """Compile to machine code at the first call, cached on disk, free of the interpreter lock."""
    return cast(F, numba.njit(cache=True, nogil=True)(function))
