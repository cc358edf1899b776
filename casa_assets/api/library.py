"""Convert meshes to assets: one at a time in memory, or many into a library on disk."""

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
from casa_assets.ingest.run.inputs import MeshInput, UpAxis, roots_of
from casa_assets.ingest.run.run import Options
from casa_assets.ingest.run.run import ingest as run_ingest
from casa_assets.ingest.sources.places import StoreRoot
from casa_assets.library.entry import Entry, entries
from casa_assets.library.entry_files import read_asset, read_certificate, read_refusal
from casa_assets.library.entry_table import EntryTable
from casa_assets.library.library import Library as LibraryFolder
from casa_assets.library.search import SearchHit, search_by_words
from casa_assets.mesh.trimesh_exchange import MeshOrScene
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Decision, Issue, Report, subjects_to_decide
from casa_assets.model.source import Up
from casa_assets.runs.outcome import FAILURE_CODES, Event, first_error

if TYPE_CHECKING:
    from casa_assets.articulate.run.steps import ArticulateOutcome

# Taken by `Library.ingest`.
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
        source: path of the input as its source states it, or the name of a mesh in memory.
        status: `accepted`: there is a new asset. `review`: there is one, and `Library.in_review` lists what a person
            has to decide about it. `skipped`: an earlier run made the asset from the same bytes, and it is unchanged.
            `rejected`: no asset can be made of it, now or in an earlier run. `failed`: the work on it ended without a
            verdict (its limits on time or memory, a crash); the next run tries again.
        asset_id: None if it was rejected or failed.
        folder: of the asset, or of the rejected input; None for inputs without a mesh, as a broken row of a manifest.
        reasons: why it was rejected or failed, the decisive one first; empty if there is an asset.
        warnings: faults that do not keep an asset out.
        count: number of inputs that it represents; more than 1 for rows of a manifest that are broken in the same way.
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
        source: path of the input.
        asset: accepted or in review, or None if it was rejected.
        rejection: None if there is an asset.
        warnings: faults that do not keep it out.
        report: every check, with its number or why it has no number; None if it was rejected before the checks.
        folder: folder of the entry in the library; None without a library.
    """

    source: str
    asset: Asset | None
    rejection: Rejection | None
    warnings: tuple[Issue, ...] = ()
    report: Report | None = None
    folder: Path | None = None

    @property
    def to_decide(self) -> tuple[str, ...]:
        """Properties, such as `scale`, that were decided on weak evidence and that a person has to confirm."""
        return subjects_to_decide(self.warnings)

    @property
    def accepted(self) -> bool:
        """True if there is an asset and a person has nothing to decide about it."""
        return self.asset is not None and not self.to_decide


@dataclass(frozen=True)
class Articulated(Ingested):
    """Outcome of searching one mesh for doors, drawers and controls; ART001 in its rejection: no part moves.

    `to_decide` names `frame`, `plan` or `contacts`, and the folder has `decisions.yaml` in it.

    Attributes:
        category, size: its assumed category and size, with the reasons.
        missing: requirements of RoboCasa's fixture class of its kind that it does not meet; empty if it meets them all.
        reason_kept: why this is the accepted asset that was already in the library, and not the new result; empty
            otherwise.
    """

    category: str = ""
    size: str = ""
    missing: tuple[str, ...] = ()
    reason_kept: str = ""


class Library:
    """A folder of assets, as `casa-assets ingest` writes it; it need not exist before the first ingest.

    Iterating gives the records of its accepted assets, sorted by category and id, and `len` counts them.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self._disk = LibraryFolder(self.path)

    def __repr__(self) -> str:
        """Text such as `<Library out/library>`."""
        return f"<Library {self.path}>"

    def __iter__(self) -> Iterator[Entry]:
        """Records of the accepted assets. Raises OutputError if one is damaged."""
        return (entry for entry in entries(self._disk) if entry.decision is Decision.ACCEPTED)

    def __len__(self) -> int:
        """Number of accepted assets."""
        return sum(entry.decision is Decision.ACCEPTED for entry in EntryTable(self._disk).entries)

    def in_review(self) -> Iterator[Entry]:
        """Records of assets about which a person has to decide something, in review.csv; `to_decide` lists it."""
        return (entry for entry in entries(self._disk) if entry.decision is Decision.REVIEW)

    def __contains__(self, asset_id: object) -> bool:
        """True if there is an asset of this id, accepted or in review."""
        return any(folder.name == asset_id for folder in self._disk.accepted())

    def rejected(self) -> Iterator[Entry]:
        """Records of the rejected inputs, each with a code and a reason."""
        return (entry for entry in entries(self._disk) if not entry.accepted)

    def folder(self, asset_id: str) -> Path:
        """Folder of an asset, accepted or in review. Raises UnknownId with the nearest ids."""
        found = {folder.name: folder for folder in self._disk.accepted()}
        if asset_id not in found:
            raise UnknownId(f"asset of {self.path}", asset_id, found)
        return found[asset_id]

    def get(self, asset_id: str) -> Asset:
        """Return an asset, accepted or in review, with its data. Raises UnknownId, or OutputError if damaged."""
        return read_asset(self.folder(asset_id))

    def search(self, words: str, limit: int = 20) -> list[SearchHit]:
        """Assets whose category, title, path or colours match most of the words, best first."""
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
        """Ingest files, folders, manifests and meshes in memory; each is read in a separate process with limits.

        Assets that an earlier run made from the same bytes are kept, and accepted ones if the new result would be in
        review or rejected; both are `skipped`. Nothing is done before the first result is requested: use
        `list(library.ingest(...))` if you do not need the results.

        Args:
            inputs: paths; addresses on stores, such as `s3://bucket/meshes`; trimesh.Trimesh or trimesh.Scene;
                MeshInput, a mesh with its own name, category and up axis; or lists of these.
            category: category id for all of them; if empty, names and sources decide.
            name: name of meshes that are not in a MeshInput. If it is not given, it is the mesh's own name (from its
                metadata), or `mesh`; meshes with the same name are numbered.
            up: axis that points up, for meshes that are not in a MeshInput; if empty, it is read from their metadata or
                guessed.
            jobs: number of inputs processed at once; 0: one per core.
            force: process all inputs, and replace accepted assets whatever the new result is.
        Yields:
            The result of each input when it is done.
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
    if event.folder is not None and (report := read_refusal(event.folder).report):
        reasons += tuple(Rejection(issue.code, issue.message) for issue in report.errors[1:])
    is_failed = event.code in FAILURE_CODES.values()
    return IngestResult(
        event.path, "failed" if is_failed else "rejected", None, event.folder, reasons, count=event.count
    )


def _sorted_inputs(
    inputs: Sequence[Input | Sequence[Input]], name: str, up: UpAxis
) -> tuple[list[str | Path], list[MeshInput]]:
    """Separate paths and addresses from meshes in memory, and give the meshes distinct names."""
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

    It is read in a child process with limits on time and memory, so that nothing in it can harm the caller; a mesh in
    memory without a library is processed in this process.

    Args:
        mesh: path of a GLB, glTF, OBJ, PLY, STL, DAE or another supported file; or a trimesh.Trimesh or trimesh.Scene.
        category: category id; if empty, it is taken from the name.
        library: folder to write the asset to; None: the asset is only returned.
        name: name of a mesh in memory.
        up: axis of a mesh in memory that points up; if empty, it is read from the metadata or guessed.
    Raises:
        CasaError: there is no such file, it is not one mesh, or this machine cannot make assets. UnknownId: no such
            category. Faults of the mesh itself are in the result's `rejection`.
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
            report = None if done.folder is None else read_refusal(done.folder).report
            return Ingested(done.source, None, done.reasons[0], (), report, folder)
        report = read_certificate(done.folder).report
        return Ingested(done.source, read_asset(done.folder), None, done.warnings, report, folder)


def _in_memory(mesh: MeshOrScene, category: str, name: str, up: Up | None) -> Ingested:
    try:
        from casa_assets.ingest.run.steps import ingest_mesh  # loads renderer and validator

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
        mesh: OBJ, GLB, glTF, PLY, STL or DAE of one object.
        category: such as `microwave`; if empty, it is taken from the name, or else from the shape.
        up: axis of the file that points up, such as `+z`; guessed if empty.
        front: axis of the file that points to a person in front of the object, such as `-y`; guessed if empty.
        size_m: longest side in metres; 0: by the file's unit and the category.
        decisions: a `decisions.yaml` of an earlier run, edited by hand.
        complete: build an interior if a door or a drawer opens onto nothing.
        library: folder to write the asset to; None: the asset is only returned.
        force: replace an accepted asset of the library even if the result is in review, was rejected or has fewer
            moving parts, and process the mesh even if nothing has changed.
    Raises:
        CasaError: there is no such file, the arguments contradict each other, or this machine cannot make assets.
    """
    from casa_assets.articulate.decisions import Decisions, parse_direction
    from casa_assets.articulate.run.build import ArticulateRequest
    from casa_assets.articulate.run.run import articulate as run_articulate
    from casa_assets.library.mesh_decisions import read_decisions

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
        request = ArticulateRequest(path, place, category, *axes, size_m, given, complete=complete, force=force)
        found = list(run_articulate([path], place, lambda one: replace(request, source_file=one), jobs=1))
        if len(found) != 1:
            raise CasaError(f"{path}: holds {len(found)} meshes; give one mesh of one thing")
        return _articulated(found[0], is_kept=library is not None)


def _articulated(done: ArticulateOutcome, is_kept: bool) -> Articulated:
    asset = rejection = None
    if done.decision is not Decision.REJECTED and done.folder is not None:
        asset = read_asset(done.folder)
    else:
        rejection = Rejection(done.code, done.message)
    warnings = done.report.issues if asset is not None and done.report is not None else ()
    folder = done.folder if is_kept else None
    about = done.category, done.size, done.unmet_checks, done.reason_kept
    return Articulated(str(done.mesh), asset, rejection, warnings, done.report, folder, *about)


def _check_exist(paths: Sequence[Path | StoreRoot]) -> None:
    for path in paths:
        if isinstance(path, Path) and not path.exists():
            raise OutputError(str(path), "there is no such file or folder")
