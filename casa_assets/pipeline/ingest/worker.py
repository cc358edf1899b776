"""One input from its bytes to a finished entry in the staging folder; runs in a child process of its own."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from PIL import Image

from casa_assets import registry
from casa_assets.checks.package import usd
from casa_assets.checks.package.package import Package
from casa_assets.checks.run import run as run_checks
from casa_assets.core.rounding import significant
from casa_assets.errors import CasaError, OutputError, RegistryError, Rejected
from casa_assets.export import mjcf
from casa_assets.export.usd.document import write as write_usd
from casa_assets.ingest.sources.bundle import collect
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.provenance import Guess
from casa_assets.model.asset.shape import Hull
from casa_assets.model.ingest.source import Bundle
from casa_assets.model.issue import Issue, Report
from casa_assets.model.registry.category import Category
from casa_assets.pipeline.cache.cache_key import CodeRef, versions_of
from casa_assets.pipeline.cache.store import Store
from casa_assets.pipeline.dedup.signature import signature
from casa_assets.pipeline.ingest.job import Job, Outcome, RunAborted, stage_refusal, writing
from casa_assets.pipeline.ingest.stages import BuildContext, read_raw_model, run_stages, stage_functions
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.identity import Producer
from casa_assets.pipeline.library.review import doubtful_guesses
from casa_assets.preview.camera import View
from casa_assets.preview.raw.raw_model import render_model
from casa_assets.preview.renderer import NoRenderer, backend
from casa_assets.preview.still import render

PREVIEW_PX = 512
THUMBNAIL_PX = 256
# What every producer does with an asset, once it has one.
WRITING: Mapping[str, CodeRef] = {
    "mjcf": mjcf.write,
    "usd": write_usd,
    "preview": render,
    "checks": run_checks,
    "signature": signature,
}


def warm() -> None:
    """Load what every worker needs, once for all of them; nothing here may draw."""
    registry.load()
    usd.load_rules()


def check_renderer(_: None) -> RunAborted | None:
    """Whether a worker can draw at all; a process that has drawn cannot be forked, so the pool asks a worker."""
    try:
        backend()
    except NoRenderer as error:
        return RunAborted(str(error))
    return None


def work(job: Job) -> Outcome | RunAborted:
    """Build, write, look at and check one asset; the entry, or the reason why not, is staged when this returns."""
    try:
        with writing(job.library):
            return _work(job)
    except (OutputError, RegistryError, NoRenderer) as error:
        return RunAborted(str(error))


def _work(job: Job) -> Outcome:
    library = disk.Library(job.library)
    known = registry.load()
    category = known.category(job.survey.category)
    staged = library.stage(job.asset_id)
    bundle: Bundle | None = None
    report: Report | None = None
    try:
        bundle = collect(job.found, job.limits)
        if bundle.sha256 != job.survey.sha256:
            raise Rejected("RUN005", "the file changed while it was being read; run again")
        asset, notes = _asset(job, bundle, category, Store(library.cache))
        report = _write_and_check(asset, category, staged, notes)
        if not report.passed:
            worst = report.errors[0]
            raise Rejected(worst.code, f"{worst.pointer}: {worst.message}" if worst.pointer else worst.message)
        made_by = disk.MadeBy(Producer.INGEST, job.cache_key, versions_of({**stage_functions(), **WRITING}))
        disk.write_certificate(staged, asset, certificate(asset, report, staged, made_by))
        _read_back(asset, staged)
        return Outcome(True, warnings=report.issues, staged=staged)
    except Rejected as error:
        picture = None if bundle is None else _picture(bundle, staged, job.limits)
        refused = stage_refusal(library, job, error, report, picture)
        return Outcome(False, error.code, error.message, staged=refused)


def _read_back(asset: Asset, staged: Path) -> None:
    try:
        same = disk.read_asset(staged) == asset
    except OutputError as error:
        raise ValueError(f"the asset that was written cannot be read: {error.message}") from error
    if not same:
        raise ValueError("the asset read back from its folder differs from the one written")


def _asset(job: Job, bundle: Bundle, category: Category, store: Store) -> tuple[Asset, tuple[Issue, ...]]:
    known = registry.load()
    brief = BuildContext(
        asset_id=job.asset_id,
        sha256=bundle.sha256,
        source=job.found.source,
        category=category,
        classes=known.classes_of(category),
        substance=known.substances[category.substance],
        limits=dict(job.limits),
        override=job.override,
    )
    asset, notes = run_stages(bundle, brief, store.get, store.put)
    survey = job.survey
    guess = Guess(subject="category", value=category.id, confidence=round(survey.confidence, 2), reason=survey.reason)
    provenance = asset.provenance
    guesses = (guess, *provenance.guesses)
    return asset.replace(provenance=provenance.replace(guesses=guesses)), (*notes, *doubtful_guesses(guesses))


def _write_and_check(asset: Asset, category: Category, staged: Path, notes: tuple[Issue, ...]) -> Report:
    """Both formats, the picture, and every check that applies; the notes of the stages come first in the report."""
    known = registry.load()
    disk.write_files(staged, mjcf.write(asset))
    picture = render(staged / "model.xml", View(size_px=PREVIEW_PX))
    (staged / "preview.png").write_bytes(picture)
    disk.write_files(staged, write_usd(asset, thumbnail(picture)))
    waived = known.waived(asset.id)
    report = Report(subject=asset.id, issues=notes)
    for subject in (asset, Package(asset, category, staged)):
        report = report + run_checks(subject, asset.id, known.limits, waived)
    return report


def thumbnail(picture: bytes) -> bytes:
    """The picture at 256 pixels, PNG."""
    out = io.BytesIO()
    with Image.open(io.BytesIO(picture)) as image:
        image.convert("RGB").resize((THUMBNAIL_PX, THUMBNAIL_PX), Image.Resampling.LANCZOS).save(out, "PNG")
    return out.getvalue()


def certificate(asset: Asset, report: Report, staged: Path, made_by: disk.MadeBy) -> disk.Certificate:
    """What is certified of an asset that stands in `staged` and has passed."""
    hulls = [len(c.shape.mesh.vertices) for k in asset.links for c in k.colliders if isinstance(c.shape, Hull)]
    x, y, z = (significant(v, 6) for v in np.ptp(asset.bounds, axis=0))
    return disk.Certificate(
        asset_digest=asset.digest,
        producer=made_by.producer,
        cache_key=made_by.cache_key,
        versions=made_by.versions,
        report=report,
        summary=disk.Summary(
            extents=(x, y, z),
            mass=significant(asset.mass, 6),
            colliders=sum(len(k.colliders) for k in asset.links),
            hull_vertices=max(hulls, default=0),
            faces=sum(len(v.mesh.faces) for k in asset.links for v in k.visuals),
        ),
        files=disk.file_digests(staged),
        signature=signature(asset),
    )


def _picture(bundle: Bundle, staged: Path, limits: Mapping[str, float]) -> bytes | None:
    """Of the rejected asset where it was drawn already, of the raw mesh where that can be read, else None."""
    drawn = staged / "preview.png"
    if drawn.exists():
        return drawn.read_bytes()
    try:
        return render_model(read_raw_model(bundle, limits))
    except CasaError:
        return None
