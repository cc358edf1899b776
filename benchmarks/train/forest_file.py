"""Write a forest that scikit-learn has fitted as a file of registry/learned/, which casa_assets/registry reads."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from sklearn.ensemble import ExtraTreesClassifier

LEARNED = Path(__file__).parents[2] / "registry" / "learned"


def write_forest(
    name: str, forest: ExtraTreesClassifier, features: Sequence[str], classes: Sequence[str], folder: Path = LEARNED
) -> None:
    """Write <folder>/<name>.json, a tree on each line, and print how large it is."""
    head = {"features": list(features), "classes": list(classes)}
    trees = ",\n".join(json.dumps(list(_nodes(e.tree_)), separators=(",", ":")) for e in forest.estimators_)
    folder.mkdir(exist_ok=True)
    path = folder / f"{name}.json"
    path.write_text(f'{json.dumps(head, indent=1)[:-2]},\n "trees": [\n{trees}\n]}}\n', encoding="utf-8")
    print(f"{path.name}: {path.stat().st_size / 1024:.0f} KiB")


def _nodes(tree: Any) -> Iterator[list[Any]]:
    """Nodes as `casa_assets.core.forest.forest_from_dict` takes them."""
    for k in range(tree.node_count):
        if tree.children_left[k] < 0:
            share = tree.value[k, 0] / tree.value[k, 0].sum()
            yield [[round(100 * float(p)) for p in share]]
        else:
            threshold = float(f"{tree.threshold[k]:.4g}")
            yield [int(tree.feature[k]), threshold, int(tree.children_left[k]), int(tree.children_right[k])]
