"""The meshes of a run: every input under a folder, read, cleaned, turned and scaled once, for all tools alike."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.ingest.collision_fit import Surface
from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.ingest.clean import clean
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.run.inputs import find_category
from casa_assets.ingest.run.steps import STAGES, BuildContext
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found
from casa_assets.mesh.surface import weld
from casa_assets.model.registry.category import Category
from casa_assets.model.source import Bundle


@dataclass(frozen=True)
class Prepared:
    """One input as the collision stage gets it: its draft, and the full mesh, welded, in the same frame."""

    path: str
    category: Category
    draft: Draft
    mesh: Surface


def prepared(folder: Path, every: int, only: Sequence[str], rounds: int = 1) -> Iterator[Prepared]:
    """Every input, or every n-th one, that the stages before collision accept, in a fixed order.

    Args:
        only: ids of categories, or none for all.
        rounds: in so many rounds, each of which takes inputs from all over the folder.
    """
    known = registry.load()
    found = [f for f in discover([folder]) if isinstance(f, Found)][::every]
    for one in (f for start in range(rounds) for f in found[start::rounds]):
        category = known.category(find_category(one, "")[0].id)
        if only and category.id not in only:
            continue
        try:
            bundle = collect(one, known.limits)
            told = brief(one, bundle, category)
            steps = {stage.name: stage.function for stage in STAGES}
            moved = steps["scale"](steps["orient"](clean(load(bundle, known.limits), category), told), told)
            yield Prepared(
                one.source.path,
                category,
                steps["simplify"](moved, told),
                _welded(moved.surface.vertices, moved.surface.faces),
            )
        except Rejected:
            continue


def brief(found: Found, bundle: Bundle, category: Category) -> BuildContext:
    """What the stages are told about an input, as the pipeline tells them."""
    known = registry.load()
    return BuildContext(
        asset_id=f"{category.id}_{bundle.sha256[:10]}",
        sha256=bundle.sha256,
        source=found.source,
        category=category,
        classes=known.classes_of(category),
        substance=known.substances[category.substance],
        limits=dict(known.limits),
    )


def _welded(vertices: npt.NDArray[np.float64], faces: npt.NDArray[np.int64]) -> Surface:
    points, place = weld(vertices)
    ids = place[faces]
    corners = points[ids]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return points, ids[area > 0]


def publish(stem: Path, data: object, text: str) -> None:
    """Write the rows of a run as JSON and its page as Markdown, and print the latter."""
    stem.parent.mkdir(parents=True, exist_ok=True)
    stem.with_suffix(".json").write_text(json.dumps(data, indent=1, sort_keys=True) + "\n", encoding="utf-8")
    stem.with_suffix(".md").write_text(text, encoding="utf-8")
    print(text)
