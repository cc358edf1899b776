"""Make a finished entry in the staging folder from the bytes of one input; runs in a separate child process."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from casa_assets import registry
from casa_assets.cache.cache_key import versions_of
from casa_assets.cache.store import Store
from casa_assets.checks import simready
from casa_assets.checks.run import load_table
from casa_assets.errors import CasaError, OutputError, PluginFailure, RegistryError, Rejected
from casa_assets.formats.read import warm as warm_readers
from casa_assets.ingest.load import load
from casa_assets.ingest.run.job import Job, stage_refusal
from casa_assets.ingest.run.stages import build_asset, stage_functions
from casa_assets.ingest.sources.bundle import collect
from casa_assets.library import library as disk
from casa_assets.library.identity import Producer
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Report
from casa_assets.model.registry.category import Category
from casa_assets.model.source import Bundle
from casa_assets.runs.asset_package import WRITING, certify, check_package, write_package
from casa_assets.runs.outcome import Outcome, RunAborted, first_error, keep_trace, writing
from casa_assets.show.stills.renderer import NoRenderer, backend
from casa_assets.show.stills.still import render_model

# With less room no renderer can be loaded, whatever it then says is missing; a choice.
RENDERER_BYTES = 64_000_000

# What a thing on the wrong side fails: it tips over, wanders, or its shapes do not fit.
POSE_CODES = frozenset({"AST009", "FLT015", "FLT016"})
# Ways up that are tried for one input; a choice.
MAX_POSES = 3


def warm() -> None:
    """Load what every worker needs, once for all of them; nothing here may draw."""
    registry.load()
    simready.warm()
    load_table()
    warm_readers()


def check_renderer(_: None) -> RunAborted | None:
    """Check in a worker that it can draw; a process that has drawn cannot be forked, so the server never tries."""
    try:
        backend()
    except NoRenderer as error:
        bytearray(RENDERER_BYTES)  # raises MemoryError where the limit of memory keeps the renderer from being loaded
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
        # The input is read a second time. The survey had to read all inputs before the first can be worked on: their
        # digests settle ids, inputs of the same bytes, what a person decided and what an earlier run made. Their bytes
        # (up to --max-size each) cannot be held until then, and a copy on disk would have to be read again too.
        bundle = collect(job.found, job.limits)
        if bundle.sha256 != job.survey.sha256:
            raise Rejected("RUN005", "the file changed while it was being read; run again")
        asset, report = _built(job, bundle, category, library)
        if not report.passed:
            raise first_error(report)
        made_by = disk.MadeBy(Producer.INGEST, job.cache_key, versions_of({**stage_functions(), **WRITING}))
        certify(asset, report, staged, made_by)
        return Outcome(True, warnings=report.issues, staged=staged)
    except PluginFailure as error:
        told = Rejected("RUN009", f"{error}; the trace: {keep_trace(error, library)}")
        return Outcome(False, told.code, told.message, staged=stage_refusal(library, job, told, report))
    except Rejected as error:
        picture = None if bundle is None else _picture(bundle, staged, job.limits)
        refused = stage_refusal(library, job, error, report, picture)
        return Outcome(False, error.code, error.message, staged=refused)


def _built(job: Job, bundle: Bundle, category: Category, library: disk.Library) -> tuple[Asset, Report]:
    """The asset, written to the staging folder, and its report.

    Where it falls over or its shapes do not fit it may lie on the wrong side: it is built again with other ways up,
    unless a person said which way is up. Where none of them is better, the first stays.
    """
    failed_ups: tuple[str, ...] = ()
    first: tuple[Asset, Report] | None = None
    while True:
        staged = library.stage(job.asset_id)
        asset, notes = build_asset(
            bundle,
            job.survey,
            job.found.source,
            job.asset_id,
            job.limits,
            job.override,
            Store(library.cache),
            failed_ups,
        )
        write_package(asset, staged)
        report = check_package(asset, staged, category, notes)
        first = first or (asset, report)
        if report.passed:
            return asset, report
        is_doubtful = job.override.up is None and all(issue.code in POSE_CODES for issue in report.errors)
        if not is_doubtful or len(failed_ups) == MAX_POSES - 1:
            break
        failed_ups += tuple(g.value for g in asset.provenance.guesses if g.subject == "up_axis")
    if failed_ups:
        write_package(first[0], library.stage(job.asset_id))
    return first


def _picture(bundle: Bundle, staged: Path, limits: Mapping[str, float]) -> bytes | None:
    """Return a picture of a rejected asset, or of the raw mesh if it has none yet; None if neither can be drawn."""
    drawn = staged / "preview.png"
    if drawn.exists():
        return drawn.read_bytes()
    try:
        return render_model(load(bundle, limits))
    except CasaError:
        return None
