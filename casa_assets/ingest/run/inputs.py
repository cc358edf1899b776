"""Find the inputs of a run: files, what plug-ins fetch, and meshes that the caller has in memory."""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence, Set
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from casa_assets import registry
from casa_assets.core.system import cache_for, process_name, require
from casa_assets.errors import PluginFailure, Rejected
from casa_assets.ingest.run.survey import Survey, find_category
from casa_assets.ingest.sources.discover import discover
from casa_assets.ingest.sources.places import Found, Refused, StoreRoot, folder_of, root_of, utf8_escaped
from casa_assets.library.library import Library
from casa_assets.model.asset.asset import Asset
from casa_assets.model.issue import Report
from casa_assets.model.source import Source, SourceKind, Up
from casa_assets.registry.plugins.guard import guarded, sources
from casa_assets.runs.outcome import keep_trace

if TYPE_CHECKING:
    from casa_assets.mesh.trimesh_exchange import MeshOrScene

# Plugin sources -------------------------------------------------------------------------------------------------------

FETCHED = "fetched"  # folder in the cache
FAILED = "RUN009"


def roots_of(words: Sequence[str | Path], library: Path) -> tuple[list[Path | StoreRoot], tuple[Refused, ...]]:
    """Paths, addresses of stores, and folders of what plug-ins fetch; and the addresses at which a plug-in failed.

    The library keeps the traces of plug-ins that fail.
    """
    roots: list[Path | StoreRoot] = []
    refused: list[Refused] = []
    for word in words:
        one = word if isinstance(word, Path) else fetch(word, library) if is_of_plugin(word) else root_of(word)
        if isinstance(one, Refused):
            refused.append(one)
        else:
            roots.append(one)
    return roots, tuple(refused)


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
    roots: Sequence[Path | StoreRoot],
    library: Path,
    others: Counter[str] | None = None,
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
    # What a manifest lists stands beside it or below.
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
    # That all of it is ASCII, as nearly always, is told at once.
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
    """True if a file is in our library, or in any library below a root (a root may be one).

    `is_output`: takes up what is known of folders, by their path.
    """
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
    """A mesh in memory with what is known of it, for `Library.ingest`.

    Attributes:
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
    """The asset of a mesh or scene, and the report of every check, errors too."""
    from casa_assets.formats.read.from_trimesh import bundle_from_trimesh
    from casa_assets.ingest.run.steps import build_asset
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
