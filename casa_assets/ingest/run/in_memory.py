"""Meshes that the caller holds in memory: one into an asset in the caller's process, or many as inputs of a run."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.ingest.run.survey import Survey, find_category
from casa_assets.ingest.sources.found import Found, Refused
from casa_assets.ingest.sources.places import utf8_escaped
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Report
from casa_assets.model.source import Source, SourceKind, Up

if TYPE_CHECKING:
    from casa_assets.mesh.trimesh_exchange import MeshOrScene

# Axis of a mesh that points up; empty: what its metadata say, else it is guessed.
UpAxis = Literal["", "x", "y", "z"]
MESHES = "meshes"  # folder of the models that `stage_meshes` writes, within the staging folder


@dataclass(frozen=True)
class MeshInput:
    """A mesh in memory with what is known of it, for `Library.ingest`.

    Attributes:
        mesh: a trimesh.Trimesh or trimesh.Scene.
        name: what it is called; where no category is given it is looked up in it.
        category: id of what it is, such as `mug`. up: axis that points up.
    """

    mesh: MeshOrScene
    name: str = "mesh"
    category: str = ""
    up: UpAxis = ""


def stage_meshes(meshes: Sequence[MeshInput], staging: Path) -> Iterator[Found | Refused]:
    """Write meshes into a folder that the run sweeps at its end, for workers to read, and yield them as its inputs."""
    if not meshes:
        return
    from casa_assets.formats.read.from_trimesh import raw_from_trimesh  # imports trimesh: half a second

    folder = staging / MESHES
    for number, one in enumerate(meshes):
        name = utf8_escaped(one.name)
        try:
            model = raw_from_trimesh(one.mesh, name=name, up=Up(one.up) if one.up else None)
        except Rejected as error:
            yield Refused(name, error.code, error.message)
            continue
        folder.mkdir(exist_ok=True)
        (folder / f"{number}.json").write_text(model.to_json(), encoding="utf-8")
        yield Found(folder, f"{number}.json", _source(name, one.category), is_model=True)


def _source(name: str, category: str = "") -> Source:
    return Source(kind=SourceKind.FOLDER, path=name, category=category, hints=(name,))


def ingest_mesh(mesh: MeshOrScene, name: str, category: str = "", up: Up | None = None) -> tuple[Asset, Report]:
    """The asset of a mesh or scene, and the report of every check, errors too.

    Args:
        name: of the mesh; where no category is given it is looked up in it.
        category: id of what it is. up: axis that points up; None: what the mesh's metadata say, else guessed.
    Raises:
        Rejected: a stage cannot accept it. UnknownId: no such category.
        CannotDraw, NoRenderer: this machine draws no pictures.
    """
    from casa_assets.formats.read.from_trimesh import bundle_from_trimesh
    from casa_assets.ingest.run.stages import build_asset
    from casa_assets.runs.asset_package import check_package, write_package

    source = _source(name)
    kind, confidence, reason = find_category(Found(Path(), name, source), category)
    bundle = bundle_from_trimesh(mesh, name=name, up=up)
    survey = Survey(bundle.sha256, kind.id, confidence, reason)
    asset, notes = build_asset(bundle, survey, source, f"{kind.id}_{bundle.sha256[:10]}", registry.load().limits)
    with tempfile.TemporaryDirectory(prefix="casa-assets-") as place:
        folder = Path(place) / asset.id
        folder.mkdir()
        write_package(asset, folder)
        checked = check_package(asset, folder)
    return asset, Report(subject=asset.id, issues=notes) + checked
