"""The reader of each format: what a file refers to, and a bundle of it and those files -> RawModel."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Protocol

import numpy as np

from casa_assets.formats.read.formats import ALIASES, SUFFIX_OF, Format, Reference, sniff, suffix_of
from casa_assets.formats.read.raw_parts import check_face_count
from casa_assets.formats.read.text import Notes, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Bundle, RawModel

# A hostile file may name thousands of files.
MAX_REFERENCES = 500


class Reader(Protocol):
    """Functions that the module of a format provides."""

    def references(self, data: bytes, name: str) -> list[Reference]:
        """Other files that a file names, as written there; `name` is for messages. Raises Rejected."""

    def load(self, bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
        """The model of a bundle in file units and axes; what is left out goes into `notes`. Raises Rejected."""


def load(bundle: Bundle, limits: Mapping[str, float]) -> RawModel:
    """Read a bundle. Pure: no disk, no network, no clock.

    Args:
        bundle: main file and what it refers to.
        limits: input_faces, input_texture_px, input_texture_pixels, as registry/limits.yaml has them.
    Returns:
        Parts in file units and file axes; the bundle's notes come first among its notes.
    Raises:
        Rejected: with a code of casa_assets.model.rejection_codes.
    """
    name = printable(bundle.main)
    if bundle.model is not None:
        check_face_count(sum(len(p.mesh.faces) for p in bundle.model.parts), limits, name)
        return bundle.model.replace(notes=bundle.notes + bundle.model.notes)
    data = bundle.files[bundle.main]
    file_format = sniff(data, name)
    notes = Notes()
    suffix = suffix_of(bundle.main)
    if suffix != SUFFIX_OF[file_format] and ALIASES.get(suffix) is not file_format:
        notes.add(
            codes.TYPE_BY_CONTENT,
            name,
            f"{name}: read as {file_format.value.upper()} by its content, not by its name",
        )
    # hostile numbers overflow and cast badly; what comes of it is found and judged in rough.finish
    with np.errstate(all="ignore"):
        model = reader_of(file_format).load(bundle, limits, notes)
    return model.replace(notes=bundle.notes + notes.issues)


def references(file_format: Format, data: bytes, name: str) -> list[Reference]:
    """Files that a main file refers to, as written, each once, in file order. Raises Rejected where it is broken."""
    found = reader_of(file_format).references(data, name)
    return each_once(r for r in found if not r.name.startswith("data:"))


def each_once(found: Iterable[Reference]) -> list[Reference]:
    """Names of files, each once and not too many of them."""
    return list(dict.fromkeys(r for r in found if r.name))[:MAX_REFERENCES]


def reader_of(file_format: Format) -> Reader:
    """The reader of a format. They are imported when one is asked for: some need libraries that take long to import."""
    if file_format is Format.USD:
        from casa_assets.formats.read import usd

        return usd
    if file_format is Format.FBX:
        from casa_assets.formats.read import fbx

        return fbx
    if file_format in (Format.OFF, Format.THREE_MF, Format.XAML):
        from casa_assets.formats.read import from_trimesh

        return from_trimesh
    from casa_assets.formats.read import blend, collada, gltf, max3ds, obj, ply, stl, vrml

    readers: Mapping[Format, Reader] = {
        Format.GLB: gltf,
        Format.GLTF: gltf,
        Format.OBJ: obj,
        Format.PLY: ply,
        Format.STL: stl,
        Format.DAE: collada,
        Format.VRML: vrml,
        Format.X3D: vrml,
        Format.MAX_3DS: max3ds,
        Format.BLEND: blend,
    }
    return readers[file_format]


def warm() -> None:
    """Import the readers of common formats, once for all workers that are forked later."""
    reader_of(Format.GLB)
