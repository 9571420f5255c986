"""`make test-other-arithmetic` does calculate as another processor does."""

import ctypes
import os
from importlib.metadata import distribution

import pytest
from numpy._core._multiarray_umath import __cpu_features__

pytestmark = pytest.mark.skipif(
    "SLEWTRACK_TEST_OTHER_ARITHMETIC" not in os.environ, reason="this processor's own arithmetic"
)
WIDE = ("X86_V3", "X86_V4", "AVX512_ICL")
OLD = (b"Prescott", b"Katmai")  # one core, named by OpenBLAS after either


@pytest.mark.parametrize(
    ("package", "function"),
    [("numpy", "scipy_openblas_get_corename64_"), ("scipy", "scipy_openblas_get_corename")],
)
def test_blas_is_of_a_processor_without_wide_vectors(package, function):
    [library] = [f for f in distribution(package).files if "libscipy_openblas" in f.name]
    named = getattr(ctypes.CDLL(str(library.locate())), function)
    named.restype = ctypes.c_char_p
    assert named() in OLD


def test_numpy_has_no_wide_vectors():
    assert not any(__cpu_features__.get(name, False) for name in WIDE)
