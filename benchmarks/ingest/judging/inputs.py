"""The meshes of a run: every input under a folder, read, cleaned, turned and scaled once, for all tools alike."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from benchmarks.ingest.judging.distance import Surface
from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.formats.read import load
from casa_assets.ingest.clean import clean
from casa_assets.ingest.draft import Draft
from casa_assets.ingest.run.steps import STAGES, BuildContext
from casa_assets.ingest.run.survey import find_category
from casa_assets.ingest.sources.bundle import collect
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.found import Found
from casa_assets.mesh.solid.solids import closed_solid
from casa_assets.mesh.surface import signed_volume
from casa_assets.mesh.topology import weld
from casa_assets.model.registry.category import Category, MatterFill
from casa_assets.model.source import Bundle


@dataclass(frozen=True)
class Input:
    """One input.

    Attributes:
        path: as its source names it. category: what it is taken for.
        mesh: cleaned, z up, metres, standing in the middle of the ground, or None.
        volume: m^3 where the mesh is closed. density: kg/m^3 of its substance.
        full: it is matter all through (solid or with walls), so that volume times density is its mass.
    """

    path: str
    category: str
    mesh: Surface | None = None
    volume: float | None = None
    density: float = 1000.0
    full: bool = False


def gather(folder: Path, every: int, categories: Mapping[str, str]) -> list[Input]:
    """Every input, or every n-th one, in a fixed order; `categories` are ids by path, as the pipeline found them."""
    found = [f for f in discover([folder]) if isinstance(f, Found)]
    return [_read(f, categories.get(f.source.path, registry.FALLBACK)) for f in found[::every]]


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


def _read(found: Found, name: str) -> Input:
    known = registry.load()
    path, category = found.source.path, known.category(name)
    try:
        bundle = collect(found, known.limits)
        draft = clean(load(bundle, known.limits), category)
        told = brief(found, bundle, category)
        steps = {stage.name: stage.function for stage in STAGES}
        moved = steps["scale"](steps["orient"](draft, told), told)
        final = steps["simplify"](moved, told)
    except Rejected:
        return Input(path, name)
    points, faces = _standing(moved, final)
    solid = closed_solid(points, faces)
    return Input(
        path,
        name,
        (points, faces),
        None if solid is None else signed_volume(*solid),
        known.substances[category.substance].density,
        category.build in (MatterFill.SOLID, MatterFill.VESSEL),
    )


def _standing(moved: Draft, final: Draft) -> Surface:
    """The full mesh, shifted as the asset is: by the bounds of what is written."""
    seen = final.surface.vertices
    low, high = seen.min(axis=0), seen.max(axis=0)
    vertices, faces = moved.surface.vertices, moved.surface.faces
    return _welded(vertices - np.array([(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, low[2]]), faces)


def _welded(vertices: npt.NDArray[np.float64], faces: npt.NDArray[np.int64]) -> Surface:
    points, place = weld(vertices)
    ids = place[faces]
    corners = points[ids]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return points, ids[area > 0]


def dump(path: Path, data: object) -> None:
    """JSON that a person can read."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(data, indent=1, sort_keys=True) + "\n", encoding="utf-8")
