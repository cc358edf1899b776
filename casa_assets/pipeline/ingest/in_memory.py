"""One mesh that the caller holds in memory into an asset, in the caller's process and without a library."""

from __future__ import annotations

import tempfile
from pathlib import Path

from casa_assets import registry
from casa_assets.errors import Rejected
from casa_assets.geometry.mesh.trimesh_exchange import MeshOrScene
from casa_assets.ingest.load.by_trimesh.from_trimesh import bundle_from_trimesh
from casa_assets.ingest.sources.found import Found
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.provenance import Guess
from casa_assets.model.ingest.source import Source, SourceKind, Up
from casa_assets.model.issue import Report
from casa_assets.pipeline.ingest.stages import BuildContext, run_stages
from casa_assets.pipeline.ingest.survey import find_category
from casa_assets.pipeline.library.asset_package import check_package, write_package
from casa_assets.pipeline.library.review import doubtful_guesses


def ingest_mesh(mesh: MeshOrScene, name: str, category: str = "", up: Up | None = None) -> tuple[Asset, Report]:
    """The asset of a mesh or scene, and the report of every check, errors too.

    Args:
        name: of the mesh; where no category is given it is looked up in it.
        category: id of what it is. up: axis that points up; None: what the mesh's metadata say, else guessed.
    Raises:
        Rejected: a stage cannot accept it. UnknownId: no such category.
        CannotDraw, NoRenderer: this machine draws no pictures.
    """
    known = registry.load()
    source = Source(kind=SourceKind.FOLDER, path=name, hints=(name,))
    kind, confidence, reason = find_category(Found(Path(), name, source), category)
    bundle = bundle_from_trimesh(mesh, name=name, up=up)
    brief = BuildContext(
        asset_id=f"{kind.id}_{bundle.sha256[:10]}",
        sha256=bundle.sha256,
        source=source,
        category=kind,
        classes=known.classes_of(kind),
        substance=known.substances[kind.substance],
        limits=dict(known.limits),
    )
    asset, notes = run_stages(bundle, brief, lambda _: None, lambda *_: None)
    provenance = asset.provenance
    guess = Guess(subject="category", value=kind.id, confidence=round(confidence, 2), reason=reason)
    guesses = (guess, *provenance.guesses)
    asset = asset.replace(provenance=provenance.replace(guesses=guesses))
    with tempfile.TemporaryDirectory(prefix="casa-assets-") as place:
        folder = Path(place) / asset.id
        folder.mkdir()
        write_package(asset, folder)
        checked = check_package(asset, folder)
    return asset, Report(subject=asset.id, issues=(*notes, *doubtful_guesses(guesses))) + checked


def first_error(report: Report) -> Rejected:
    """The first error of a report as the reason of a rejection."""
    worst = report.errors[0]
    return Rejected(worst.code, f"{worst.pointer}: {worst.message}" if worst.pointer else worst.message)
