"""Draw things of all kinds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.articulate.cases.labelled import LabelledMesh
from benchmarks.articulate.cases.plain import appliances, fittings, furniture
from benchmarks.articulate.cases.plain.drawing import Drawing, drawn_style

# Kinds by name, and the category of each in the benchmark's sense.
KINDS: dict[str, tuple[str, Callable[[Drawing], None]]] = {
    "cabinet": ("cabinet", furniture.cabinet),
    "wardrobe": ("cabinet", furniture.wardrobe),
    "desk": ("desk", furniture.desk),
    "chest": ("box", furniture.chest),
    "bin": ("bin", furniture.bin_),
    "safe": ("safe", furniture.safe),
    "washing_machine": ("washing_machine", appliances.washing_machine),
    "microwave": ("microwave", appliances.microwave),
    "range": ("oven", appliances.range_),
    "oven": ("oven", appliances.oven),
    "dishwasher": ("dishwasher", appliances.dishwasher),
    "fridge": ("fridge", appliances.fridge),
    "toaster": ("toaster", appliances.toaster),
    "coffee_machine": ("coffee_machine", appliances.coffee_machine),
    "laptop": ("laptop", appliances.laptop),
    "faucet": ("faucet", fittings.faucet),
    "switch": ("switch", fittings.switch),
    "remote": ("remote", fittings.remote),
    "button_box": ("button_box", fittings.button_box),
    "stove_top": ("stove", fittings.stove_top),
}


def draw(kind: str, seed: int, index: int) -> LabelledMesh:
    """Draw number `index` of a kind; the same for the same seed."""
    category, how = KINDS[kind]
    rng = np.random.default_rng([seed, index, *kind.encode()])
    drawing = Drawing(category, drawn_style(rng), rng)
    how(drawing)
    return drawing.mesh(f"{kind}_{index}")
