"""The array that nearly every quantity here is."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
