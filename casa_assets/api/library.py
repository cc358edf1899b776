"""Meshes into assets: one at a time in memory, or many into a library on disk."""

from __future__ import annotations

import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from casa_assets.errors import CasaError, OutputError, Rejected, UnknownId
from casa_assets.geometry.mesh.trimesh_exchange import MeshOrScene
from casa_assets.ingest.sources.places import StoreRoot
from casa_assets.model.asset.asset import Asset
from casa_assets.model.ingest.source import Up
from casa_assets.model.issue import Decision, Issue, Report, subjects_to_decide
from casa_assets.pipeline.dedup.search import SearchHit, search_by_words
from casa_assets.pipeline.ingest.answers import FAILURE_CODES
from casa_assets.pipeline.ingest.in_memory import MeshInput, UpAxis, ingest_mesh
from casa_assets.pipeline.ingest.job import Event, first_error
from casa_assets.pipeline.ingest.plugin_sources import roots_of
from casa_assets.pipeline.ingest.run import Options
from casa_assets.pipeline.ingest.run import ingest as run_ingest
from casa_assets.pipeline.library import library as disk
from casa_assets.pipeline.library.entry_table import EntryTable
from casa_assets.pipeline.reports.entry import Entry, entries

if TYPE_CHECKING:
    from casa_assets.pipeline.articulate.run import ArticulateOutcome

# What `Library.ingest` takes.
Input = str | Path | MeshOrScene | MeshInput


@dataclass(frozen=True)
class Rejection:
    """Reason of a rejection: a code (see docs/reference/checks.md) and one sentence."""

    code: str
    message: str


@dataclass(frozen=True)
class IngestResult:
    """Outcome of one input of `Library.ingest`.

    Attributes:
        source: path of the input as its source calls it, or the name of a mesh in memory.
        status: `accepted`: there is a new asset. `review`: there is one, and `Library.in_review` says what a person
            has to decide about it. `skipped`: an earlier run made the asset of the same bytes, and it stays as it is.
            `rejected`: no asset can be made of it, now or in an earlier run. `failed`: the work on it
            ended without a verdict (its limits on time or memory, a crash); the next run tries again.
        asset_id: None where it was rejected or failed.
        folder: of the asset, or of what is kept of the rejected input; None for inputs without a mesh, such as a
            broken row of a manifest.
        reasons: why it was rejected or failed, the first one decided; empty where there is an asset.
        warnings: faults that do not keep an asset out.
        count: inputs that it stands for; more than 1 for rows of a manifest that are broken in the same way.
    """

    source: str
    status: Literal["accepted", "review", "skipped", "rejected", "failed"]
    asset_id: str | None = None
    folder: Path | None = None
    reasons: tuple[Rejection, ...] = ()
    warnings: tuple[Issue, ...] = ()
    count: int = 1


@dataclass(frozen=True)
class Ingested:
    """Outcome of ingesting one mesh.

    Attributes:
        source: path of the input. asset: accepted or in review; None where it was rejected.
        rejection: None where it was accepted. warnings: faults that do not keep it out.
        report: every check, with its number or why it has none; None where it was rejected before the checks.
        folder: of the entry in the library; None where no library was named.
    """

    source: str
    asset: Asset | None
    rejection: Rejection | None
    warnings: tuple[Issue, ...] = ()
    report: Report | None = None
    folder: Path | None = None

    @property
    def to_decide(self) -> tuple[str, ...]:
        """What was told on thin evidence and a person has to decide, such as `scale` and `mass`."""
        return subjects_to_decide(self.warnings)

    @property
    def accepted(self) -> bool:
        """True if there is an asset and nothing about it is for a person to decide."""
        return self.asset is not None and not self.to_decide


@dataclass(frozen=True)
class Articulated:
    """Outcome of searching one mesh for doors, drawers and controls.

    Attributes:
        source: path of the input. asset: accepted or in review; None where it was rejected.
        rejection: None where there is an asset; ART001 where nothing moves.
        report: every check; None where it was rejected before the checks.
        category, size: what it was taken to be and how large, and why.
        missing: what keeps it from what RoboCasa's fixture class of its kind reads; empty where nothing does.
        folder: of the entry in the library, with `decisions.yaml` in it; None where no library was named.
        reason_kept: why this is the accepted asset that the library had, and not the new result; empty otherwise.
    """

    source: str
    asset: Asset | None
    rejection: Rejection | None
    report: Report | None
    category: str
    size: str
    missing: tuple[str, ...] = ()
    folder: Path | None = None
    reason_kept: str = ""

    @property
    def to_decide(self) -> tuple[str, ...]:
        """What is too uncertain and a person has to decide: `frame`, `plan`, `contacts`; the report says why."""
        return self.report.to_decide if self.asset is not None and self.report is not None else ()

    @property
    def accepted(self) -> bool:
        """True if there is an asset and nothing about it is for a person to decide."""
        return self.asset is not None and not self.to_decide


class Library:
    """A folder of assets, as `casa-assets ingest` writes it; it need not exist before something is ingested.

    Iterating gives the records of its accepted assets, sorted by category and id: id, category, size and mass, guesses,
    results of checks, source. `len` counts them. What a person has to decide about first is told by `in_review`.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._disk = disk.Library(self.path)

    def __repr__(self) -> str:
        """Text such as `<Library out/library>`."""
        return f"<Library {self.path}>"

    def __iter__(self) -> Iterator[Entry]:
        """Records of the accepted assets. Raises OutputError where one is damaged."""
        return (entry for entry in entries(self._disk) if entry.decision is Decision.ACCEPTED)

    def __len__(self) -> int:
        """Number of accepted assets."""
        return sum(entry.decision is Decision.ACCEPTED for entry in EntryTable(self._disk).entries)

    def in_review(self) -> Iterator[Entry]:
        """Records of assets about which a person has to decide something, in review.csv; `to_decide` says what."""
        return (entry for entry in entries(self._disk) if entry.decision is Decision.REVIEW)

    def __contains__(self, asset_id: object) -> bool:
        """True if there is an asset of this id, accepted or in review."""
        return any(folder.name == asset_id for folder in self._disk.accepted())

    def rejected(self) -> Iterator[Entry]:
        """Records of the inputs that were turned away, each with a code and a reason."""
        return (entry for entry in entries(self._disk) if not entry.accepted)

    def folder(self, asset_id: str) -> Path:
        """Folder of an asset, accepted or in review. Raises UnknownId with the nearest ids."""
        found = {folder.name: folder for folder in self._disk.accepted()}
        if asset_id not in found:
            raise UnknownId(f"asset of {self.path}", asset_id, found)
        return found[asset_id]

    def get(self, asset_id: str) -> Asset:
        """An asset, accepted or in review, with meshes and textures. Raises UnknownId, or OutputError where damaged."""
        return disk.read_asset(self.folder(asset_id))

    def search(self, words: str, limit: int = 20) -> list[SearchHit]:
        """Assets whose category, title, path or colours have most of the words, best first."""
        return search_by_words(words, self._disk, limit)

    def ingest(
        self,
        *inputs: Input | Sequence[Input],
        category: str = "",
        name: str = "",
        up: UpAxis = "",
        jobs: int = 0,
        force: bool = False,
    ) -> Iterator[IngestResult]:
        """Bring files, folders, manifests and meshes in memory in; each is read in a process with limits of its own.

        What an earlier run made of the same bytes stays, and so does an accepted asset where the new result would be in
        review or rejected; both are told as `skipped`. Nothing happens before the first result is asked for: write
        `list(library.ingest(...))` where no result is of interest.

        Args:
            inputs: paths; addresses on stores, such as `s3://bucket/meshes`; trimesh.Trimesh or trimesh.Scene;
                MeshInput, a mesh with a name, category and up axis of its own; or lists of these.
            category: id for all of them; else names and sources tell.
            name: of meshes that are not in a MeshInput. Where none is given it is the mesh's own (its metadata), or
                `mesh`; several of one name are numbered.
            up: axis that points up, of meshes that are not in a MeshInput; else their metadata tell, or it is guessed.
            jobs: inputs at once; 0: one per core.
            force: work on all inputs, and replace accepted assets whatever the new result is.
        Yields:
            The result of each input as it is done.
        Raises:
            UnknownId: no such category. OutputError: there is no such file, the library cannot be written to, or
            another run is writing to it. CasaError: this machine cannot make assets.
        """
        words, meshes = _sorted_inputs(inputs, name, up)
        paths, refused = roots_of(words, self.path)
        options = Options(self.path, category, jobs, refused=refused, force=force)
        _check_exist(paths)
        with closing(run_ingest(paths, options, meshes)) as running:
            for event in running:
                yield _result(event)


def _result(event: Event) -> IngestResult:
    """The public record of an event of the pipeline."""
    if not event.was_rejected:
        status: Literal["accepted", "review"] = "review" if event.is_in_review else "accepted"
        return IngestResult(
            event.path,
            "skipped" if event.kind == "kept" else status,
            event.asset_id,
            event.folder,
            warnings=event.warnings,
        )
    reasons: tuple[Rejection, ...] = (Rejection(event.code, event.message),)
    if report := _refusal_report(event.folder):
        reasons += tuple(Rejection(issue.code, issue.message) for issue in report.errors[1:])
    is_failed = event.code in FAILURE_CODES.values()
    return IngestResult(
        event.path, "failed" if is_failed else "rejected", None, event.folder, reasons, count=event.count
    )


def _refusal_report(folder: Path | None) -> Report | None:
    """The report of the checks that a rejected input did not pass; None where it was rejected before the checks."""
    return None if folder is None else disk.read_refusal(folder).report


def _sorted_inputs(
    inputs: Sequence[Input | Sequence[Input]], name: str, up: UpAxis
) -> tuple[list[str | Path], list[MeshInput]]:
    """Paths and addresses, and meshes in memory under names that differ."""
    paths: list[str | Path] = []
    meshes: list[MeshInput] = []
    for item in chain.from_iterable([item] if isinstance(item, Input) else item for item in inputs):
        if isinstance(item, str | Path):
            paths.append(item)
        elif isinstance(item, MeshInput):
            meshes.append(item)
        else:
            meshes.append(MeshInput(item, name or str(item.metadata.get("name") or "mesh"), up=up))
    counts = Counter(mesh.name for mesh in meshes)
    numbers: Counter[str] = Counter()
    for i, mesh in enumerate(meshes):
        if counts[mesh.name] > 1:
            numbers[mesh.name] += 1
            meshes[i] = replace(mesh, name=f"{mesh.name}_{numbers[mesh.name]}")
    return paths, meshes


def ingest(
    mesh: str | Path | MeshOrScene,
    category: str = "",
    library: str | Path | None = None,
    name: str = "mesh",
    up: UpAxis = "",
) -> Ingested:
    """Turn one mesh into an asset: upright, in metres, with collision shapes, mass and friction, and checked.

    A file is read in a child process with limits on time and memory, so that nothing in it can harm the caller. So is
    a mesh in memory that is put into a library; where none is named it is worked on in this process.

    Args:
        mesh: path of a GLB, glTF, OBJ, PLY, STL, DAE or another file that is read; or a trimesh.Trimesh or
            trimesh.Scene.
        category: id of what it is; else its name tells.
        library: folder to write the asset to; None: it is returned and kept nowhere.
        name: what a mesh in memory is called.
        up: axis of a mesh in memory that points up; else its metadata tell, or it is guessed.
    Raises:
        CasaError: there is no such file, it is not one mesh, or this machine cannot make assets. UnknownId: no such
            category. What is wrong with the mesh itself is in the result's `rejection`.
    """
    if isinstance(mesh, str | Path):
        if up or name != "mesh":
            raise CasaError(
                f"{mesh}: name and up are for meshes in memory; set_up in a library's review.csv is for files"
            )
    elif library is None:
        return _in_memory(mesh, category, name, Up(up) if up else None)
    with tempfile.TemporaryDirectory(prefix="casa-assets-") as temporary:
        place = Library(temporary if library is None else library)
        results = list(place.ingest(mesh, category=category, name=name, up=up, jobs=1))
        if len(results) != 1:
            raise CasaError(f"{mesh}: holds {len(results)} inputs; Library(folder).ingest takes many")
        done = results[0]
        folder = None if library is None else done.folder
        if done.asset_id is None or done.folder is None:
            return Ingested(done.source, None, done.reasons[0], (), _refusal_report(done.folder), folder)
        report = disk.read_certificate(done.folder).report
        return Ingested(done.source, disk.read_asset(done.folder), None, done.warnings, report, folder)


def _in_memory(mesh: MeshOrScene, category: str, name: str, up: Up | None) -> Ingested:
    try:
        asset, report = ingest_mesh(mesh, name, category, up)
    except Rejected as error:
        return Ingested(name, None, Rejection(error.code, error.message))
    if report.passed:
        return Ingested(name, asset, None, report.issues, report)
    worst = first_error(report)
    return Ingested(name, None, Rejection(worst.code, worst.message), (), report)


def articulate(
    mesh: str | Path,
    category: str = "",
    up: str = "",
    front: str = "",
    size_m: float = 0.0,
    decisions: str | Path | None = None,
    complete: bool = True,
    library: str | Path | None = None,
    force: bool = False,
) -> Articulated:
    """Find doors, drawers, knobs and buttons of one static mesh and give them joints.

    The file is read in a child process with limits on time and memory.

    Args:
        mesh: OBJ, GLB, glTF, PLY, STL or DAE of one thing.
        category: what it is, such as `microwave`; else its name, then its shape tells.
        up: axis of the file that points up, such as `+z`; guessed where it is empty.
        front: axis of the file that points to whoever stands before it, such as `-y`; guessed where it is empty.
        size_m: longest side in metres; 0: by the file's unit and the category.
        decisions: a `decisions.yaml` of an earlier run, changed by hand.
        complete: build an interior where a door or a drawer opens onto nothing.
        library: folder to write the asset to; None: it is returned and kept nowhere.
        force: replace an accepted asset of the library also by a result that is in review, was rejected or has fewer
            moving parts, and work on the mesh though nothing has changed.
    Raises:
        CasaError: there is no such file, what is asked for does not go together, or this machine cannot make assets.
    """
    from casa_assets.articulate.decisions import Decisions, parse_direction
    from casa_assets.pipeline.articulate.batch import articulate as run_articulate
    from casa_assets.pipeline.articulate.build import ArticulateRequest
    from casa_assets.pipeline.articulate.sidecar import read as read_decisions

    path = Path(mesh)
    _check_exist([path])
    if not path.is_file():
        raise CasaError(f"{path}: is not a file; give one mesh of one thing")
    given = Decisions() if decisions is None else read_decisions(Path(decisions))
    try:
        axes = parse_direction(up) if up else None, parse_direction(front) if front else None
    except ValueError as error:
        raise CasaError(f"up or front: {error}") from error
    with tempfile.TemporaryDirectory(prefix="casa-assets-") as temporary:
        place = Path(temporary if library is None else library)
        request = ArticulateRequest(path, place, category, *axes, size_m, given, complete=complete, anew=force)
        found = list(run_articulate([path], place, lambda one: replace(request, source_file=one), jobs=1))
        if len(found) != 1:
            raise CasaError(f"{path}: holds {len(found)} meshes; give one mesh of one thing")
        return _articulated(found[0], kept=library is not None)


def _articulated(done: ArticulateOutcome, kept: bool) -> Articulated:
    is_made = done.decision is not Decision.REJECTED and done.folder is not None
    asset = disk.read_asset(done.folder) if is_made and done.folder is not None else None
    rejection = None if is_made else Rejection(done.code, done.message)
    folder = done.folder if kept else None
    source = str(done.mesh)
    told = done.report, done.category, done.size, done.unmet_checks
    return Articulated(source, asset, rejection, *told, folder, done.reason_kept)


def _check_exist(paths: Sequence[Path | StoreRoot]) -> None:
    for path in paths:
        if isinstance(path, Path) and not path.exists():
            raise OutputError(str(path), "there is no such file or folder")
