"""A kind of surface (`ceramic_tile`, `veneer`): its parameters, and how it is painted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from casa_assets.textures.canvas import Canvas, Layers


@dataclass(frozen=True)
class TextureKind:
    """Kind of texture: its name, the type of its parameters, and its painter.

    Attributes:
        name: as recipes call it.
        params: Record type of what a recipe may set.
        paint: (params, canvas, rng) -> Layers. The picture repeats without a seam in both directions, and depends on
            the numbers and the generator alone: another size in pixels shows the same design.
    """

    name: str
    params: Any
    paint: Callable[[Any, Canvas, np.random.Generator], Layers]
