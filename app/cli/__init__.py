"""The `slewtrack` command."""

import os

# Read when NumPy is loaded, as it is for the service's children: threads of BLAS take a sixth more
# time of a plan's command, and four times as much for probabilities of windows.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
from app.cli.command import main

__all__ = ["main"]
