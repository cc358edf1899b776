"""Discover inputs under what the user names, in one order on every machine, and collect each into a Bundle."""

from __future__ import annotations

import hashlib
import os
import posixpath
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from urllib.parse import unquote

from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import (
    MAX_REFERENCES,
    SUFFIXES,
    Format,
    Reference,
    Role,
    each_once,
    reader_of,
    references,
    sniff,
    suffix_of,
)
from casa_assets.formats.read.obj import material_references
from casa_assets.formats.read.text import Notes, printable
from casa_assets.ingest.sources import objaverse
from casa_assets.ingest.sources.archive import archived, members_of
from casa_assets.ingest.sources.places import (
    HIDDEN,
    Found,
    Package,
    Place,
    Refused,
    StoreRoot,
    archive_suffix,
    folder_of,
    is_table,
    kind_of_other,
    unique_hints,
    unread,
    utf8_escaped,
    words_of_path,
)
from casa_assets.ingest.sources.rows import read_lines, read_list
from casa_assets.ingest.sources.stores import DEEPEST_FOLDER, list_all
from casa_assets.ingest.sources.table import row_of_table, tabled
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Bundle, RawModel, Source, SourceKind

# What the mesh cannot do without.
_REQUIRED = (Role.BUFFER, Role.LAYER)
# Where exporters put pictures, relative to the mesh. The last is the Gazebo layout.
_PICTURE_FOLDERS = ("", "textures", "texture", "images", "../textures", "../materials/textures")


def discover(roots: Sequence[Path | StoreRoot], others: Counter[str] | None = None) -> Iterator[Found | Refused]:
    """All inputs under the roots; an input that several roots reach is yielded once.

    `roots`: folders or files, as the user named them, on the disk or on stores. `others`: counts the files that are no
    inputs, by what they are: pictures, materials, texts ... Yields Found or Refused, sorted by path within a root;
    packages before the loose files of the same folder. Raises CasaError: nothing is there, or a store is away.
    """
    found_keys: set[tuple[str, str]] = set()
    refused_digests: set[bytes] = set()
    real_folders: dict[str, str] = {}
    for root in roots:
        for one in _discover(root, Counter() if others is None else others):
            if isinstance(one, Refused):
                # A digest of the place and the reason, which names the line: there may be very many.
                place = f"{root}/{one.path}"
                if isinstance(root, Path):
                    place = os.path.realpath((root if root.is_dir() else root.parent) / one.path)
                place += f"\0{one.code}\0{one.message}"
                digest = hashlib.sha256(place.encode("utf-8", "surrogateescape")).digest()[:16]
                if digest in refused_digests:
                    continue
                refused_digests.add(digest)
            else:
                # the same for an input by whatever path it is found
                if isinstance(one.root, Path):
                    path = _real_path(os.path.join(one.root, one.archive, one.main), real_folders)  # noqa: PTH118
                else:
                    path = str(one.root / one.archive / one.main)
                if (key := (path, one.source.uid)) in found_keys:
                    continue
                found_keys.add(key)
            yield one


def _real_path(path: str, real_folders: dict[str, str]) -> str:
    """As `os.path.realpath`, which looks at every folder above; `real_folders`: what is known of folders."""
    folder, name = os.path.split(path)
    if os.path.islink(path):  # noqa: PTH114
        return os.path.realpath(path)
    if folder not in real_folders:
        real_folders[folder] = os.path.realpath(folder)
    return os.path.join(real_folders[folder], name)  # noqa: PTH118


def _discover(root: Path | StoreRoot, others: Counter[str]) -> Iterator[Found | Refused]:
    if isinstance(root, Path):
        place: Path | StoreRoot = root.absolute()
        is_folder = root.is_dir()
    else:
        place = root
        faults = list_all(root)
        is_folder = faults is not None
        for path, code, why in faults or ():
            yield Refused(printable(path, 400), code, f"{printable(path, 200)}: {why}")
    around = Package(place.parent, "")
    if is_folder:
        inputs = 0
        for one in _folder(Package(place, ""), set(), 0, others):
            inputs += 1
            yield one
        if not inputs and suffix_of(place.name) in SUFFIXES:
            message = f"{utf8_escaped(place.name)}: a folder, not a regular file; put the file itself there"
            yield Refused(utf8_escaped(place.name), codes.NOT_A_FILE, message)
    elif posixpath.splitext(place.name.lower())[1] == ".jsonl":
        yield from read_lines(around, place.name, is_named=True)
    elif posixpath.splitext(place.name.lower())[1] == ".json":
        listed = objaverse.read_xl(around, place.name)
        yield from listed if listed is not None else read_list(around, place.name, is_named=True)
    elif archive_suffix(place.name):
        yield from archived(around, place.name, others)
    elif is_table(place.name):
        yield from tabled(around, place.name, others, is_named=True)
    else:
        # The Gazebo and ROS layout, whose textures lie beside the folder: ../materials/textures
        is_in_layout = place.parent.name.lower() in ("mesh", "meshes")
        package = Package(place.parent.parent, "") if is_in_layout else around
        main = f"{place.parent.name}/{place.name}" if is_in_layout else place.name
        one = _loose(package, main)
        if isinstance(one, Found):
            one = Found(one.root, one.main, one.source.replace(path=place.name))
        yield one


def _folder(package: Package, claimed: set[str], depth: int, others: Counter[str]) -> Iterator[Found | Refused]:
    """Packages here, then loose meshes, then folders; `claimed` holds the real paths of packaged files."""
    try:
        entries = package.files.scan("")
    except OSError as error:
        folder = utf8_escaped(package.prefix)
        message = f"{folder or '.'}: the folder cannot be read ({error.strerror}); change its permissions"
        yield Refused(folder.rstrip("/"), codes.UNREADABLE, message)
        return
    others[HIDDEN] += sum(e.name.startswith(".") and e.is_file for e in entries)
    entries = [e for e in entries if not e.name.startswith(".") and e.name != "__MACOSX"]
    names = frozenset(e.name.lower() for e in entries)
    for one in _packaged(package, [e.name for e in entries]):
        if isinstance(one, Found):
            claimed.add(folder_of(one.root).identity(one.main))
        yield one
    is_objaverse = objaverse.is_package([e.name for e in entries])
    folders = []
    for entry in entries:
        if entry.is_folder and suffix_of(entry.name) not in SUFFIXES:
            if not (is_objaverse and entry.name in ("glbs", "metadata")):
                folders.append(entry.name)
        elif claimed and package.files.identity(entry.name) in claimed:
            continue
        elif is_table(entry.name):
            yield from tabled(package, entry.name, others)
        elif kind := kind_of_other(entry.name, names):
            others[kind] += 1
        elif archive_suffix(entry.name):
            yield from archived(package, entry.name, others)
        elif suffix_of(entry.name) in SUFFIXES:
            yield _loose(package, entry.name)
        elif (refused := unread(utf8_escaped(package.prefix + entry.name))) is not None:
            yield refused
    for name in folders:
        if depth >= DEEPEST_FOLDER:
            message = f"{utf8_escaped(name)}: folders nested too deep; move it"
            yield Refused(utf8_escaped(package.prefix + name), codes.UNREADABLE, message)
        else:
            yield from _inner(package, name, claimed, depth, others)


def _inner(
    package: Package, name: str, claimed: set[str], depth: int, others: Counter[str]
) -> Iterator[Found | Refused]:
    """A folder inside; its loose files keep the outer root, so that ../textures is still theirs."""
    inner = Package(package.root / name, f"{package.prefix}{name}/")
    for one in _folder(inner, claimed, depth + 1, others):
        if isinstance(one, Found) and one.source.kind is SourceKind.FOLDER:
            if one.archive:
                one = replace(one, root=package.root, archive=f"{name}/{one.archive}")
            else:
                one = replace(one, root=package.root, main=f"{name}/{one.main}")
        yield one


def _packaged(package: Package, names: Sequence[str]) -> Iterator[Found | Refused]:
    if objaverse.is_package(names):
        yield from objaverse.read_package(package)
    for name in names:
        lower = name.lower()
        if lower.endswith(".jsonl"):
            yield from read_lines(package, name, is_named=False)
        elif lower == "annotations.json":
            yield from objaverse.read_xl(package, name) or ()
        elif lower.endswith(".json") and lower not in objaverse.INDEX_FILES:
            yield from read_list(package, name, is_named=False)


def _loose(package: Package, main: str) -> Found | Refused:
    """A mesh file that no package describes: its name and folders are all that is known."""
    path = package.prefix + main
    try:
        package.check_utf8(main)
        package.files.check(main)
    except Rejected as error:
        return package.refuse(main, error)
    hints = unique_hints(words_of_path(path), [package.root.name])
    source = Source(kind=SourceKind.FOLDER, path=path, hints=hints)
    return Found(package.root, main, source)


def collect(found: Found, limits: Mapping[str, float], looked_at: set[str] | None = None) -> Bundle:
    """Read an input.

    `found`: what `discover` yielded. `limits`: `input_bytes` is the most that all files together may hold. `looked_at`:
    takes up the paths of all files and folders whose state decides what is read, missing ones too. Raises Rejected: the
    main file or a glTF buffer is missing, refused, too large or of the wrong type.
    """
    main, thing = posixpath.basename(found.main), found.source.node
    if found.is_model:
        name = f"{found.source.path}.trimesh"
        model = RawModel.from_json(Path(str(found.root / found.main)).read_bytes())
        return Bundle(main=name, files={}, notes=found.notes, model=model, thing=thing)
    place = place_of(found, looked_at)
    data = place.read(found.main, limits["input_bytes"])
    kind = sniff(data, printable(main))
    collector = _Collector(found, place, limits["input_bytes"] - len(data), main, data)
    if kind is Format.USD:
        collector.add_layers(main)
    else:
        collector.add_all(references(kind, data, printable(main)), found.main)
    if kind is Format.OBJ:
        collector.add_materials()
    return Bundle(main=main, files=collector.files, notes=(*found.notes, *collector.notes.issues), thing=thing)


class _Collector:
    """Gathers the files of one input, within its root and its budget of bytes."""

    def __init__(self, found: Found, place: Place, budget: float, main: str, data: bytes) -> None:
        self._found, self._files, self._budget = found, place, budget
        self.files: dict[str, bytes] = {main: data}
        self.notes = Notes()
        self._libraries: list[tuple[str, str]] = []
        self._names: dict[str, list[str]] = {}

    def add_all(self, wanted: list[Reference], owner: str) -> None:
        """Add what `owner` (POSIX, relative to the root) refers to."""
        for reference in wanted:
            if reference.name in self.files:
                continue
            place = self._place(reference, owner)
            if place is None and reference.role is Role.MATERIAL and " " in reference.name:
                words = [Reference(w, Role.MATERIAL) for w in reference.name.split()]
                self.add_all(words, owner)
            elif place is not None:
                self._add(reference, place)

    def add_materials(self) -> None:
        """Pictures of the material files; where no material file was found, one with the stem of the main file."""
        if not self._libraries:
            self._guess_library()
        for name, place in self._libraries:
            try:
                wanted = each_once(material_references(self.files[name], printable(name)))
            except Rejected as error:
                self.notes.add(codes.MATERIAL_MISSING, name, f"material file left out: {error.message}")
                continue
            self.add_all(wanted, place)

    def add_layers(self, main: str) -> None:
        """Layers that USD layers name, and their pictures; all are called by their path from the main file's folder."""
        folder = posixpath.dirname(self._found.main)
        waiting = [main]
        for owner in waiting:
            for reference in reader_of(Format.USD).references(self.files[owner], printable(owner)):
                key = posixpath.normpath(posixpath.join(posixpath.dirname(owner), reference.name))
                if key in self.files:
                    continue
                if len(self.files) > MAX_REFERENCES:
                    message = f"{printable(main)}: names more than {MAX_REFERENCES} files; flatten the stage"
                    raise Rejected(codes.TOO_LARGE, message)
                place = self._place(reference, posixpath.join(folder, owner))
                if place is not None:
                    self._add(Reference(key, reference.role), place)
                if reference.role is Role.LAYER and key in self.files:
                    waiting.append(key)

    def _guess_library(self) -> None:
        folder, main = posixpath.split(self._found.main)
        stem = main.rpartition(".")[0].lower()
        fits = [n for n in self._listing(folder) if n.lower() in (f"{stem}.mtl", f"{main.lower()}.mtl")]
        if len(fits) == 1 and fits[0] not in self.files:
            message = f"{printable(fits[0])} is taken for its material file, by name"
            self.notes.add(codes.MATERIAL_GUESSED, fits[0], message)
            self._add(Reference(fits[0], Role.MATERIAL), posixpath.join(folder, fits[0]))

    def _add(self, reference: Reference, place: str) -> None:
        try:
            data = self._files.read(place, self._budget)
        except Rejected as error:
            if reference.role in _REQUIRED or error.code == codes.TOO_LARGE:
                raise
            code = codes.LINK_IGNORED if error.code == codes.LINK_OUTSIDE else codes.REFERENCE_MISSING
            self.notes.add(code, reference.name, f"{reference.role.value} left out: {error.message}")
            return
        self._budget -= len(data)
        self.files[reference.name] = data
        if reference.role is Role.MATERIAL:
            self._libraries.append((reference.name, place))

    def _place(self, reference: Reference, owner: str) -> str | None:
        """Path relative to the root of what is referred to, or None (noted; a buffer raises)."""
        folder = posixpath.dirname(owner)
        refusal = _refusal(reference.name)
        candidates = () if refusal else dict.fromkeys((reference.name, unquote(reference.name)))
        for spelling in candidates:
            path = posixpath.normpath(posixpath.join(folder, spelling.replace("\\", "/").removeprefix("file:")))
            if path.startswith("..") and path[2:3] in ("", "/"):
                refusal = codes.PATH_TRAVERSAL
                continue
            place = self._existing(path, reference)
            if place is not None:
                return place
        if reference.role in _REQUIRED:
            name, what = printable(reference.name, 80), reference.role.value
            if not refusal:
                raise Rejected(codes.MISSING_FILE, f"{what} {name!r} is missing; put it beside the mesh")
            why = "lies on the network, which is not read" if refusal == codes.NETWORK_URI else "leaves the package"
            raise Rejected(refusal, f"{what} {name!r} {why}; pack it into the file")
        return self._by_base_name(reference, folder, refusal)

    def _by_base_name(self, reference: Reference, folder: str, refusal: str | None) -> str | None:
        """A file of the same base name where pictures usually lie; else a note."""
        base = re.split(r"[\\/]", unquote(reference.name))[-1]
        name = printable(reference.name, 80)
        places = _PICTURE_FOLDERS if reference.role is Role.IMAGE else ("",)
        for near in places if base not in ("", ".", "..") else ():
            path = posixpath.normpath(posixpath.join(folder, near, base))
            place = None if path.startswith("..") else self._existing(path, reference)
            if place is not None:
                message = f"`{name}` was found by its base name, as {printable(place, 80)}"
                self.notes.add(codes.FOUND_BY_BASE_NAME, name, message)
                return place
        if refusal:
            self.notes.add(codes.REFERENCE_IGNORED, name, f"reference `{name}` outside the package ignored")
        else:
            message = f"{reference.role.value} {name!r} is missing; put it beside the mesh"
            self.notes.add(codes.REFERENCE_MISSING, name, message)
        return None

    def _existing(self, path: str, reference: Reference) -> str | None:
        """The path, or its spelling in another case; None if neither exists."""
        try:
            if self._files.has(path):
                return path
            folder, base = posixpath.split(path)
            if not self._files.is_inside(folder):
                return None
        except (ValueError, OSError):
            return None
        fits = [n for n in self._listing(folder) if n.lower() == base.lower()]
        if not fits:
            return None
        message = f"{printable(reference.name, 80)!r} is spelt {printable(fits[0], 80)!r} on disk; rename one"
        self.notes.add(codes.CASE_MISMATCH, reference.name, message)
        return posixpath.join(folder, fits[0])

    def _listing(self, folder: str) -> list[str]:
        if folder not in self._names:
            self._names[folder] = self._files.listing(folder)
        return self._names[folder]


def _refusal(name: str) -> str | None:
    """Code of what makes a name unacceptable before the disk is looked at, or None."""
    text = unquote(name).strip()
    if re.match(r"[A-Za-z]:[\\/]", text) or text.startswith(("/", "\\")):
        return codes.PATH_TRAVERSAL
    if re.match(r"[A-Za-z][A-Za-z0-9+.-]+:", text):
        return codes.PATH_TRAVERSAL if text.lower().startswith("file:") else codes.NETWORK_URI
    return codes.PATH_TRAVERSAL if "\0" in text else None


def place_of(found: Found, looked_at: set[str] | None = None) -> Place:
    """Where an input and its companions lie; `looked_at`: takes up the paths of all that is looked at."""
    folder = folder_of(found.root, looked_at)
    if not found.archive:
        return folder
    if looked_at is not None:
        looked_at.add(str(found.root / found.archive))
    if is_table(found.archive):
        return row_of_table(folder, found.archive, found.main, found.at)
    return members_of(folder, found.archive, found.main, found.at)
