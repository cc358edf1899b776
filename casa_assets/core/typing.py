"""Names of the array types that most modules use. Shapes are documented by the functions that take or return them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

# Coordinates and measures.
Floats = npt.NDArray[np.float64]
# The same of pictures, where half the memory is half the time.
Singles = npt.NDArray[np.float32]
# Indices and counts.
Ints = npt.NDArray[np.int64]
# True where something holds.
Mask = npt.NDArray[np.bool_]
