"""The inputs of a run: how they are found, what each of them is, and what is asked of the workers about them."""

from __future__ import annotations

import hashlib
import os
import shutil
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol

from casa_assets import registry
from casa_assets.cache.cache_key import digest_of, key_of
from casa_assets.core.system import cache_for, keep_json, kept_json, process_name, require
from casa_assets.errors import CasaError, PluginFailure, Rejected
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found, Refused, StoreRoot, folder_of, is_url, root_of, utf8_escaped
from casa_assets.ingest.sources.stores import state_at
from casa_assets.library.entry_files import Producer, Refusal
from casa_assets.library.library import Library
from casa_assets.library.review import DOUBTFUL
from casa_assets.model.issue import Report
from casa_assets.model.registry.category import Category
from casa_assets.model.source import NO_OVERRIDE, Source, SourceKind, Up, UserOverride
from casa_assets.registry.plugins.load import guarded, sources
from casa_assets.runs.limits import WorkerFailure
from casa_assets.runs.outcome import FAILURE_CODES, Outcome, RunAborted, keep_trace
from casa_assets.runs.pool import Engine

if TYPE_CHECKING:
    from casa_assets.mesh.trimesh_exchange import MeshOrScene

# Plugin sources -------------------------------------------------------------------------------------------------------

FETCHED = "fetched"  # folder in the cache
FAILED = "RUN009"


def roots_of(words: Sequence[str | Path], library: Path) -> tuple[list[Path | StoreRoot], tuple[Refused, ...]]:
    """Paths, addresses, folders that plug-ins fetched; and addresses where one failed: the library keeps its trace."""
    every = [
        word if isinstance(word, Path) else fetch(word, library) if is_of_plugin(word) else root_of(word)
        for word in words
    ]
    refused = tuple(one for one in every if isinstance(one, Refused))
    return [one for one in every if not isinstance(one, Refused)], refused


def is_of_plugin(address: str) -> bool:
    """Return whether an address has a scheme of a plug-in. An existing path is no such address."""
    scheme, colon, _ = address.partition(":")
    return bool(colon) and scheme in sources() and not Path(address).exists()


def fetch(address: str, library: Path) -> Path | Refused:
    """The folder with the files at a plug-in's address, kept from a run of the same code, or a rejected input."""
    plugin, source = sources()[address.partition(":")[0]]
    key = hashlib.sha256(f"{address}\0{plugin.digest}".encode()).hexdigest()[:16]
    folder = cache_for(library) / FETCHED / key  # not in the library: what lies there is output, not input
    if folder.is_dir():
        return folder
    draft = folder.with_name(f"{key}.{process_name()}.part")
    shutil.rmtree(draft, ignore_errors=True)
    draft.mkdir(parents=True)
    try:
        guarded(plugin, f"source {source.scheme}", source.fetch)(address, draft)
    except PluginFailure as error:
        shutil.rmtree(draft)
        return Refused(address, FAILED, f"{error}; the trace: {keep_trace(error, Library(library))}")
    try:
        draft.rename(folder)
    except OSError:
        # Another run has fetched the same meanwhile.
        if not folder.is_dir():
            raise
        shutil.rmtree(draft)
    return folder


# Discover inputs ------------------------------------------------------------------------------------------------------

# Names of library/library_report.py and library/attribution.py: every library has both. By value, as another
# report changes nothing about what is found.
LIBRARY_FILES = ("library.json", "ATTRIBUTION.md")


def discover_inputs(
    roots: Sequence[Path | StoreRoot], library: Path, others: Counter[str] | None = None
) -> Iterator[Found | Refused]:
    """Inputs under the roots, files and folders, on the disk or on stores, in an order that no machine changes.

    `others`: counts what is no mesh, by what it is. What lies in a library, ours or another, is output, not input.
    Raises CasaError: there is nothing at an address, or its store cannot be reached, or no package reads it.
    """
    if any(isinstance(root, StoreRoot) for root in roots):
        require("fsspec", "stores", "Reading from a store")
    own_library = Path(os.path.realpath(library))
    real_roots = {Path(os.path.realpath(root)) for root in roots if isinstance(root, Path)}
    named_files = {root for root in real_roots if root.is_file()}
    # A manifest lists files beside it or below.
    real_roots |= {root.parent for root in named_files if root.suffix.lower() in (".json", ".jsonl")}
    is_output: dict[str, bool] = {}
    for found in discover(roots, others):
        if isinstance(found, Found):
            places = [found.root / (found.archive or found.main)]
        else:
            places = [root / found.path for root in roots]
        if not any(
            _is_output(place, real_roots, named_files, own_library, is_output)
            if isinstance(place, Path)
            else _is_in_library(place.parent, is_output)
            for place in places
        ):
            yield replace(found, source=_as_text(found.source)) if isinstance(found, Found) else found


def _as_text(source: Source) -> Source:
    """The source's words as text that every file can hold."""
    # That all of it is ASCII, as nearly always, is found at once.
    if "".join(["".join(value) for value in vars(source).values()]).isascii():
        return source
    texts: dict[str, Any] = {
        name: tuple(map(utf8_escaped, value)) if isinstance(value, tuple) else utf8_escaped(value)
        for name, value in source
        if isinstance(value, str | tuple) and name != "kind"
    }
    is_unchanged = all(getattr(source, name) == value for name, value in texts.items())
    return source if is_unchanged else source.replace(**texts)


def _is_output(
    place: Path, real_roots: Set[Path], named_files: Set[Path], own_library: Path, is_output: dict[str, bool]
) -> bool:
    """True if a file is in our library, or in one below a root; `is_output`: takes up what is known of folders."""
    # Path would take longer than all the rest, and the real path of a folder is looked for once, not for each file.
    file = str(place)
    if named_files and (named := Path(os.path.realpath(file))) in named_files:
        return own_library in named.parents  # the user asked for it, whatever stands above it
    folder = os.path.dirname(os.path.realpath(file) if os.path.islink(file) else file)  # noqa: PTH114, PTH120
    if folder not in is_output:
        is_output[folder] = _is_output_folder(Path(os.path.realpath(folder)), real_roots, own_library)
    return is_output[folder]


def _is_in_library(folder: StoreRoot, is_output: dict[str, bool]) -> bool:
    """True for a folder in a library on a store, below the folder that the user named; `is_output`: by address."""
    if not folder.path:
        return False  # the user asked for what is in there
    if (address := str(folder)) not in is_output:
        files = folder_of(folder)
        is_library = all(files.has(name) for name in LIBRARY_FILES)
        is_output[address] = is_library or _is_in_library(folder.parent, is_output)
    return is_output[address]


def _is_output_folder(place: Path, real_roots: Set[Path], own_library: Path) -> bool:
    for folder in (place, *place.parents):
        if folder == own_library:
            return True
        if folder in real_roots:
            # Above it only our own library counts: the user asked for what is in there.
            return own_library in folder.parents
        if (folder / ".casa" / "lock").is_file():
            return True
    return False


# Axis of a mesh that points up; empty: what its metadata say, else it is guessed.
UpAxis = Literal["", "x", "y", "z"]
MESHES = "meshes"  # folder of the models that `stage_meshes` writes, within the staging folder


@dataclass(frozen=True)
class MeshInput:
    """A mesh in memory for `Library.ingest`, with its category, such as `mug`, and the axis that points up."""

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
        yield Found(folder, f"{number}.json", source_of_mesh(name, one.category), is_model=True)


def source_of_mesh(name: str, category: str = "") -> Source:
    """The source of a mesh in memory."""
    return Source(kind=SourceKind.FOLDER, path=name, category=category, hints=(name,))


# Survey ---------------------------------------------------------------------------------------------------------------

# Confidence in a category that the source itself states; of 98 such in data for developing none was wrong.
SAID_CONFIDENCE = 0.98
# Largest confidence in a category from a name if the source states another one, so that a person looks at it.
CONTRADICTED_CONFIDENCE = 0.4


@dataclass(frozen=True)
class Survey:
    """Digest and category of an input, confidence, 0..1, and reason; files and folders behind it, with `state_of`."""

    sha256: str
    category: str
    confidence: float
    reason: str
    looked_at: tuple[tuple[str, str], ...] = ()


def state_of(path: str) -> str:
    """State of a file, folder or object on a store, which changes whenever it is written; empty if there is none."""
    if is_url(path):
        return state_at(path)
    try:
        found = os.stat(path)  # noqa: PTH116  Path would take longer than the system does
    except (OSError, ValueError):
        return ""
    return f"{found.st_mtime_ns} {found.st_ctime_ns} {found.st_size} {found.st_ino}"


def warm_survey() -> None:
    """Load what every survey needs, once for all workers."""
    registry.load()


def survey(job: tuple[Found, str, Mapping[str, float]]) -> Survey | Rejected:
    """Survey of an input. The job is the input, the category that the user requested or nothing, and the limits."""
    found, requested, limits = job
    looked_at: set[str] = set()
    try:
        bundle = collect(found, limits, looked_at)
    except Rejected as error:
        return error
    category, confidence, reason = find_category(found, requested)
    states = tuple((path, state_of(path)) for path in sorted(looked_at))
    return Survey(bundle.sha256, category.id, confidence, reason, states)


def find_category(found: Found, requested: str) -> tuple[Category, float, str]:
    """Category of an input, confidence and reason: by the user, else by the source, else by names and titles."""
    known = registry.load()
    if requested:
        return known.category(requested), 1.0, "given on the command line"
    source = found.source
    if source.node:  # The name and title of the file speak of all things in it together.
        if (named := known.find_category([source.node])) is not None:
            return named
        return known.category(registry.FALLBACK), 0.1, f"{source.node!r} names no category that the registry knows"
    if source.category:
        match = known.find_category([source.category])
        if match is not None:
            return match[0], max(SAID_CONFIDENCE, match[1]), f"the source says {source.category!r}"
    match = known.find_category([*source.hints, source.title, source.prompt])
    if match is None:
        return known.category(registry.FALLBACK), 0.1, "nothing names a category that the registry knows"
    if source.category:
        reason = f"{match[2]}; the source says {source.category!r}, which the registry does not know"
        return match[0], min(CONTRADICTED_CONFIDENCE, match[1]), reason
    return match


@dataclass(frozen=True)
class HeldThings:
    """Names of the things that an input holds, and the digest of its files."""

    sha256: str
    names: tuple[str, ...]


def things_held(job: tuple[Found, Mapping[str, float]]) -> HeldThings | None:
    """The separate objects of an input, or None: it cannot be read, which its survey reports, or it is one object.

    The boards of a shelf and the legs of a table are not separate objects.
    """
    # Here, since most runs take nothing apart, and this loads slowly.
    from casa_assets.ingest.things import MAX_THINGS, guess_of_things, load, things_of

    found, limits = job
    known = registry.load()
    try:
        bundle = collect(found, limits)
        model = load(bundle, limits)
        category, _, _ = find_category(found, "")
        guess = guess_of_things(model, found.source, category, known.vocabulary, known.other_things)
        if guess is None or guess.confidence >= DOUBTFUL:
            return None
        taken = things_of(model)[:MAX_THINGS]
    except Rejected:
        return None
    return HeldThings(bundle.sha256, tuple(thing.name for thing in taken)) if len(taken) > 1 else None


def taken_apart(found: Sequence[Found], held: Mapping[int, HeldThings]) -> tuple[list[Found], list[str]]:
    """The inputs with the things of a file in its place, by number of input, and the digests of files taken apart."""
    out: list[Found] = []
    digests: list[str] = []
    for number, one in enumerate(found):
        if (answer := held.get(number)) is None:
            out.append(one)
            continue
        digests.append(answer.sha256)
        out += [replace(one, source=one.source.replace(node=name)) for name in answer.names]
    return out, digests


SurveyAnswer = Survey | Rejected | WorkerFailure


# Survey table ---------------------------------------------------------------------------------------------------------
# What earlier runs found out about inputs whose files have not changed since, so that they are not read again. It lies
# in the cache of the library, and deleting it costs time and nothing else.
SURVEYS = "surveys"
# A file that is younger than this when it is read may change again without a trace in its times, which come in steps.
MIN_AGE_NS = 50_000_000


class SurveyTable:
    """Surveys by input, in the cache folder; `requested`: category of all, or empty; the limit on bytes counts too."""

    def __init__(self, cache: Path, requested: str, limits: Mapping[str, float], read_only: bool = False) -> None:
        self._path, self._read_only = cache / SURVEYS, read_only
        self._made_by = key_of(survey)
        self._requested, self._limits = requested, limits
        self._said = f"{requested}\0{limits['input_bytes']}"
        kept = kept_json(self._path)
        is_ours = isinstance(kept, dict) and kept.get("made_by") == self._made_by
        self._kept: dict[str, Any] = kept["surveys"] if is_ours else {}

    def survey(self, inputs: Sequence[Found], pool: Engine) -> Iterator[tuple[int, SurveyAnswer]]:
        """Yield number and survey of every input, the known ones first; workers read what is new, which is kept."""
        new: list[int] = []
        for number, one in enumerate(inputs):
            if (known := self.find(one)) is not None:
                yield number, known
            else:
                new.append(number)
        fresh: list[tuple[Found, Survey]] = []
        jobs = [(inputs[number], self._requested, self._limits) for number in new]
        for place, answer in pool.run(survey, jobs):
            if isinstance(answer, Survey):
                fresh.append((inputs[new[place]], answer))
            yield new[place], answer
        self.keep(fresh)

    def find(self, found: Found) -> Survey | None:
        """Return the survey of an earlier run if no file has changed since, or None otherwise."""
        known = self._kept.get(self._key(found))
        if known is None or found.is_model:
            return None
        try:
            sha256, category, confidence, reason, looked_at = known
            if all(state_of(path) == state for path, state in looked_at):
                return Survey(sha256, category, confidence, reason)
        except (ValueError, TypeError):
            pass  # not what was written there: it is read again
        return None

    def keep(self, surveys: Iterable[tuple[Found, Survey]]) -> None:
        """Keep what was found out now, but for files that are so young that they may still change unseen."""
        newest = time.time_ns() - MIN_AGE_NS
        fresh = {
            self._key(found): (one.sha256, one.category, one.confidence, one.reason, one.looked_at)
            for found, one in surveys
            if not found.is_model and all(_is_settled(state, newest) for _, state in one.looked_at)
        }
        if fresh and not self._read_only:
            keep_json(self._path, {"made_by": self._made_by, "surveys": {**self._kept, **fresh}})

    def _key(self, found: Found) -> str:
        """Key of an input: its place, and what its source says of it."""
        notes = [note.to_json() for note in found.notes]
        said = f"{self._said}\0{found.root}\0{found.archive}\0{found.main}\0{found.source.to_json()}\0{notes}"
        return hashlib.sha256(said.encode("utf-8", "surrogateescape")).hexdigest()


def _is_settled(state: str, newest_ns: int) -> bool:
    """True if any later change would change a state: the last was before a time, ns since 1970, or a store says so."""
    return not state or state.startswith("store ") or (state != "?" and int(state.split()[1]) < newest_ns)


# Jobs and results -----------------------------------------------------------------------------------------------------

# Limits that turn inputs away and change nothing about those that pass: raising one remakes nothing.
ADMISSION_LIMITS = frozenset({"input_bytes", "input_faces", "input_seconds", "input_memory_bytes"})


@dataclass(frozen=True)
class Job:
    """One input to be worked on, once its id is known; with the limits and the cache key of this run for it."""

    found: Found
    survey: Survey
    asset_id: str
    library: Path
    limits: Mapping[str, float]
    cache_key: str
    override: UserOverride = NO_OVERRIDE


@dataclass(frozen=True)
class Result:
    """State of one input before its entry is published.

    `number`: its place among the inputs of the run that could be read. `job`: the input. `outcome`: the verdict of a
    worker, or of an earlier run. `folder`: of an accepted asset: in the staging folder, or, if it was kept, in the
    library. `is_kept`: the library holds this outcome already. `twin`: folder, relative to the library, of the asset
    that it is a copy of; empty if it is no copy.
    """

    number: int
    job: Job
    outcome: Outcome
    folder: Path | None = None
    is_kept: bool = False
    twin: str = ""


def stage_refusal(
    library: Library,
    job: Job,
    error: Rejected,
    report: Report | None = None,
    picture: bytes | None = None,
    twin: str = "",
) -> Path:
    """The staged entry of a rejected input; `picture`: PNG of it. `twin`: folder of the asset that it is a copy of."""
    refusal = Refusal(
        id=job.asset_id,
        code=error.code,
        message=error.message,
        category=job.survey.category,
        producer=Producer.INGEST,
        cache_key=job.cache_key,
        sha256=job.survey.sha256,
        source=job.found.source,
        report=report,
        twin=twin,
    )
    return library.stage_refusal(refusal, picture or b"")


def limits_in_key(limits: Mapping[str, float]) -> dict[str, float]:
    """Limits that change what comes out, sorted."""
    return {name: value for name, value in sorted(limits.items()) if name not in ADMISSION_LIMITS}


def with_overrides(key: str, override: UserOverride) -> str:
    """Return the cache key of an input with a person's decisions: a changed decision makes the result again."""
    return key if override.is_empty else digest_of(key, override.digest)


# Answers --------------------------------------------------------------------------------------------------------------
# What a run asks about its inputs: what they hold, what they are, what becomes of them.

# By name: the module loads renderer and validator, half a second and 100 MB that only workers need.
WARM, CHECK_RENDERER = "casa_assets.ingest.run.steps:warm", "casa_assets.ingest.run.steps:check_renderer"
WORK = "casa_assets.ingest.run.steps:work"


class Answers(Protocol):
    """Answers the questions of a run, each about all of its inputs at once, in this order."""

    def things(self, found: Sequence[Found]) -> Mapping[int, HeldThings]:
        """The things that files hold by the number of the input; asked only by a run that takes files apart."""

    def surveys(self, found: Sequence[Found]) -> Iterator[tuple[int, SurveyAnswer]]:
        """Yield the number of an input and what it is, in any order."""

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Outcome]]:
        """Yield the number of a job and what became of it, in any order."""


@dataclass(frozen=True)
class WorkerAnswers:
    """Answers of workers, which read inputs and build assets; `show_work` is called with each path that is begun."""

    pool: Engine
    table: SurveyTable
    limits: Mapping[str, float]
    show_work: Callable[[str], None] | None = None

    def things(self, found: Sequence[Found]) -> dict[int, HeldThings]:
        """See Answers. A file that cannot be read holds none; its survey reports the error."""
        answers = self.pool.run(things_held, [(one, self.limits) for one in found])
        return {number: answer for number, answer in answers if isinstance(answer, HeldThings)}

    def surveys(self, found: Sequence[Found]) -> Iterator[tuple[int, SurveyAnswer]]:
        """See Answers."""
        return self.table.survey(found, self.pool)

    def outcomes(self, jobs: Sequence[Job]) -> Iterator[tuple[int, Outcome]]:
        """See Answers. Raises CasaError where this machine cannot draw."""
        self.pool.prepare(WARM)
        for _, answer in self.pool.run(CHECK_RENDERER, [None]):
            _outcome(answer)

        def started(place: int) -> None:
            if self.show_work is not None:
                self.show_work(jobs[place].found.source.place)

        for place, answer in self.pool.run(WORK, jobs, started):
            yield place, _outcome(answer)


def _outcome(answer: object) -> Outcome:
    """The outcome that a worker gives or leaves behind. Raises CasaError where the machine is at fault."""
    if isinstance(answer, RunAborted):
        raise CasaError(answer.message)
    if isinstance(answer, WorkerFailure):
        return Outcome(False, FAILURE_CODES[answer.reason], answer.message, trace=answer.trace)
    if not isinstance(answer, Outcome):
        return Outcome(False, FAILURE_CODES["error"], f"a worker answered with {type(answer).__name__}")
    return answer
