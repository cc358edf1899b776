"""Collect an input into a Bundle: the bytes of its main file and of the files it refers to, from its package only."""

from __future__ import annotations

import posixpath
import re
from collections.abc import Mapping
from pathlib import Path
from urllib.parse import unquote

from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import (
    MAX_REFERENCES,
    Format,
    Reference,
    Role,
    each_once,
    reader_of,
    references,
    sniff,
)
from casa_assets.formats.read.obj import material_references
from casa_assets.formats.read.text import Notes, printable
from casa_assets.ingest.sources.archive import members_of
from casa_assets.ingest.sources.found import Found
from casa_assets.ingest.sources.places import Place
from casa_assets.ingest.sources.stores import folder_of
from casa_assets.ingest.sources.table import is_table, row_of_table
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Bundle, RawModel

# What the mesh cannot do without.
_REQUIRED = (Role.BUFFER, Role.LAYER)
# Where exporters put pictures, relative to the mesh. The last is the Gazebo layout.
_PICTURE_FOLDERS = ("", "textures", "texture", "images", "../textures", "../materials/textures")


def collect(found: Found, limits: Mapping[str, float], looked_at: set[str] | None = None) -> Bundle:
    """Read an input.

    Args:
        found: what `discover` yielded.
        limits: `input_bytes` is the most that all files together may hold.
        looked_at: takes up the paths of all files and folders whose state decides what is read, missing ones too.
    Raises:
        Rejected: the main file or a glTF buffer is missing, refused, too large or of the wrong type.
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
        """Names in a folder of the package, sorted; empty if it cannot be read."""
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
    """Where an input and its companions lie.

    `looked_at`: takes up the paths of all files and folders that are looked at from now on, missing ones too.
    """
    folder = folder_of(found.root, looked_at)
    if not found.archive:
        return folder
    if looked_at is not None:
        looked_at.add(str(found.root / found.archive))
    if is_table(found.archive):
        return row_of_table(folder, found.archive, found.main, found.at)
    return members_of(folder, found.archive, found.main, found.at)
