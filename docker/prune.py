"""Removes from the installed packages what the image does not need.

    python prune.py SITE_PACKAGES

That is CasADi's other solvers and the copies of its libraries under their other names (a wheel
knows no links), the libraries of Pillow's other formats, the packages' own tests, sources and
static libraries, what nothing reads, and the symbols that only debuggers read; OpenCV takes
CasADi's OpenBLAS.  Licences stay.  Prints what each step saved, and solves with what remains.
The Dockerfile runs try_out.sh afterwards.
"""

import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

# Prints the libraries that a process maps once OpenCV's LAPACK (with matrices this large), Ipopt
# and PIQP have solved something, and Pillow has written a picture as Matplotlib lets it.
_SOLVE = """
import cv2
import numpy as np
i = np.arange(128.0)
a = np.exp(-np.abs(i[:, None] - i)) + np.eye(128)
for method in (cv2.DECOMP_LU, cv2.DECOMP_CHOLESKY, cv2.DECOMP_QR, cv2.DECOMP_SVD):
    x = cv2.solve(a, a @ i[:, None], flags=method)[1]
    assert np.allclose(cv2.gemm(a, x, 1, None, 0), a @ i[:, None]), method

import casadi
x = casadi.MX.sym("x")
problem = {"x": x, "f": (x - 1) ** 2, "g": x}
quiet = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes"}}
for solver in (
    casadi.nlpsol("solver", "ipopt", problem, quiet),
    casadi.qpsol("quick", "piqp", problem, {"print_time": False}),
):
    assert abs(solver(x0=3, lbg=0, ubg=2)["x"] - 1) < 1e-6, solver

import io
from PIL import Image
Image.new("RGBA", (2, 2)).save(io.BytesIO(), format="png")
for line in open("/proc/self/maps"):
    if ".so" in line:
        print(line.split()[-1])
"""
_TESTS = ("tests", "tornado/test", "sqlalchemy/testing", "alembic/testing")
_DEVELOPMENT = ("*.a", "*.pyi", "*.h", "*.hpp", "*.cmake", "*.pc", "*.px?", "*.pyx", "*.lib", "*.c")
# The IERS's other series; of Dask's collections, XML, fonts, NumPy's tests and SciPy's formats what
# nothing here uses.
_UNREAD = (
    "astropy_iers_data/data/eopc04*",
    "dask/array",
    "dask/bag",
    "dask/dataframe",
    "lxml/objectify*",
    "matplotlib/mpl-data/sample_data",
    "matplotlib/mpl-data/fonts/afm",
    "matplotlib/mpl-data/fonts/pdfcorefonts",
    "numpy/_core/_simd*",
    "scipy/io/_fast_matrix_market/*.so",
)


def main(site: Path) -> None:
    """Prune in place."""
    steps = {
        "CasADi's other solvers, Pillow's other formats": _unmapped(site, "casadi", "pillow.libs"),
        "tests": _found(site, _TESTS),
        "headers, sources, stubs and static libraries": _found(site, _DEVELOPMENT),
        "data and code that nothing reads": _found(site, _UNREAD),
    }
    for name, victims in steps.items():
        print(f"{name}: {_removed(victims) / 1e6:.0f} MB")
    print(f"OpenCV's OpenBLAS: {_shared(site) / 1e6:.0f} MB")
    print(f"symbols: {_stripped(site) / 1e6:.0f} MB")
    _mapped()


def _mapped() -> set[str]:
    done = subprocess.run(  # noqa: S603 (our own words, by our own interpreter)
        [sys.executable, "-c", _SOLVE], check=True, stdout=subprocess.PIPE, text=True
    )
    return {Path(line).name for line in done.stdout.splitlines()}


def _unmapped(site: Path, *folders: str) -> Iterator[Path]:
    mapped = _mapped()
    for folder in folders:
        for path in (site / folder).rglob("*"):
            kept = path.suffix in (".py", ".pyc") or path.name in mapped
            licence = "licen" in str(path.relative_to(site)).lower()
            if path.is_file() and not kept and not licence:
                yield path


def _shared(site: Path) -> int:
    """OpenCV's OpenBLAS (with Fortran's libraries, which only that needs) is CasADi's.

    The loader looks for what a library needs beside the link by which it was found.
    """
    brought = site / "opencv_python_headless.libs"
    (openblas,) = brought.glob("libopenblas*")
    saved = _removed(iter([openblas, *brought.glob("libgfortran*"), *brought.glob("libquadmath*")]))
    casadi = Path("../casadi")
    openblas.symlink_to(casadi / "libcasadi-tp-openblas.so.0")
    for pattern in ("libgfortran*", "libquadmath*"):
        (library,) = (site / "casadi").glob(pattern)
        (brought / library.name).symlink_to(casadi / library.name)
    return saved


def _found(site: Path, patterns: tuple[str, ...]) -> Iterator[Path]:
    """But for a package's licences, among which are folders named like its code."""
    for pattern in patterns:
        for path in site.rglob(pattern):
            if not path.relative_to(site).parts[0].endswith(".dist-info"):
                yield path


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
