"""The stages of ingest in order, and the work on one input in a child process: build, write, check, certify."""

from __future__ import annotations

import posixpath
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casa_assets import registry
from casa_assets.cache.cache_key import digest_of, key_of, versions_of
from casa_assets.cache.store import Store
from casa_assets.checks import simready
from casa_assets.checks.check import load_table
from casa_assets.errors import CasaError, OutputError, PluginFailure, RegistryError, Rejected
from casa_assets.formats.read.formats import warm as warm_readers
from casa_assets.ingest.clean import clean
from casa_assets.ingest.collision.collide import collide
from casa_assets.ingest.collision.fit import CollideParams
from casa_assets.ingest.draft import Draft, assemble, grasp
from casa_assets.ingest.mass import mass
from casa_assets.ingest.orient import orient
from casa_assets.ingest.run.inputs import Job, Survey, find_category, limits_in_key, source_of_mesh, stage_refusal
from casa_assets.ingest.scale import scale
from casa_assets.ingest.sources.discover import collect
from casa_assets.ingest.sources.places import Found
from casa_assets.ingest.texture import add_back_faces, simplify, texture
from casa_assets.ingest.things import guess_of_things, load
from casa_assets.library.entry_files import MadeBy, Producer
from casa_assets.library.library import Library
from casa_assets.library.review import NAME, REJECTED_CODE, doubtful_guesses
from casa_assets.model.asset.asset import Asset, Guess
from casa_assets.model.asset.material import Substance
from casa_assets.model.issue import ASKED_CODE, REVIEW_CODE, Issue, Report
from casa_assets.model.record import Record
from casa_assets.model.registry.category import Category
from casa_assets.model.source import NO_OVERRIDE, Bundle, RawModel, Source, SourceKind, Up, UserOverride, Word
from casa_assets.runs.asset_package import WRITING, certify, check_package, write_package
from casa_assets.runs.outcome import Outcome, RunAborted, first_error, keep_trace, writing
from casa_assets.show.stills.opengl import NoRenderer, backend
from casa_assets.show.stills.still import render_model

if TYPE_CHECKING:
    from casa_assets.mesh.trimesh_exchange import MeshOrScene


class BuildContext(Record):
    """Inputs of the stages besides the bytes of the bundle.

    `asset_id`: name of the result. `sha256`: of the bundle. `limits`: numbers of registry/limits.yaml. `override`: a
    person's decisions. `failed_ups`: ways up in which it was built before and failed. `kind`: guess of the category.
    """

    asset_id: str
    sha256: str
    source: Source
    category: Category
    classes: tuple[str, ...]
    substance: Substance
    limits: dict[str, float]
    override: UserOverride = NO_OVERRIDE
    failed_ups: tuple[str, ...] = ()
    kind: Guess | None = None

    @property
    def generated(self) -> bool:
        """True if a text-to-3D generator made it."""
        return self.source.kind is SourceKind.TEXT_TO_3D


@dataclass(frozen=True)
class Stage:
    """A pure function of the result before it and the context; `keep`: the result, a Draft, is put into the store."""

    name: str
    function: Callable[[Any, BuildContext], Any]
    keep: bool = False


# Ratio up to which two estimates of a mass say the same; a choice.
MASS_AGREEMENT_RATIO = 2.0


def _load(bundle: Bundle, context: BuildContext) -> RawModel:
    return load(bundle, context.limits)


def _clean(model: RawModel, context: BuildContext) -> Draft:
    known = registry.load()
    # What is cleaned away, such as a ground under several things, says whether it is one thing: that is asked first.
    guess = guess_of_things(model, context.source, context.category, known.vocabulary, known.other_things)
    draft = clean(model, context.category)
    first = tuple(one for one in (context.kind, guess) if one is not None)
    return draft.replace(guesses=(*first, *draft.guesses))


def _orient(draft: Draft, context: BuildContext) -> Draft:
    return orient(draft, context.category, context.generated, context.override, context.failed_ups)


def _scale(draft: Draft, context: BuildContext) -> Draft:
    said = context.source
    # The title and prompt of a file that was taken apart say no size of one thing in it.
    texts = [t for t in (said.title, said.prompt) if t and not said.node]
    slack = context.limits["size_slack"]
    return scale(draft, context.category, slack, texts, context.generated, context.override.size_m)


def _simplify(draft: Draft, context: BuildContext) -> Draft:
    return simplify(draft, int(context.limits["visual_faces"]))


def _texture(draft: Draft, context: BuildContext) -> Draft:
    return texture(draft, int(context.limits["texture_px"]), context.substance)


def _collide(draft: Draft, context: BuildContext) -> Draft:
    params = CollideParams(**{name: context.limits[name] for name in CollideParams.model_fields})
    return collide(draft, context.category, params)


def _mass(draft: Draft, context: BuildContext) -> Draft:
    return mass(draft, context.category, context.substance, MASS_AGREEMENT_RATIO, context.override.mass_kg)


def _grasp(draft: Draft, context: BuildContext) -> Draft:
    return grasp(draft, context.category, context.limits["gripper_m"])


def _backs(draft: Draft, context: BuildContext) -> Draft:
    return add_back_faces(draft, context.category, context.limits["missing_side"])


def _assemble(draft: Draft, context: BuildContext) -> tuple[Asset, tuple[Issue, ...]]:
    category, substance, sha256 = context.category, context.substance, context.sha256
    asset = assemble(draft, context.asset_id, category, context.classes, substance, context.source, sha256)
    return asset, draft.notes


# In the order in which they run: from a Bundle to an Asset and the notes on the way.
STAGES: tuple[Stage, ...] = (
    Stage("load", _load),
    Stage("clean", _clean),
    Stage("orient", _orient),
    Stage("scale", _scale),
    Stage("simplify", _simplify),
    Stage("texture", _texture),
    Stage("collide", _collide, keep=True),
    Stage("mass", _mass),
    Stage("grasp", _grasp),
    Stage("backs", _backs),
    Stage("assemble", _assemble),
)


def stage_key(stage: Stage) -> str:
    """Key of the code of a stage: what it, and nothing that only other stages do, can reach."""
    return key_of(stage.function)


def run_stages(bundle: Bundle, context: BuildContext, store: Store | None = None) -> tuple[Asset, tuple[Issue, ...]]:
    """An asset from a bundle, and the warnings on the way; `store`: keeps results of stages. Raises Rejected."""
    keys, start = _keys(context), 0
    result: Any = bundle
    for i in reversed(range(len(STAGES))):
        if store is not None and STAGES[i].keep and (data := store.get(keys[i])) is not None:
            start, result = i + 1, Draft.from_json(data)
            break
    for stage, key in zip(STAGES[start:], keys[start:], strict=True):
        result = stage.function(result, context)
        if store is not None and stage.keep:
            store.put(key, result.to_json().encode())
    asset, notes = result
    return asset, (*bundle.notes, *notes)


def build_asset(
    bundle: Bundle,
    survey: Survey,
    source: Source,
    asset_id: str,
    limits: Mapping[str, float],
    override: UserOverride = NO_OVERRIDE,
    store: Store | None = None,
    failed_ups: tuple[str, ...] = (),
) -> tuple[Asset, tuple[Issue, ...]]:
    """Build an asset from a surveyed bundle; return it with warnings, including doubtful guesses.

    `store`: keeps results of stages. `failed_ups`: ways up, as in the asset's guesses of `up_axis`, that failed before.
    Raises Rejected: a stage cannot accept its input.
    """
    if override.decision is Word.REJECT:
        raise Rejected(REJECTED_CODE, f"a person rejected it, in {NAME} of the library")
    known = registry.load()
    category = known.category(survey.category)
    context = BuildContext(
        asset_id=asset_id,
        sha256=bundle.sha256,
        source=source,
        kind=Guess(subject="category", value=category.id, confidence=round(survey.confidence, 2), reason=survey.reason),
        category=category,
        classes=known.classes_of(category),
        substance=known.substances[category.substance],
        limits=dict(limits),
        override=override,
        failed_ups=failed_ups,
    )
    asset, notes = run_stages(bundle, context, store)
    if override.decision is Word.ACCEPT:
        return asset, tuple(note for note in notes if note.code not in (ASKED_CODE, REVIEW_CODE))
    return asset, (*notes, *doubtful_guesses(asset.provenance.guesses))


def _keys(context: BuildContext) -> list[str]:
    """Key of each stage's result: everything that came before is in it."""
    said = context.source
    # Of the path only the name says something of the thing: an input that was moved is not made again.
    name = posixpath.basename(said.path)
    source = Source(kind=said.kind, path=name, title=said.title, prompt=said.prompt, node=said.node)
    key = context.replace(asset_id="", source=source, limits=limits_in_key(context.limits)).digest
    keys = []
    for stage in STAGES:
        key = digest_of(key, stage.name, stage_key(stage))
        keys.append(key)
    return keys


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
    library = Library(job.library)
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
        stages = {stage.name: stage.function for stage in STAGES}
        made_by = MadeBy(Producer.INGEST, job.cache_key, versions_of({**stages, **WRITING}))
        certify(asset, report, staged, made_by)
        return Outcome(True, warnings=report.issues, staged=staged)
    except PluginFailure as error:
        failed = Rejected("RUN009", f"{error}; the trace: {keep_trace(error, library)}")
        return Outcome(False, failed.code, failed.message, staged=stage_refusal(library, job, failed, report))
    except Rejected as error:
        picture = None if bundle is None else _picture(bundle, staged, job.limits)
        refused = stage_refusal(library, job, error, report, picture)
        return Outcome(False, error.code, error.message, staged=refused)


def _built(job: Job, bundle: Bundle, category: Category, library: Library) -> tuple[Asset, Report]:
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


def ingest_mesh(mesh: MeshOrScene, name: str, category: str = "", up: Up | None = None) -> tuple[Asset, Report]:
    """The asset of a mesh or scene, and the report of every check, errors too."""
    from casa_assets.formats.read.from_trimesh import bundle_from_trimesh  # imports trimesh: half a second

    source = source_of_mesh(name)
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
