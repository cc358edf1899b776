"""3DS -> RawModel: a file of nested chunks, each with a number and a length that is checked before it is believed."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import Format, Reference, Role
from casa_assets.formats.read.materials import Look, Materials, linear_from_srgb, roughness_of_shininess
from casa_assets.formats.read.raw_parts import ReadPart, check_face_count, raw_model
from casa_assets.formats.read.text import Notes, decode, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.source import Bundle, RawModel, Up

_MAIN, _EDITOR, _OBJECT, _MESH, _MATERIAL = 0x4D4D, 0x3D3D, 0x4000, 0x4100, 0xAFFF
_POINTS, _FACES, _FACE_MATERIAL, _UV = 0x4110, 0x4120, 0x4130, 0x4140
_NAME, _DIFFUSE, _SHINE, _TRANSPARENCY, _PICTURE, _FILE = 0xA000, 0xA020, 0xA040, 0xA050, 0xA200, 0xA300
_RGB_FLOAT, _RGB_BYTES, _RGB_BYTES_LINEAR, _PERCENT, _PERCENT_FLOAT = 0x0010, 0x0011, 0x0012, 0x0030, 0x0031
MAX_CHUNKS = 100_000


@dataclass
class _Mesh:
    """A mesh as stored: its points are at their place already."""

    name: str
    points: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    faces: Ints = field(default_factory=lambda: np.zeros((0, 3), dtype=np.int64))
    uv: Floats | None = None
    materials: list[tuple[str, Ints]] = field(default_factory=list)


class _Chunks:
    def __init__(self, data: bytes, name: str) -> None:
        self.data, self.name = data, name
        self._count = 0

    def inside(self, start: int, end: int) -> Iterator[tuple[int, int, int]]:
        """Number, start and end of the content of each chunk between two places.

        Raises:
            Rejected: LENGTH_MISMATCH where a chunk is longer than what holds it, TOO_LARGE.
        """
        while start + 6 <= end:
            kind, length = struct.unpack_from("<HI", self.data, start)
            if length < 6 or start + length > end:
                message = f"{self.name}: the chunk {kind:#06x} at byte {start} claims {length} bytes; fetch it again"
                raise Rejected(codes.LENGTH_MISMATCH, message)
            self._count += 1
            if self._count > MAX_CHUNKS:
                raise Rejected(codes.TOO_LARGE, f"{self.name}: more than {MAX_CHUNKS} chunks; simplify the scene first")
            yield kind, start + 6, start + length
            start += length

    def text(self, start: int, end: int) -> tuple[str, int]:
        """Text that a zero byte ends, and the place behind it."""
        stop = self.data.find(b"\0", start, end)
        stop = end if stop < 0 else stop
        return decode(self.data[start:stop]), min(stop + 1, end)

    def table(self, start: int, end: int, dtype: str, width: int) -> tuple[Floats, int]:
        """(N, width) numbers that a 16-bit count comes before, and the place behind them. Raises Rejected."""
        count = struct.unpack_from("<H", self.data, start)[0] if start + 2 <= end else 0
        kind = np.dtype(dtype)
        stop = start + 2 + count * width * kind.itemsize
        if stop > end:
            message = (
                f"{self.name}: {count} rows are claimed at byte {start}, there is no room for them; fetch it again"
            )
            raise Rejected(codes.LENGTH_MISMATCH, message)
        flat = np.frombuffer(self.data, kind, count * width, start + 2) if count else np.zeros(0, kind)
        return flat.reshape(-1, width).astype(np.float64), stop


def load(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a 3DS: z up, as 3D Studio has it; its unit means nothing."""
    name = printable(bundle.main)
    meshes, looks = _scene(bundle.files[bundle.main], name, limits)
    materials = Materials(limits, notes)
    parts = [part for mesh in meshes for part in _parts(mesh, looks, bundle.files, materials, name)]
    return raw_model(parts, notes, name, Format.MAX_3DS, None, Up.Z)


def references(data: bytes, name: str) -> list[Reference]:
    """Pictures, as written. Raises Rejected as `load`."""
    _, looks = _scene(data, name, {"input_faces": math.inf})
    return [Reference(file, Role.IMAGE) for _, file in looks.values()]


def _scene(data: bytes, name: str, limits: Mapping[str, float]) -> tuple[list[_Mesh], dict[str, tuple[Look, str]]]:
    """Meshes, and look and picture of each material by its name."""
    chunks = _Chunks(data, name)
    if len(data) < 6:
        raise Rejected(codes.TRUNCATED, f"{name}: {len(data)} bytes, a 3DS has more; fetch it again")
    kind, length = struct.unpack_from("<HI", data, 0)
    if kind != _MAIN or length > len(data):
        message = f"{name}: says {length} bytes, there are {len(data)}; fetch it again"
        raise Rejected(codes.TRUNCATED, message)
    meshes: list[_Mesh] = []
    looks: dict[str, tuple[Look, str]] = {}
    faces = 0
    for part, start, end in chunks.inside(6, length):
        for what, first, last in chunks.inside(start, end) if part == _EDITOR else ():
            if what == _MATERIAL:
                look, file = _look(chunks, first, last)
                looks[look.name] = (look, file)
            elif what == _OBJECT:
                title, first = chunks.text(first, last)
                found = [_mesh(chunks, title, a, b) for k, a, b in chunks.inside(first, last) if k == _MESH]
                faces += sum(len(mesh.faces) for mesh in found)
                check_face_count(faces, limits, name)
                meshes += found
    return meshes, looks


def _mesh(chunks: _Chunks, title: str, start: int, end: int) -> _Mesh:
    mesh = _Mesh(title or "mesh")
    for kind, first, last in chunks.inside(start, end):
        if kind == _POINTS:
            mesh.points = chunks.table(first, last, "<f4", 3)[0]
        elif kind == _UV:
            mesh.uv = chunks.table(first, last, "<f4", 2)[0]
        elif kind == _FACES:
            rows, behind = chunks.table(first, last, "<u2", 4)
            mesh.faces = rows[:, :3].astype(np.int64)
            for inner, a, b in chunks.inside(behind, last):
                if inner == _FACE_MATERIAL:
                    name, a = chunks.text(a, b)
                    mesh.materials.append((name, chunks.table(a, b, "<u2", 1)[0].reshape(-1).astype(np.int64)))
    if len(mesh.faces) and int(mesh.faces.max()) >= len(mesh.points):
        message = f"{chunks.name}: {printable(title, 40)} has faces on points that do not exist; export it again"
        raise Rejected(codes.OUT_OF_BOUNDS, message)
    return mesh


def _look(chunks: _Chunks, start: int, end: int) -> tuple[Look, str]:
    """Look of a material, and the file of its picture."""
    name, file, color, opacity, shine = "material", "", (0.8, 0.8, 0.8), 1.0, 0.0
    for kind, first, last in chunks.inside(start, end):
        if kind == _NAME:
            name = chunks.text(first, last)[0] or name
        elif kind == _DIFFUSE:
            color = _color(chunks, first, last) or color
        elif kind == _TRANSPARENCY:
            opacity = 1.0 - _share(chunks, first, last)
        elif kind == _SHINE:
            shine = _share(chunks, first, last)
        elif kind == _PICTURE:
            file = next((chunks.text(a, b)[0] for k, a, b in chunks.inside(first, last) if k == _FILE), "")
    return Look(name, color, opacity, roughness=roughness_of_shininess(128.0 * shine)), file


def _color(chunks: _Chunks, start: int, end: int) -> tuple[float, float, float] | None:
    for kind, first, last in chunks.inside(start, end):
        if kind in (_RGB_BYTES, _RGB_BYTES_LINEAR) and last - first >= 3:
            r, g, b = (linear_from_srgb(c / 255.0) for c in chunks.data[first : first + 3])
            return r, g, b
        if kind == _RGB_FLOAT and last - first >= 12:
            r, g, b = (linear_from_srgb(float(c)) for c in struct.unpack_from("<3f", chunks.data, first))
            return r, g, b
    return None


def _share(chunks: _Chunks, start: int, end: int) -> float:
    """A share in 0..1 of a percent chunk; 0 if there is no such chunk."""
    for kind, first, last in chunks.inside(start, end):
        if kind == _PERCENT and last - first >= 2:
            return float(min(1.0, max(0.0, struct.unpack_from("<h", chunks.data, first)[0] / 100.0)))
        if kind == _PERCENT_FLOAT and last - first >= 4:
            value = float(struct.unpack_from("<f", chunks.data, first)[0])
            return min(1.0, max(0.0, value)) if math.isfinite(value) else 0.0
    return 0.0


def _parts(
    mesh: _Mesh,
    looks: Mapping[str, tuple[Look, str]],
    files: Mapping[str, bytes],
    materials: Materials,
    name: str,
) -> Iterator[ReadPart]:
    """A part for each material of a mesh; faces without one get a grey one."""
    uv = mesh.uv if mesh.uv is not None and len(mesh.uv) == len(mesh.points) else None
    rest = np.ones(len(mesh.faces), dtype=bool)
    for title, faces in mesh.materials:
        mask = np.zeros(len(rest), dtype=bool)
        mask[faces[faces < len(rest)]] = True
        mask &= rest
        rest &= ~mask
        if mask.any():
            look, file = looks.get(title, (Look(title or "material"), ""))
            if file in files:
                look = replace(look, color=(1.0, 1.0, 1.0), picture=(file, files[file]))
            material = materials.material(title, partial(replace, look))
            yield ReadPart(mesh.name, mesh.points, mesh.faces[mask], material, uv)
    if rest.any() or not len(rest):
        material = materials.material("none", lambda: Look("material"))
        yield ReadPart(mesh.name, mesh.points, mesh.faces[rest], material, uv)
