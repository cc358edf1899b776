"""Write an asset of any origin as a folder of MJCF and USD, check it there and certify it."""

from __future__ import annotations

import io
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from PIL import Image

from casa_assets import registry
from casa_assets.cache.cache_key import CodeRef
from casa_assets.checks.check import Package
from casa_assets.checks.check import run as run_checks
from casa_assets.core.numeric import significant
from casa_assets.errors import OutputError
from casa_assets.formats import mjcf
from casa_assets.formats.usd.document import write as write_usd
from casa_assets.library.entry_files import (
    Certificate,
    MadeBy,
    Summary,
    file_digests,
    read_asset,
    write_certificate,
    write_files,
)
from casa_assets.library.pairs import signature
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.parts import Hull
from casa_assets.model.issue import Issue, Report
from casa_assets.model.registry.category import Category
from casa_assets.registry.plugins.checks import check_table, checks_versions, with_plugin_limits
from casa_assets.show.stills.still import render
from casa_assets.show.stills.studio import View

PREVIEW_PX = 512
THUMBNAIL_PX = 256
PREVIEW = View(size_px=PREVIEW_PX)
# The code that turns an asset into its package, by the name under which certificates list its version.
WRITING: Mapping[str, CodeRef] = {
    "mjcf": mjcf.write,
    "usd": write_usd,
    "preview": render,
    "checks": run_checks,
    "signature": signature,
}


def write_package(asset: Asset, folder: Path, view: View = PREVIEW) -> float:
    """Write model.xml, scene.xml, meshes/, textures/, usd/ and preview.png of an asset into a folder.

    Args:
        folder: named as the asset's id, which SimReady asks for. view: of the picture.
    Returns:
        Seconds that drawing the picture took.
    Raises:
        CannotDraw, NoRenderer: no picture can be made on this machine.
    """
    write_files(folder, mjcf.write(asset))
    begin = time.perf_counter()
    picture = render(folder / "model.xml", view)
    (folder / "preview.png").write_bytes(picture)
    drawn_s = time.perf_counter() - begin
    write_files(folder, write_usd(asset, thumbnail(picture)))
    return drawn_s


def check_package(
    asset: Asset, folder: Path, category: Category | None = None, notes: tuple[Issue, ...] = ()
) -> Report:
    """The report of every check that applies to an asset and to the folder that it was written to.

    Args:
        category: of the asset; where it is not given, that which its labels name.
        notes: issues that are known already; they come first in the report.
    """
    records = registry.load()
    waived, limits = records.waived(asset.id), with_plugin_limits(records.limits)
    package = Package(asset, category or category_of(asset), folder, records.contracts.get(asset.contract or ""))
    report = Report(subject=asset.id, issues=notes)
    for subject in (asset, package):
        report = report + run_checks(subject, asset.id, limits, waived, check_table())
    return report


def certify(asset: Asset, report: Report, folder: Path, made_by: MadeBy) -> None:
    """Write asset.json of an asset that has passed, and read it back. Raises ValueError."""
    write_certificate(folder, asset, certificate(asset, report, folder, made_by))
    try:
        is_same = read_asset(folder) == asset
    except OutputError as error:
        raise ValueError(f"the asset that was written cannot be read: {error.message}") from error
    if not is_same:
        raise ValueError("the asset read back from its folder differs from the one written")


def certificate(asset: Asset, report: Report, folder: Path, made_by: MadeBy) -> Certificate:
    """Return the certificate of an asset that is in `folder` and has passed."""
    hulls = [len(c.shape.mesh.vertices) for k in asset.links for c in k.colliders if isinstance(c.shape, Hull)]
    x, y, z = (significant(v, 6) for v in np.ptp(asset.bounds, axis=0))
    return Certificate(
        asset_digest=asset.digest,
        producer=made_by.producer,
        cache_key=made_by.cache_key,
        versions={**made_by.versions, **checks_versions()},
        report=report,
        summary=Summary(
            extents=(x, y, z),
            mass=significant(asset.mass, 6),
            colliders=sum(len(k.colliders) for k in asset.links),
            hull_vertices=max(hulls, default=0),
            faces=sum(len(v.mesh.faces) for k in asset.links for v in k.visuals),
        ),
        files=file_digests(folder),
        signature=signature(asset),
    )


def thumbnail(picture: bytes) -> bytes:
    """The picture at 256 pixels, PNG."""
    out = io.BytesIO()
    with Image.open(io.BytesIO(picture)) as image:
        image.convert("RGB").resize((THUMBNAIL_PX, THUMBNAIL_PX), Image.Resampling.LANCZOS).save(out, "PNG")
    return out.getvalue()


def category_of(asset: Asset) -> Category:
    """The category of an asset in the registry, a fixture or not. Raises UnknownId."""
    records = registry.load()
    name = asset.labels.category
    fixture = records.fixtures.get(name)
    # Families name fixtures, ingest names categories; where both have the name, a family's asset has the fixture's
    # classes.
    if fixture is not None and (name not in records.categories or records.classes_of(fixture) == asset.labels.classes):
        return fixture
    return records.category(name)
