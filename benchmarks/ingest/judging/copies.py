"""Copies of an entry of a library under other names, for libraries of very many entries: no mesh is made twice."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

import numpy as np

NAMES = ("asset.json", "reject.json")


def copied_entry(entry: Path, sha256: str, source: str, rng: np.random.Generator) -> Path:
    """A copy of an entry beside it, as if it were made of another input; its other files are hard links.

    The numbers of its form are moved at random, so far that most have no neighbour and some have a few, as in a library
    of many things.

    Args:
        entry: folder. sha256: of the other input. source: path of that one.
    """
    name = f"{entry.name.rpartition('_')[0]}_{sha256[:10]}"
    folder = entry.parent / name
    folder.mkdir()
    for path in sorted(entry.rglob("*")):
        target = folder / path.relative_to(entry)
        if path.name in NAMES:
            data = json.loads(path.read_text(encoding="utf-8"))
            _rename(data, name, sha256, source, rng)
            target.write_text(json.dumps(data), encoding="utf-8")
        elif path.is_file():
            target.parent.mkdir(parents=True, exist_ok=True)
            os.link(path, target)
    return folder


def _rename(data: dict[str, Any], name: str, sha256: str, source: str, rng: np.random.Generator) -> None:
    if "asset" not in data:
        data.update(id=name, sha256=sha256)
        data["source"]["path"] = source
        return
    data["asset"]["id"] = name
    data["asset"]["provenance"].update(path=source, sha256=sha256)
    data["certificate"]["asset_digest"] = hashlib.sha256(sha256.encode()).hexdigest()
    shape = data["certificate"]["signature"]["shape"]
    stretch = rng.uniform(-0.5, 0.5, 3)
    for field, shift in zip(("pair_distances", "center_distances", "axis_spread"), stretch, strict=True):
        bent = np.array(shape[field]) * (1 + shift * np.linspace(0.0, 1.0, len(shape[field])))
        shape[field] = [round(float(v), 4) for v in bent + rng.normal(0.0, 0.05, len(bent))]
