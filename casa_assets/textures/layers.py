"""Layers of a painted texture: colour, relief and roughness."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

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

    @classmethod
    def of(
        cls,
        albedo: npt.NDArray[np.floating[Any]],
        height_m: npt.NDArray[np.floating[Any]],
        roughness: npt.NDArray[np.floating[Any]],
        metallic: float = 0.0,
    ) -> Layers:
        """Layers with colours and roughness kept within bounds, in single precision."""
        return cls(
            np.clip(albedo, 0.0, 1.0).astype(np.float32),
            height_m.astype(np.float32),
            np.clip(roughness, 0.04, 1.0).astype(np.float32),
            metallic,
        )
