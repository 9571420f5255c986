"""The versions of this program, of its dependencies, and of the shapes of its results."""

import platform
from functools import cache
from importlib.metadata import version

VERSION = version("slewtrack")
_DEPENDENCIES = ("astropy-iers-data", "casadi", "numpy", "pyerfa", "ruckig", "scipy", "sgp4")


@cache
def versions() -> dict[str, str]:
    ours = {"slewtrack": VERSION, "python": platform.python_version()}
    return ours | {name: version(name) for name in _DEPENDENCIES}
