"""Find the empty voxels of a solid that would hold water: the inside of an open vessel."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy import ndimage

VoxelMask = npt.NDArray[np.bool_]


def fillable_volume(solid: VoxelMask) -> VoxelMask:
    """Mark the empty voxels that are reached from outside and that water, which runs sideways and down, does not leave.

    Args:
        solid: (X, Y, Z) cubes of matter, z up, with air all around.
    """
    air = np.pad(~solid, ((0, 0), (0, 0), (1, 1)), constant_values=True)
    runs = np.zeros_like(air)
    runs[:, :, 0] = True
    plane = np.ones((3, 3), dtype=bool)
    for level in range(1, air.shape[2]):
        here = air[:, :, level]
        start = here & runs[:, :, level - 1]
        for edge in (np.s_[0, :], np.s_[-1, :], np.s_[:, 0], np.s_[:, -1]):
            start[edge] = here[edge]
        runs[:, :, level] = ndimage.binary_propagation(start, plane, mask=here)
    reached = ndimage.binary_propagation(runs & air, ndimage.generate_binary_structure(3, 1), mask=air)
    held: VoxelMask = (air & reached & ~runs)[:, :, 1:-1]
    return held
