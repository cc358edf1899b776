"""What a recipe paints: colour, relief and gloss of one picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Map = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Layers:
    """One picture; row 0 is its upper edge.

    Attributes:
        albedo: (H, W, 3) float32, sRGB 0..1.
        height_m: (H, W) float32, metres above a plane, out of the surface.
        roughness: (H, W) float32, 0..1.
        metallic: 0..1, of the whole surface.
    """

    albedo: Map
    height_m: Map
    roughness: Map
    metallic: float = 0.0
