"""What of the installed packages does the image not need?

    python prune.py SITE_PACKAGES

Removes CasADi's other solvers and the copies of its libraries under their other names (a
wheel knows no links), the packages' own tests, headers and static libraries, what nothing
reads, and the symbols that only debuggers read.  Prints what each step saved.  The Dockerfile
runs try_out.sh afterwards.
"""

import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

# Prints the libraries of CasADi that a process maps once Ipopt and PIQP have solved something.
_SOLVE = """
import casadi
x = casadi.MX.sym("x")
problem = {"x": x, "f": (x - 1) ** 2, "g": x}
quiet = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes"}}
casadi.nlpsol("solver", "ipopt", problem, quiet)(x0=3, lbg=0, ubg=2)
casadi.qpsol("quick", "piqp", problem, {"print_time": False})(x0=3, lbg=0, ubg=2)
for line in open("/proc/self/maps"):
    if "/casadi/" in line:
        print(line.split()[-1])
"""
_TESTS = ("tests", "tornado/test", "sqlalchemy/testing", "alembic/testing")
_DEVELOPMENT = ("*.a", "*.pyi", "*.h", "*.hpp", "*.cmake", "*.pc", "*.px?", "*.pyx", "*.lib")
# The IERS's other series, and what zstandard takes where its own extension is not to be had.
_UNREAD = ("astropy_iers_data/data/eopc04*", "zstandard/_cffi*")


def main(site: Path) -> None:
    """Prune in place."""
    steps = {
        "CasADi's other solvers": _unmapped(site / "casadi"),
        "tests": _found(site, _TESTS),
        "headers, sources, stubs and static libraries": _found(site, _DEVELOPMENT),
        "data and code that nothing reads": _found(site, _UNREAD),
    }
    for name, victims in steps.items():
        print(f"{name}: {_removed(victims) / 1e6:.0f} MB")
    print(f"symbols: {_stripped(site) / 1e6:.0f} MB")


def _unmapped(casadi: Path) -> Iterator[Path]:
    done = subprocess.run(  # noqa: S603 (our own words, by our own interpreter)
        [sys.executable, "-c", _SOLVE], check=True, capture_output=True, text=True
    )
    mapped = {Path(line).name for line in done.stdout.splitlines() if ".so" in line}
    for solver in ("ipopt", "piqp"):
        if not any(solver in name for name in mapped):
            raise SystemExit(f"{solver} was not loaded: nothing can be told from what was")
    for path in casadi.iterdir():
        if path.suffix != ".py" and path.name not in mapped and path.name != "__pycache__":
            yield path


def _found(site: Path, patterns: tuple[str, ...]) -> Iterator[Path]:
    for pattern in patterns:
        yield from site.rglob(pattern)


def _stripped(site: Path) -> int:
    """But of what wheels bring along in *.libs, which was patched and doesn't bear it."""
    files = [path for path in site.rglob("*.so*") if not path.parent.name.endswith(".libs")]
    before = sum(path.stat().st_size for path in files)
    subprocess.run(["strip", "--strip-unneeded", *files], check=True)  # noqa: S603, S607
    return before - sum(path.stat().st_size for path in files)


def _removed(victims: Iterator[Path]) -> int:
    saved = 0
    for path in list(victims):
        if path.is_dir():
            saved += sum(file.stat().st_size for file in path.rglob("*") if file.is_file())
            shutil.rmtree(path)
        elif path.exists():
            saved += path.stat().st_size
            path.unlink()
    return saved


if __name__ == "__main__":
    main(Path(sys.argv[1]))
