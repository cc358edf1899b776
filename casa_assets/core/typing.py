"""Names of the array types that most modules use. Shapes stand in the docstrings of those who take or give them."""

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
