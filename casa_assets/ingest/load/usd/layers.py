"""USD bytes -> a folder of layers that name nothing outside of it; every layer is looked at before a stage is composed.

The library of USD reads files, so the layers of one input are written into a folder that is made for them and goes
with them. It follows what layers name: a path of the machine, another file format, an address. So each layer is opened
by itself first, and what it names has to be a layer that lies in that folder.
"""

from __future__ import annotations

import io
import posixpath
import re
import struct
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from pxr import Sdf, Tf

from casa_assets.errors import Rejected
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.notes import printable
from casa_assets.ingest.load.usd.crate import check_crate

SUFFIXES = (".usd", ".usda", ".usdc")
# Layers and pictures of one package; a choice, as is the depth of paths.
MAX_MEMBERS = 2000
DEEPEST_PRIM = 200
# Folders that a layer may lie above the main one, within what the user named.
MOST_UP = 8
# What the library of USD raises on files that are broken.
FAULTS = (Tf.ErrorException, RuntimeError, UnicodeError, OverflowError, MemoryError, OSError)
_OUTSIDE = re.compile(r"^([A-Za-z][A-Za-z0-9+.-]*:|/|\\|`|~)|\[|\]|\0")


def unpacked(data: bytes, main: str, limits: Mapping[str, float], name: str) -> tuple[str, dict[str, bytes]]:
    """Main layer and members of a USDZ package; a bare layer is its own only member.

    Raises:
        Rejected: BAD_ARCHIVE, PATH_TRAVERSAL, TOO_LARGE, WRONG_TYPE.
    """
    if not data.startswith(b"PK"):
        return main, {main: data}
    members: dict[str, bytes] = {}
    left = limits["input_bytes"]
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            for info in archive.infolist()[: MAX_MEMBERS + 1]:
                path = inside(info.filename, name, 0)
                left -= info.file_size
                if left < 0 or len(members) >= MAX_MEMBERS:
                    raise Rejected(codes.TOO_LARGE, f"{name}: unpacks to more than the limits allow; simplify it first")
                if not info.is_dir():
                    with archive.open(info) as stream:
                        members[path] = stream.read(info.file_size)
    except (zipfile.BadZipFile, ValueError, OSError, EOFError, RuntimeError, struct.error) as error:
        message = f"{name}: the package cannot be unpacked ({printable(str(error), 80)}); fetch it again"
        raise Rejected(codes.BAD_ARCHIVE, message) from error
    first = next(iter(members), "")
    if not first.lower().endswith(SUFFIXES):
        raise Rejected(codes.WRONG_TYPE, f"{name}: the first file of a USDZ has to be a layer; export it again")
    return first, members


def inside(path: str, name: str, most_up: int = MOST_UP) -> str:
    """A path, normalised, that begins with no more than `most_up` steps up.

    Raises:
        Rejected: PATH_TRAVERSAL, NETWORK_URI.
    """
    plain = posixpath.normpath(path.replace("\\", "/"))
    if _OUTSIDE.search(path) or plain.split("/").count("..") > most_up:
        message = f"{name}: {printable(path, 80)!r} lies outside of the package; put the file into it"
        code = codes.NETWORK_URI if re.match(r"[A-Za-z][A-Za-z0-9+.-]+://", path) else codes.PATH_TRAVERSAL
        raise Rejected(code, message)
    return plain


def asset_paths(data: bytes, name: str, folder: Path) -> tuple[list[str], list[str]]:
    """Layers that one layer brings in, and all other files that it names, as written there.

    Args:
        data: of the layer. folder: an own one, for a copy of the layer.
    Raises:
        Rejected: SCENE_UNREADABLE where it is no layer, or is nested without end.
    """
    pictures: dict[str, None] = {}
    try:
        layer = _opened(data, name, folder)
        for spec in _specs(layer, name):
            if isinstance(spec, Sdf.AttributeSpec) and isinstance(spec.default, Sdf.AssetPath):
                pictures[spec.default.path] = None
        layers = [path for path in layer.GetCompositionAssetDependencies() if path]
    except FAULTS as error:
        raise broken(name) from error
    return layers, [path for path in pictures if path]


def _opened(data: bytes, name: str, folder: Path) -> Sdf.Layer:
    """A layer by itself: nothing that it names is opened. Raises Rejected SCENE_UNREADABLE."""
    check_crate(data, name)
    suffix = ".usdc" if data.startswith(b"PXR-USDC") else ".usda"
    copy = folder / f"layer{suffix}"
    copy.write_bytes(data)
    try:
        layer = Sdf.Layer.OpenAsAnonymous(str(copy)) if data.startswith((b"PXR-USDC", b"#usda")) else None
    finally:
        copy.unlink()
    if layer is None:
        raise broken(name)
    return layer


def checked(layer: Sdf.Layer, path: str, members: Mapping[str, bytes], name: str) -> None:
    """Raise where a layer would bring in anything but layers of its package; clips of animation are taken out.

    Args:
        path: of the layer within the package. members: of the package.
    Raises:
        Rejected: PATH_TRAVERSAL, NETWORK_URI, MISSING_FILE, SCENE_UNREADABLE.
    """
    for spec in _specs(layer, name):
        if isinstance(spec, Sdf.PrimSpec) and spec.HasInfo("clips"):
            spec.ClearInfo("clips")  # animation in other files; what is read is the shape at rest
    for wanted in filter(None, layer.GetCompositionAssetDependencies()):  # one within the layer has no name
        inside(wanted, name)
        place = inside(posixpath.join(posixpath.dirname(path), wanted), name)
        if place not in members:
            message = f"{name}: the layer {printable(wanted, 80)!r} is missing; put it beside the file"
            raise Rejected(codes.MISSING_FILE, message)
        if not members[place].startswith((b"PXR-USDC", b"#usda")):
            message = f"{name}: {printable(wanted, 80)!r} is no USD layer; flatten the stage and export it again"
            raise Rejected(codes.SCENE_UNREADABLE, message)


def _specs(layer: Sdf.Layer, name: str) -> Iterator[Sdf.Spec]:
    """All prims and attributes of a layer, those of variants among them."""
    waiting = list(layer.rootPrims)
    while waiting:
        prim = waiting.pop()
        if prim is None:
            raise broken(name)
        if prim.path.pathElementCount > DEEPEST_PRIM:
            raise Rejected(codes.SCENE_UNREADABLE, f"{name}: prims nested deeper than {DEEPEST_PRIM}; export it again")
        yield prim
        yield from prim.attributes
        waiting += prim.nameChildren
        for variants in prim.variantSets.values():
            waiting += [variant.primSpec for variant in variants.variants.values()]


def broken(name: str) -> Rejected:
    """The refusal of a layer that USD cannot read."""
    return Rejected(
        codes.SCENE_UNREADABLE, f"{name}: this is no readable USD layer; open it in usdview, export it again"
    )
