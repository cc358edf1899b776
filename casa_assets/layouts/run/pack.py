"""Pack a scene and all files that it refers to into one ZIP or USDZ file, which loads on any machine by itself.

A scene on disk refers to files of the folder `assets` next to its own. In a pack that folder is inside, so that
`../assets/` in the files of the scene becomes `assets/`. Shared files refer only to each other and are not changed.
"""

from __future__ import annotations

import hashlib
import io
import json
import os.path
import re
import struct
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path, PurePosixPath

from casa_assets.core.system import replace_file
from casa_assets.errors import BatchFault, CasaError, OutputError
from casa_assets.formats.mjcf import kitchen as mjcf
from casa_assets.formats.usd import isaac_lab
from casa_assets.formats.usd import kitchen as usd
from casa_assets.layouts.run.recipe import recipe_of
from casa_assets.layouts.run.scene_folders import BuildOptions, build_all, is_current
from casa_assets.library import attribution
from casa_assets.model.kitchen.files import BEHAVIOR, LIGHT_FILE, OVERVIEW, SCENE_JSON, SHARED, START_STATES
from casa_assets.runs.outcome import writing

LICENCE_FIELD = re.compile(rb'string asset_license = "([^"\n]*)"')
AUTHOR_FIELD = re.compile(rb'string author = "([^"\n]*)"')
CREDIT_FIELDS = ("licence", "title", "author", "uri", "generator", "sha256")
# What MJCF and usda name: file="..." and @...@.
MJCF_REFERENCE = re.compile(rb'\bfile="([^"]+)"')
USD_REFERENCE = re.compile(rb"@([^@\n]+)@")
# No clock: the first moment that a ZIP can name.
ENTRY_TIME = (1980, 1, 1, 0, 0, 0)
READABLE = 0o644 << 16  # rights of a file, where ZIP keeps those of Unix
UNIX = 3
# Ref: OpenUSD, USDZ File Format Specification: data begins at multiples of 64 bytes. An extra field makes up for what
# lacks; 0x1986 is the identifier that OpenUSD's own writer gives it. 30 bytes: header of an entry, without its name.
ALIGNMENT = 64
PADDING_ID = 0x1986
ENTRY_HEADER = 30


class PackKind(StrEnum):
    """Form of a pack."""

    ZIP = "zip"
    USDZ = "usdz"


@dataclass(frozen=True)
class Pack:
    """A pack that was written.

    Attributes:
        scene_id, file: of which scene, and where. files: how many are in it. size: bytes.
        sha256: of the pack. built: the scene was built for it; False: it was there already.
    """

    scene_id: str
    file: Path
    files: int
    size: int
    sha256: str
    built: bool


def pack_scene(scene_id: str, scenes: Path, kind: PackKind, out: Path) -> Pack:
    """Write a scene as one file; it is built in `scenes` first where it is not there or not of today.

    `scene_id`: such as `l_small__coastal`. `scenes`: folder of scenes. `out`: the file; an older one is replaced.
    Raises UnknownId: no such scene. OutputError: `out` or `scenes` cannot be written to, or a file of the scene is
    missing. CasaError: the scene cannot be built. BatchFault: a fault of the program while it is built.
    """
    if out.is_dir():
        raise OutputError(str(out), "is a folder; name a file")
    recipe = recipe_of(scene_id, (scenes,))
    built = not is_current(recipe, scenes)
    if built:
        (made,) = build_all([recipe], scenes, 1, BuildOptions(drawn=False))
        if made.is_fault:
            raise BatchFault([scene_id], made.message)
        if not made.folder:
            raise CasaError(f"{scene_id}: {made.message}")
    members = members_of(scenes / recipe.scene_id)
    data = zip_bytes(scene_id, members) if kind is PackKind.ZIP else usdz_bytes(members)
    with writing(out.absolute().parent):
        replace_file(out.absolute(), data)
    count = len(members) if kind is PackKind.ZIP else len(_of_usd(members))
    return Pack(scene_id, out, count, len(data), hashlib.sha256(data).hexdigest(), built)


def members_of(folder: Path) -> dict[str, bytes]:
    """Return the files of a pack by path: those of the scene, then those in the shared folder that they refer to.

    `folder`: of a scene, with the folder of shared files next to it. Raises OutputError: a file that the scene refers
    to is missing, or is outside of the two folders.
    """
    own = [mjcf.FILE, LIGHT_FILE, usd.FILE, usd.NESTED_FILE, isaac_lab.FILE, SCENE_JSON]
    own += [name for name in (f"{OVERVIEW}.png", "report.json", START_STATES) if (folder / name).is_file()]
    # The shared folder is inside; `./` anchors what a usda names to its own folder.
    prefixes = {".xml": ('file="', f'file="{SHARED}/'), ".usda": ("@", f"@./{SHARED}/")}
    found = {}
    for name in own:
        before, inside = prefixes.get(PurePosixPath(name).suffix, ("", ""))
        data = _read(folder / name)
        found[name] = data.replace(f"{before}../{SHARED}/".encode(), inside.encode()) if before else data
    waiting = [path for name in own for path in _references(name, found[name])]
    assets = folder.parent / SHARED
    # State machines of those assets whose layers scene.usda names.
    ids = sorted({PurePosixPath(match[1].decode()).stem for match in USD_REFERENCE.finditer(found[usd.FILE])})
    waiting += [f"{SHARED}/{BEHAVIOR}/{one}.json" for one in ids if (assets / BEHAVIOR / f"{one}.json").is_file()]
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        if PurePosixPath(path).parts[0] != SHARED or ".." in PurePosixPath(path).parts:
            raise OutputError(str(folder), f"names {path}, which is outside of it and of {assets}; build it again")
        found[path] = _read(folder.parent / path)
        waiting += _references(path, found[path])
    found[attribution.NAME] = attribution.kitchens_text([folder.name], _credits(found)).encode("utf-8")
    return found


def zip_bytes(scene_id: str, members: dict[str, bytes]) -> bytes:
    """A compressed ZIP with one folder, called like the scene; the same members are the same bytes."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for path in sorted(members):
            archive.writestr(_entry(f"{scene_id}/{path}", zipfile.ZIP_DEFLATED), members[path], compresslevel=6)
    return stream.getvalue()


def usdz_bytes(members: dict[str, bytes]) -> bytes:
    """A USDZ of the layers and pictures, scene.usda first, which is what opens; the same members are the same bytes."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for path in _of_usd(members):
            entry = _entry(path, zipfile.ZIP_STORED)
            begin = stream.tell() + ENTRY_HEADER + len(path.encode()) + 4
            padding = -begin % ALIGNMENT
            entry.extra = struct.pack("<HH", PADDING_ID, padding) + bytes(padding)
            archive.writestr(entry, members[path])
    return stream.getvalue()


def _of_usd(members: dict[str, bytes]) -> list[str]:
    """Paths of the flat and the nested layer of a scene and what they name, the flat one first."""
    found, waiting = [usd.FILE, usd.NESTED_FILE], [usd.FILE]
    while waiting:
        path = waiting.pop()
        fresh = [name for name in _references(path, members[path]) if name not in found]
        found += dict.fromkeys(fresh)
        waiting += dict.fromkeys(fresh)
    return [usd.FILE, *sorted(set(found) - {usd.FILE})]


def _entry(path: str, compression: int) -> zipfile.ZipInfo:
    entry = zipfile.ZipInfo(path, ENTRY_TIME)
    entry.compress_type, entry.external_attr, entry.create_system = compression, READABLE, UNIX
    return entry


def _references(path: str, data: bytes) -> Iterator[str]:
    pattern = {".xml": MJCF_REFERENCE, ".usda": USD_REFERENCE}.get(PurePosixPath(path).suffix)
    for match in pattern.finditer(data) if pattern else ():
        yield os.path.normpath(PurePosixPath(path).parent / match[1].decode())


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        raise OutputError(str(path), "is missing; build the scene again with --force") from None


def _credits(members: dict[str, bytes]) -> Iterator[attribution.Credit]:
    """Yield the credits in the layers of a scene's assets, and those of assets and pictures in its scene.json."""
    for path in sorted(p for p in members if p.startswith(f"{SHARED}/{usd.LAYERS}/")):
        licence, author = LICENCE_FIELD.search(members[path]), AUTHOR_FIELD.search(members[path])
        if licence is None:
            continue
        name = author[1].decode() if author else ""
        name = "" if name == "unknown" else name
        yield attribution.Credit(PurePosixPath(path).stem, licence[1].decode(), author=name)
    facts = json.loads(members[SCENE_JSON])
    for row in facts.get("credits", ()):  # they say more than the layers do
        yield attribution.Credit(row["asset"], **{key: row[key] for key in CREDIT_FIELDS})
    for row in facts.get("textures", ()):
        author_of, generator = (row[key] if row[key] != "unknown" else "" for key in ("author", "generator"))
        yield attribution.Credit(row["id"], row["licence"], author=author_of, generator=generator)
