"""An asset of any origin written as a folder of both formats, and the checks that apply to it there."""

from __future__ import annotations

from pathlib import Path

from casa_assets import registry
from casa_assets.checks.package.package import Package
from casa_assets.checks.run import run as run_checks
from casa_assets.export import mjcf
from casa_assets.export.usd.document import write as write_usd
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Report
from casa_assets.model.registry.category import Category
from casa_assets.pipeline.ingest.worker import PREVIEW_PX, thumbnail
from casa_assets.pipeline.library import library as disk
from casa_assets.preview.camera import View
from casa_assets.preview.still import render


def write_package(asset: Asset, folder: Path) -> None:
    """Write model.xml, scene.xml, meshes/, textures/, usd/ and preview.png of an asset into an empty folder.

    Args:
        folder: named as the asset's id, which SimReady asks for.
    Raises:
        CannotDraw, NoRenderer: no picture can be made on this machine.
    """
    disk.write_files(folder, mjcf.write(asset))
    picture = render(folder / "model.xml", View(size_px=PREVIEW_PX))
    (folder / "preview.png").write_bytes(picture)
    disk.write_files(folder, write_usd(asset, thumbnail(picture)))


def check_package(asset: Asset, folder: Path) -> Report:
    """The report of every check that applies to an asset and to the folder that it was written to."""
    known = registry.load()
    waived = known.waived(asset.id)
    package = Package(asset, category_of(asset), folder, known.contracts.get(asset.contract or ""))
    report = Report(subject=asset.id)
    for subject in (asset, package):
        report = report + run_checks(subject, asset.id, known.limits, waived)
    return report


def category_of(asset: Asset) -> Category:
    """What the registry knows of the kind of an asset, a fixture or not. Raises UnknownId."""
    known = registry.load()
    name = asset.labels.category
    built = known.fixtures.get(name)
    # Families name fixtures, ingest names categories; where both have the name, a family's asset has the fixture's
    # classes.
    if built is not None and (name not in known.categories or known.classes_of(built) == asset.labels.classes):
        return built
    return known.category(name)
