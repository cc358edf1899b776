"""Read and write a library on disk: its folders, entries, certificates and refusals.

library/
  <category>/<id>/      model.xml scene.xml meshes/ textures/ usd/ preview.png asset.json
  rejected/<id>/        reject.json and, where one could be made, preview.png
  library.json  ATTRIBUTION.md  report.html
  .casa/                cache/ (results by content) staging/ (half-written, swept at the start) lock

Two producers may be given one file: `ingest` makes a rigid asset of it, `articulate` one that opens. So an id is the
category and a word for the producer and its input, which finds all that it ever made of the input, under any category:

mug_e1b7e22aee                      ingest: the first 10 hex digits of the sha256 of the input
microwave_articulated_a39fd0c2b1    articulate: the same after an additional word
microwave_0c6e21fa83                a family: the first 10 hex digits of the digest of its numbers
"""

from __future__ import annotations

import copy
import ctypes
import errno
import fcntl
import hashlib
import json
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
from pydantic import ValidationError

from casa_assets.core.system import process_name
from casa_assets.errors import OutputError
from casa_assets.formats.mjcf import shapes
from casa_assets.library.entry_files import PICTURE, file_inside
from casa_assets.model.asset.asset import Asset, Signature
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.issue import Files, Report
from casa_assets.model.record import Record
from casa_assets.model.source import Source

# The USD package holds every image; the MJCF has only those that MuJoCo draws.
IMAGES = "usd/textures"
SLOTS = ("base_color_texture", "metallic_roughness_texture", "normal_texture")


def manifest_of(asset: Asset) -> dict[str, Any]:
    """Return the JSON data of an asset; a mesh is written as `{"obj": path}`, and an image's `png` is its path."""
    data: dict[str, Any] = asset.model_dump(mode="json", exclude={"links": True, "materials": True})
    files = shapes.gather_meshes(asset).of
    data["links"] = []
    for link in asset.links:
        row = link.model_dump(mode="json", exclude={"visuals", "colliders"})
        row["visuals"] = [
            {"name": v.name, "material": v.material, "mesh": {"obj": files[v.name].path}}
            | ({} if v.label is None else {"label": v.label})
            for v in link.visuals
        ]
        row["colliders"] = []
        for c in link.colliders:
            keep = c.model_dump(mode="json", exclude={"shape": {"mesh"}})
            if c.name in files:
                keep["shape"]["mesh"] = {"obj": files[c.name].path}
            row["colliders"].append(keep)
        data["links"].append(row)
    data["materials"] = []
    for look in asset.materials:
        row = look.model_dump(mode="json", exclude=set(SLOTS))
        for slot in SLOTS:
            image = getattr(look, slot)
            row[slot] = None
            if image is not None:
                row[slot] = image.model_dump(mode="json", exclude={"png"})
                row[slot]["png"] = f"{IMAGES}/{image.file_name}"
        data["materials"].append(row)
    return data


def asset_from_manifest(data: dict[str, Any], folder: Path) -> Asset:
    """The asset that `manifest_of` described, its files read from `folder`. Raises OutputError."""

    def file(name: object, pointer: str) -> Path:
        return file_inside(folder, name, folder / "asset.json", f"asset/{pointer}")

    try:
        links, looks = copy.deepcopy(data["links"]), copy.deepcopy(data["materials"])
        for i, link in enumerate(links):
            for j, visual in enumerate(link["visuals"]):
                visual["mesh"] = read_obj(file(visual["mesh"]["obj"], f"links/{i}/visuals/{j}/mesh/obj"))
            for j, shape in enumerate(collider["shape"] for collider in link["colliders"]):
                if "mesh" in shape:
                    shape["mesh"] = read_obj(file(shape["mesh"]["obj"], f"links/{i}/colliders/{j}/shape/mesh/obj"))
        for i, look in enumerate(looks):
            for slot in SLOTS:
                if look[slot] is not None:
                    look[slot]["png"] = file(look[slot]["png"], f"materials/{i}/{slot}/png").read_bytes()
        return Asset.model_validate({**data, "links": links, "materials": looks})
    except (OSError, KeyError, TypeError, ValueError, ValidationError) as error:
        raise OutputError(str(folder), f"asset.json or a file that it names is damaged: {error}") from error


def read_obj(path: Path) -> Mesh:
    """An OBJ file as the MJCF writer writes it: one index for position, uv and normal. Raises ValueError, OSError."""
    rows: dict[str, list[list[float]]] = {"v": [], "vt": [], "vn": []}
    faces = []
    for line in path.read_text(encoding="ascii").splitlines():
        word, *values = line.split()
        if word == "f":
            faces.append([int(v.split("/")[0]) - 1 for v in values])
        elif word in rows:
            rows[word].append([float(v) for v in values])
    vertices, uv, normals = (np.array(rows[w], dtype=np.float32).astype(np.float64) for w in ("v", "vt", "vn"))
    return Mesh(vertices=vertices, faces=faces, uv=uv if len(uv) else None, normals=normals if len(normals) else None)


DIGITS = 10


class Producer(StrEnum):
    """Producers of a library's entries."""

    INGEST = "ingest"
    ARTICULATE = "articulate"
    FAMILY = "family"


# What stands before the digits in an id.
_WORDS = {Producer.ARTICULATE: "articulated_"}


@dataclass(frozen=True)
class Identity:
    """A producer and the sha256 of what it was given: at most one entry of a library has them.

    Attributes:
        sha256: of the input; of a family's member, the digest of its numbers.
    """

    producer: Producer
    sha256: str

    @property
    def suffix(self) -> str:
        """End of the id after the category: a word for the producer, and digits of the input."""
        return f"{_WORDS.get(self.producer, '')}{self.sha256[:DIGITS]}"

    def asset_id(self, category: str) -> str:
        """The id under a category."""
        return f"{category}_{self.suffix}"

    def may_own(self, asset_id: str) -> bool:
        """True if an id can be that of this producer and input, under any category."""
        category, found, end = asset_id.rpartition(f"_{self.suffix}")
        return bool(found) and not end and not any(category.endswith(f"_{w}".rstrip("_")) for w in _WORDS.values())


def suffix_of(asset_id: str) -> str:
    """Return the end of an id, which identifies producer and input, as `Identity.suffix` gives it."""
    before, _, digits = asset_id.rpartition("_")
    for word in _WORDS.values():
        if f"{before}_".endswith(f"_{word}"):
            return f"{word}{digits}"
    return digits


REJECTED = "rejected"
CERTIFICATE = "asset.json"
REFUSAL = "reject.json"
LOCK = "lock"
R = TypeVar("R", bound=Record)
# Arguments of renameat2: paths relative to the working folder; exchange two names. Ref: rename(2), linux/fcntl.h.
AT_FDCWD, RENAME_EXCHANGE = -100, 2
_ADVICE = "remove its folder and run again"


class Summary(Record):
    """Numbers for tables: extents in metres, mass in kg, counts."""

    extents: tuple[float, float, float]
    mass: float
    colliders: int
    hull_vertices: int
    faces: int


@dataclass(frozen=True)
class MadeBy:
    """Producer of an entry, the key that it is kept under, and its stages and tools by version."""

    producer: Producer
    cache_key: str
    versions: dict[str, str]


class Certificate(Record):
    """Certificate of an asset: the part of asset.json besides the asset itself.

    Attributes:
        schema_version: of this file.
        asset_digest: of the Asset record, canonical.
        producer: what made the asset.
        cache_key: digest of everything that decided the result besides the source.
        versions: stages of the producer with their keys, and the packages that they use.
        report: every check that applies to this subject, with its number or why it did not apply or was not run.
        summary: numbers for tables.
        files: path -> sha256 of everything in the folder but asset.json.
        signature: compared with those of other assets; None if the asset has no visible geometry.
    """

    schema_version: Literal[2] = 2
    producer: Producer
    asset_digest: str
    cache_key: str
    versions: dict[str, str]
    report: Report
    summary: Summary
    files: dict[str, str]
    signature: Signature | None = None


@dataclass(frozen=True)
class Manifest:
    """asset.json of an accepted asset, read once: its certificate, and the asset as plain data."""

    folder: Path
    certificate: Certificate
    asset: Mapping[str, Any]

    @property
    def identity(self) -> Identity | None:
        """Producer and input of the asset; None if the file does not say."""
        try:
            return Identity(self.certificate.producer, str(self.asset["provenance"]["sha256"]))
        except (KeyError, TypeError):
            return None


class Refusal(Record):
    """Record of a rejected input in reject.json: the input, the reason, and what was known of it.

    Attributes:
        twin: folder, relative to the library, of the asset that it is a copy of; empty if it is no copy.
    """

    schema_version: Literal[2] = 2
    producer: Producer
    id: str
    code: str
    message: str
    category: str
    cache_key: str
    sha256: str
    source: Source
    report: Report | None = None
    twin: str = ""


class Library:
    """A folder of assets. Every entry appears whole, by one rename, or not at all."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.private = root / ".casa"
        self.cache = self.private / "cache"
        self.staging = self.private / "staging"

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Hold the library for writing. Raises OutputError where it is not a folder or another run holds it."""
        try:
            self.staging.mkdir(parents=True, exist_ok=True)
            handle = (self.private / LOCK).open("a")
        except OSError as error:
            raise OutputError(str(self.root), f"cannot be written to: {error.strerror}") from error
        with handle:
            try:
                fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise OutputError(str(self.root), "another run is writing to this library; wait for it") from error
            yield

    def sweep(self) -> None:
        """Remove what a killed run left half-written. Call with the lock held and while no worker runs."""
        for path in self.private.iterdir():
            if path.is_dir() and path != self.cache:
                shutil.rmtree(path, ignore_errors=True)
            elif not path.is_dir() and path.name != LOCK:
                path.unlink(missing_ok=True)
        self.staging.mkdir(exist_ok=True)

    def write(self, name: str, text: str) -> None:
        """Replace a file right in the library by one rename."""
        self.private.mkdir(parents=True, exist_ok=True)
        fresh = self.private / f"{name}.{os.getpid()}"
        fresh.write_text(text, encoding="utf-8")
        fresh.replace(self.root / name)

    def folder(self, category: str, asset_id: str) -> Path:
        """Folder of an accepted asset."""
        return self.root / category / asset_id

    def refusal_folder(self, asset_id: str) -> Path:
        """Folder of a rejected input."""
        return self.root / REJECTED / asset_id

    def stage(self, asset_id: str) -> Path:
        """A fresh folder of that name on the same file system, inside one that is private to this process."""
        path = self.staging / f"{asset_id}.{process_name()}" / asset_id  # SimReady asks for the asset's own name
        shutil.rmtree(path.parent, ignore_errors=True)
        path.mkdir(parents=True)
        return path

    def stage_refusal(self, refusal: Refusal, picture: bytes = b"") -> Path:
        """Write the finished entry of a rejected input into the staging folder, and return its folder."""
        staged = self.stage(refusal.id)
        if picture:
            (staged / PICTURE).write_bytes(picture)
        write_refusal(staged, refusal)
        return staged

    def publish(
        self,
        staged: Path,
        target: Path,
        older: Iterable[Path] | None = None,
        identity: Identity | None = None,
    ) -> None:
        """Put a finished entry in its place by one rename, then remove earlier entries of the same producer and input.

        Those may be under another category or among the rejected. If killed in between, the library has two whole
        entries of one input; the next run keeps the current one.

        Args:
            older: folders of earlier entries that the producer may have made of that input, as `by_input` gives them;
                None: they are searched for, which is slow if it is done for each of very many entries.
            identity: of the entry, if it is known; None: it is read.
        Raises:
            OutputError: another producer, or another input, has an entry in that place.
        """
        own, held = identity or identity_of(staged), identity_of(target)
        if own is None:
            raise ValueError(f"{staged} holds no entry of a library")
        if held is not None and held != own:
            message = f"holds what {held.producer.value} made of another input; move it to another library"
            raise OutputError(str(target), message)
        self.put(staged, target)
        for folder in self._candidates(own) if older is None else older:
            if folder != target and _may_be(folder, own):
                self.forget(folder)

    def put(self, staged: Path, target: Path) -> None:
        """Put a finished folder in its place by one rename; an older one is exchanged for it and removed."""
        while True:
            target.parent.mkdir(parents=True, exist_ok=True)
            try:
                exchange(staged, target)
                break
            except FileNotFoundError:  # a neighbour took the last entry of this category away, and the folder with it
                if not staged.exists():
                    raise
        shutil.rmtree(staged.parent, ignore_errors=True)

    def entries_of(self, identity: Identity) -> Iterator[Path]:
        """Folders of what a producer made of an input, under any category, accepted ones first."""
        return (folder for folder in self._candidates(identity) if _may_be(folder, identity))

    def _candidates(self, identity: Identity) -> list[Path]:
        """Folders that are named as entries of an identity are, whether they are there or not, accepted ones first."""
        if not self.root.is_dir():
            return []
        shelves = sorted(p for p in self.root.iterdir() if p.is_dir() and p != self.private)
        rejected = self.root / REJECTED
        folders = [shelf / identity.asset_id(shelf.name) for shelf in shelves if shelf != rejected]
        refused = rejected.iterdir() if rejected.is_dir() else ()
        return folders + sorted(p for p in refused if identity.may_own(p.name))

    def forget(self, folder: Path) -> None:
        """Remove an entry that a newer one has replaced, and with the last of a category the folder of the category."""
        if folder.exists():
            trash = self.staging / f"{folder.name}.{process_name()}.gone"
            shutil.rmtree(trash, ignore_errors=True)
            folder.rename(trash)
            shutil.rmtree(trash)
        with suppress(OSError):  # others are still there, or a worker has just put one there
            folder.parent.rmdir()

    def by_input(self) -> dict[str, tuple[Path, ...]]:
        """Folders of all entries by `Identity.suffix`, which identifies producer and input; accepted ones first."""
        found: dict[str, list[Path]] = {}
        for folder in (*self.accepted(), *self.refused()):
            found.setdefault(suffix_of(folder.name), []).append(folder)
        return {word: tuple(folders) for word, folders in found.items()}

    def accepted(self) -> Iterator[Path]:
        """Folders of all accepted assets, sorted by category and id."""
        for shelf in _folder_names(self.root):
            if shelf not in (REJECTED, self.private.name):
                yield from _folders_with(self.root / shelf, CERTIFICATE)

    def shelf_times(self) -> dict[str, int]:
        """When a folder last came to, or went from, each folder of entries, nanoseconds since 1970, by its name."""
        names = [name for name in _folder_names(self.root) if name != self.private.name]
        return {name: os.stat(self.root / name).st_mtime_ns for name in names}  # noqa: PTH116

    def refused(self) -> Iterator[Path]:
        """Folders of all rejected inputs, sorted by id."""
        yield from _folders_with(self.root / REJECTED, REFUSAL)


def _folder_names(place: Path) -> list[str]:
    """Return the names of the folders in a folder, sorted; empty if it does not exist or cannot be read."""
    try:
        with os.scandir(place) as inside:
            return sorted(entry.name for entry in inside if entry.is_dir())
    except OSError:
        return []


def _folders_with(place: Path, file: str) -> Iterator[Path]:
    """Folders right in a folder that hold a file of that name, sorted."""
    base = str(place)  # Path would take longer than all the rest
    for name in _folder_names(place):
        if os.path.exists(f"{base}/{name}/{file}"):  # noqa: PTH110
            yield place / name


def identity_of(folder: Path) -> Identity | None:
    """Return producer and input of an entry, or None if the entry is missing or damaged."""
    try:
        if (folder / CERTIFICATE).is_file():
            return read_manifest(folder).identity
        refusal = read_refusal(folder)
        return Identity(refusal.producer, refusal.sha256)
    except OutputError:
        return None


def _may_be(folder: Path, identity: Identity) -> bool:
    """Return whether a folder holds an entry of an identity, or one whose identity cannot be read."""
    return folder.is_dir() and identity_of(folder) in (identity, None)


def exchange(fresh: Path, target: Path) -> None:
    """Rename a folder to a name that another one may have, which gets the old name of the first: both at one moment.

    Raises:
        OSError: as `os.rename` does.
    """
    if not target.exists():
        fresh.rename(target)
        return
    libc = ctypes.CDLL(None, use_errno=True)
    code = 0
    if hasattr(libc, "renameat2"):
        code = libc.renameat2(AT_FDCWD, os.fsencode(fresh), AT_FDCWD, os.fsencode(target), RENAME_EXCHANGE)
        if code == 0:
            return
        code = ctypes.get_errno()
    if code not in (0, errno.ENOSYS, errno.EINVAL, errno.ENOTSUP):
        raise OSError(code, os.strerror(code), str(target))
    # A file system that cannot exchange: killed between these two, the input is due again.
    older = fresh.with_name(f"{fresh.name}.old")
    target.rename(older)
    fresh.rename(target)


def write_files(root: Path, files: Files) -> None:
    """Put files under a folder."""
    for path, data in files.entries.items():
        target = root / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data)


def file_digests(root: Path) -> dict[str, str]:
    """Relative path -> sha256 of every file under a folder, sorted."""
    paths = sorted(p for p in root.rglob("*") if p.is_file())
    return {p.relative_to(root).as_posix(): hashlib.sha256(p.read_bytes()).hexdigest() for p in paths}


def write_certificate(root: Path, asset: Asset, certificate: Certificate) -> None:
    """Write asset.json: the asset, with references to meshes and textures in the same folder, and its certificate."""
    _write_json(root / CERTIFICATE, {"asset": manifest_of(asset), "certificate": certificate.model_dump(mode="json")})


def write_refusal(root: Path, refusal: Refusal) -> None:
    """reject.json."""
    _write_json(root / REFUSAL, refusal.model_dump(mode="json"))


def read_certificate(folder: Path) -> Certificate:
    """The certificate of an accepted asset. Raises OutputError where the file is damaged."""
    return _certificate(folder, _json(folder / CERTIFICATE))


def read_manifest(folder: Path) -> Manifest:
    """All of asset.json of an accepted asset. Raises OutputError where the file is damaged."""
    data = _json(folder / CERTIFICATE)
    return Manifest(folder, _certificate(folder, data), _section(folder, data, "asset"))


def _certificate(folder: Path, data: Mapping[str, Any]) -> Certificate:
    return _record(Certificate, folder / CERTIFICATE, _section(folder, data, "certificate"))


def find_summary(folder: Path) -> Summary | None:
    """Return the numbers of the asset in a folder, or None if there is no asset, or no library has accepted it.

    Raises OutputError if asset.json is damaged.
    """
    path = folder / CERTIFICATE
    return read_certificate(folder).summary if path.is_file() and "certificate" in _json(path) else None


def is_whole(folder: Path, certificate: Certificate) -> bool:
    """True if every file that the certificate of an accepted asset names is there; its bytes are not compared."""
    return all((folder / name).is_file() for name in certificate.files)


def read_asset(folder: Path) -> Asset:
    """The whole Asset, meshes and textures included. Raises OutputError where a file is missing or damaged."""
    return asset_from_manifest(_section(folder, _json(folder / CERTIFICATE), "asset"), folder)


def read_refusal(folder: Path) -> Refusal:
    """Read the record of a rejected input. Raises OutputError where the file is damaged."""
    return _record(Refusal, folder / REFUSAL, _json(folder / REFUSAL))


def _section(folder: Path, data: Mapping[str, Any], name: str) -> dict[str, Any]:
    section = data.get(name)
    if not isinstance(section, dict):
        raise OutputError(str(folder / CERTIFICATE), f"holds no {name!r}; {_ADVICE}")
    return section


def _record(kind: type[R], path: Path, data: dict[str, Any]) -> R:
    try:
        return kind.model_validate(data)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        place = ".".join(str(p) for p in first["loc"])
        raise OutputError(str(path), f"is damaged at {place}: {first['msg']}; {_ADVICE}") from error


def _write_json(path: Path, data: dict[str, Any]) -> None:
    text = json.dumps(data, sort_keys=True, indent=1, ensure_ascii=False, allow_nan=False)
    path.write_text(text + "\n", encoding="utf-8")


def _json(path: Path) -> dict[str, Any]:
    file_inside(path.parent, path.name, path, "the file itself")
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise OutputError(str(path), f"cannot be read: {error}; {_ADVICE}") from error
    if not isinstance(data, dict):
        raise OutputError(str(path), f"is not a JSON object; {_ADVICE}")
    return data
