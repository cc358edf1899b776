"""PLY, text or binary -> RawModel: one part, with vertex colours or texture coordinates where it has them."""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import Format, Reference, Role
from casa_assets.formats.read.materials import Images, ImageUse
from casa_assets.formats.read.raw_parts import ReadPart, check_face_count, cut_whole, raw_model, rgba
from casa_assets.formats.read.text import Notes, decode, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.material import Material
from casa_assets.model.source import Bundle, RawModel

_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8",
}  # fmt: skip
# Names that writers use for texture coordinates and colours of vertices.
_UV_NAMES = (("s", "t"), ("u", "v"), ("texture_u", "texture_v"), ("texcoord_u", "texcoord_v"))
_COLOR_NAMES = (("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue"))


@dataclass(frozen=True)
class Property:
    """A column: its name, dtype, and the dtype of its length where it is a list (else empty)."""

    name: str
    dtype: str
    length: str = ""


@dataclass
class Element:
    """A table: its name, number of rows and columns."""

    name: str
    count: int
    properties: list[Property] = field(default_factory=list)


@dataclass
class Header:
    """Header of a PLY file.

    Attributes:
        order: `<`, `>` or empty for text.
        elements: tables in file order.
        textures: names in `comment TextureFile` lines.
        start: offset of the first byte after the header.
    """

    order: str
    elements: list[Element]
    textures: list[str]
    start: int


@dataclass
class Table:
    """Rows of one element.

    Attributes:
        scalars: column -> (N,) values in their own dtype.
        lists: column -> (flat values, (N,) lengths).
    """

    scalars: dict[str, npt.NDArray[np.generic]]
    lists: dict[str, tuple[npt.NDArray[np.generic], npt.NDArray[np.int64]]]


def read_header(data: bytes, name: str) -> Header:
    """Raises Rejected BAD_HEADER where the header is not a PLY header, TRUNCATED where it does not end."""
    end = re.search(rb"^end_header[ \t]*(\r\n|\n|\r)?", data[: 1 << 20], re.MULTILINE)
    if end is None:
        end = re.search(rb"\rend_header[ \t]*\r", data[: 1 << 20])
    if end is None:
        raise Rejected(codes.TRUNCATED, f"{name}: the PLY header has no `end_header`; fetch it again")
    header = Header("?", [], [], end.end())
    for line in re.split(r"[\r\n]+", decode(data[: end.start()]))[1:]:
        _header_line(header, line.strip(), name)
    if header.order == "?":
        raise Rejected(codes.BAD_HEADER, f"{name}: the PLY header names no format; export it again")
    return header


def _header_line(header: Header, line: str, name: str) -> None:
    words = line.split()
    texture = re.match(r"comment\s+TextureFile\s+(.+)", line, re.IGNORECASE)
    if texture:
        header.textures.append(texture.group(1).strip())
    if not words or words[0] in ("comment", "obj_info"):
        return
    try:
        if words[0] == "format":
            header.order = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}[words[1]]
        elif words[0] == "element":
            count = int(words[2])
            if count < 0 or count > 1 << 62:
                raise ValueError(words[2])
            header.elements.append(Element(words[1], count))
        elif words[0] == "property" and words[1] == "list":
            header.elements[-1].properties.append(Property(words[4], _TYPES[words[3]], _TYPES[words[2]]))
        elif words[0] == "property":
            header.elements[-1].properties.append(Property(words[2], _TYPES[words[1]]))
        else:
            raise KeyError(words[0])
    except (KeyError, IndexError, ValueError) as error:
        message = f"{name}: PLY header line {printable(line, 60)!r} is not understood; export it again"
        raise Rejected(codes.BAD_HEADER, message) from error


def read_tables(data: bytes, header: Header, name: str) -> dict[str, Table]:
    """Tables by element name; reading stops after `face`, for nothing later matters.

    Call check_lengths first.

    Raises:
        Rejected: TRUNCATED where the rows are not there, BAD_NUMBER in text files.
    """
    out: dict[str, Table] = {}
    if not header.order:
        words = data[header.start :].split()
        at = 0
        for element in header.elements:
            out[element.name], at = _text_rows(words, at, element, name)
    else:
        at = header.start
        for element in header.elements:
            out[element.name], at = _binary_rows(data, at, element, header.order, name)
            if "face" in out:
                break
    return out


def check_lengths(data: bytes, header: Header, name: str) -> None:
    """Each row takes some bytes at least: a claim beyond them is refused, TRUNCATED or LENGTH_MISMATCH."""
    room = len(data) - header.start
    for element in header.elements:
        sizes = (np.dtype(p.length or p.dtype).itemsize for p in element.properties)
        least = sum(sizes) if header.order else 2 * len(element.properties)
        need = element.count * least - (0 if header.order else 1)
        if element.count and need > room:
            message = (
                f"{name}: {element.count} rows of {printable(element.name, 20)!r} need {need} bytes, {room} are left"
            )
            is_cut = need <= 16 * max(room, 1) and room > 0
            raise Rejected(codes.TRUNCATED if is_cut else codes.LENGTH_MISMATCH, message + "; fetch it again")
        room -= max(need, 0)


def _truncated(element: Element, name: str) -> Rejected:
    message = (
        f"{name}: the rows of {printable(element.name, 20)!r} end before their count ({element.count}); fetch it again"
    )
    return Rejected(codes.TRUNCATED, message)


def _binary_rows(data: bytes, at: int, element: Element, order: str, name: str) -> tuple[Table, int]:
    lengths = _first_lengths(data, at, element, order)
    if lengths is None:
        raise _truncated(element, name)
    fields: list[tuple[str, str] | tuple[str, str, int]] = []
    for i, p in enumerate(element.properties):
        if p.length:
            fields.append((f"n{i}", order + p.length))
            fields.append((f"p{i}", order + p.dtype, lengths[i]))
        else:
            fields.append((f"p{i}", order + p.dtype))
    dtype = np.dtype(fields)
    size = dtype.itemsize * element.count
    if at + size <= len(data):
        rows = np.frombuffer(data, dtype=dtype, count=element.count, offset=at) if size else np.zeros(0, dtype)
        if all((rows[f"n{i}"] == lengths[i]).all() for i, p in enumerate(element.properties) if p.length):
            columns = [rows[f"p{i}"].reshape(-1) for i in range(len(element.properties))]
            return _table(element, columns, {i: np.full(len(rows), n, np.int64) for i, n in lengths.items()}), at + size
    elif not any(p.length for p in element.properties):
        raise _truncated(element, name)
    return _slow_binary_rows(data, at, element, order, name)


def _first_lengths(data: bytes, at: int, element: Element, order: str) -> dict[int, int] | None:
    """Length of each list in the first row; None if the data ends within that row."""
    out: dict[int, int] = {}
    for i, p in enumerate(element.properties):
        size = np.dtype(p.dtype).itemsize
        if p.length:
            width = np.dtype(p.length).itemsize
            if not element.count:
                out[i] = 0
                continue
            if at + width > len(data):
                return None
            out[i] = int(np.frombuffer(data, order + p.length, 1, at)[0])
            if out[i] < 0 or at + width + out[i] * size > len(data):
                return None
            at += width + out[i] * size
        else:
            at += size
    return out


def _table(
    element: Element, columns: Sequence[npt.NDArray[np.generic]], lengths: Mapping[int, npt.NDArray[np.int64]]
) -> Table:
    """Table of the flat values of each column, and the lengths of those that are lists, by their place."""
    rows = list(zip(element.properties, columns, strict=True))
    return Table(
        {p.name: column for p, column in rows if not p.length},
        {p.name: (column, lengths[i]) for i, (p, column) in enumerate(rows) if p.length},
    )


def _slow_binary_rows(data: bytes, at: int, element: Element, order: str, name: str) -> tuple[Table, int]:
    values: list[list[float]] = [[] for _ in element.properties]
    counts: list[list[int]] = [[] for _ in element.properties]
    # numpy's letters of these types are those of struct
    codes_of = [np.dtype(p.dtype) for p in element.properties]
    length_codes = [struct.Struct(order + np.dtype(p.length).char) if p.length else None for p in element.properties]
    try:
        for _ in range(element.count):
            for i, (length, kind) in enumerate(zip(length_codes, codes_of, strict=True)):
                n = 1
                if length is not None:
                    n = int(length.unpack_from(data, at)[0])
                    at += length.size
                    counts[i].append(n)
                    if n < 0 or n * kind.itemsize > len(data) - at:
                        raise _truncated(element, name)
                values[i].extend(struct.unpack_from(f"{order}{n}{kind.char}", data, at))
                at += n * kind.itemsize
    except struct.error as error:
        raise _truncated(element, name) from error
    columns = [np.array(column, dtype=kind) for column, kind in zip(values, codes_of, strict=True)]
    return _table(element, columns, {i: np.array(n, dtype=np.int64) for i, n in enumerate(counts)}), at


def _text_rows(words: list[bytes], at: int, element: Element, name: str) -> tuple[Table, int]:
    width = len(element.properties)
    try:
        if not any(p.length for p in element.properties):
            end = at + width * element.count
            if end > len(words):
                raise _truncated(element, name)
            flat = np.array(words[at:end]).astype(np.float64).reshape(element.count, width)
            return _table(element, [_cast(flat[:, i], p) for i, p in enumerate(element.properties)], {}), end
        values: list[list[float]] = [[] for _ in element.properties]
        counts: list[list[int]] = [[] for _ in element.properties]
        for _ in range(element.count):
            for i, p in enumerate(element.properties):
                n = 1
                if p.length:
                    n, at = int(words[at]), at + 1
                    counts[i].append(n)
                if n < 0 or at + n > len(words):
                    raise _truncated(element, name)
                values[i].extend(map(float, words[at : at + n]))
                at += n
    except IndexError as error:
        raise _truncated(element, name) from error
    except (ValueError, OverflowError) as error:
        message = f"{name}: a row of {printable(element.name, 20)!r} is not numbers ({printable(str(error), 60)})"
        message += "; export it again"
        raise Rejected(codes.BAD_NUMBER, message) from error
    columns = [_cast(np.array(v, dtype=np.float64), p) for v, p in zip(values, element.properties, strict=True)]
    return _table(element, columns, {i: np.array(n, dtype=np.int64) for i, n in enumerate(counts)}), at


def _cast(column: Floats, p: Property) -> npt.NDArray[np.generic]:
    """Text columns keep their kind (bytes mean 0..255, floats 0..1), as far as the values fit."""
    if p.dtype[0] == "f":
        return column
    limits = np.iinfo(p.dtype)
    return np.clip(np.nan_to_num(column), limits.min, limits.max).astype(p.dtype)


def references(data: bytes, name: str) -> list[Reference]:
    """Pictures that the header names."""
    header = read_header(data.lstrip(b" \t\r\n"), name)
    return [Reference(t, Role.IMAGE) for t in header.textures]


def load(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of a PLY; the format declares neither unit nor up axis."""
    name = printable(bundle.main)
    data = bundle.files[bundle.main].lstrip(b" \t\r\n")
    header = read_header(data, name)
    check_lengths(data, header, name)
    for element in header.elements:
        if element.name == "face":
            check_face_count(element.count, limits, name)
        elif element.name == "vertex":
            check_face_count(element.count // 3, limits, name)
    tables = read_tables(data, header, name)
    vertex = tables.get("vertex")
    if vertex is None or not {"x", "y", "z"} <= vertex.scalars.keys():
        raise Rejected(codes.NO_GEOMETRY, f"{name}: the PLY has no vertices with x, y, z; export it again")
    vertices = _columns(vertex, ("x", "y", "z"))
    lists = tables["face"].lists if "face" in tables else {}
    indices = lists.get("vertex_indices", lists.get("vertex_index", (np.zeros(0), np.zeros(0, dtype=np.int64))))
    check_face_count(int(np.maximum(indices[1] - 2, 0).sum()), limits, name)
    corners, polygons, fanned = _faces(indices[0].astype(np.int64), indices[1], vertices, name, notes)
    check_face_count(len(corners), limits, name)
    if fanned:
        notes.add(codes.POLYGON_FAN, "face", f"{fanned} concave or crossed faces were cut as fans")
    part = ReadPart("part", vertices, corners, _material(bundle, header.textures, limits, notes))
    if {"nx", "ny", "nz"} <= vertex.scalars.keys():
        part.normals = _columns(vertex, ("nx", "ny", "nz"))
    part.colors = _colors(vertex, notes)
    uv_names = next((pair for pair in _UV_NAMES if set(pair) <= vertex.scalars.keys()), None)
    part.uv = None if uv_names is None else _columns(vertex, uv_names)
    if part.uv is None and len(corners):
        _spread_corner_uv(part, tables["face"], polygons, notes)
    return raw_model([part], notes, name, Format.PLY)


def _columns(table: Table, names: tuple[str, ...]) -> Floats:
    return np.column_stack([table.scalars[n].astype(np.float64) for n in names])


def _faces(flat: Ints, lengths: Ints, vertices: Floats, name: str, notes: Notes) -> tuple[Ints, Ints, int]:
    """(T, 3) vertices, (T, 4) face and its three corner numbers, and the count of faces cut as fans.

    Args:
        flat: vertex of each corner, face after face. lengths: (F,) corners of each face.
    """
    if len(flat) and not 0 <= int(flat.min()) <= int(flat.max()) < len(vertices):
        message = f"{name}: a face names vertex {int(flat.max())} of {len(vertices)}; export the file again"
        raise Rejected(codes.OUT_OF_BOUNDS, message)
    dropped = int((lengths < 3).sum())
    if dropped:
        notes.add(codes.FACE_DROPPED, "face", f"{dropped} faces with fewer than three corners were dropped")
    starts = np.cumsum(lengths) - lengths
    places, owner, fanned = cut_whole(vertices, flat, starts, lengths, lengths >= 3)
    return flat[places], np.column_stack((owner, places - starts[owner][:, None])), fanned


def _spread_corner_uv(part: ReadPart, face: Table, origin: Ints, notes: Notes) -> None:
    """MeshLab keeps texture coordinates per corner: corners with the same vertex and uv become one vertex."""
    if "texcoord" not in face.lists:
        return
    flat, lengths = face.lists["texcoord"]
    starts = np.concatenate((np.zeros(1, dtype=np.int64), np.cumsum(lengths)[:-1]))
    needed = 2 * (int(origin[:, 1:].max()) + 1)
    if int(lengths.min()) < needed and (lengths[origin[:, 0]] < 2 * (origin[:, 1:].max(axis=1) + 1)).any():
        notes.add(codes.BAD_UV, "face/texcoord", "some faces have no texture coordinates; all are left out")
        return
    place = (starts[origin[:, :1]] + 2 * origin[:, 1:]).reshape(-1)
    uv = np.column_stack((flat[place], flat[place + 1])).astype(np.float64)
    corner = part.faces.reshape(-1)
    rows = np.column_stack((corner.astype(np.float64), uv))
    _, first, faces = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    keep = corner[first]
    part.vertices, part.uv, part.faces = part.vertices[keep], uv[first], faces.reshape(-1, 3).astype(np.int64)
    part.normals = None if part.normals is None else part.normals[keep]
    part.colors = None if part.colors is None else part.colors[keep]


def _colors(vertex: Table, notes: Notes) -> npt.NDArray[np.uint8] | None:
    """(V, 4) sRGB bytes: integer columns are 0..255, float columns 0..1."""
    names = next((n for n in _COLOR_NAMES if set(n) <= vertex.scalars.keys()), None)
    if names is None:
        return None
    scale = 1.0 if vertex.scalars[names[0]].dtype.kind in "iu" else 255.0
    values = _columns(vertex, names) * scale
    if not np.isfinite(values).all():
        notes.add(codes.BAD_COLOR, "vertex", "vertex colours hold NaN; left out")
        return None
    return rgba(values)


def _material(bundle: Bundle, textures: list[str], limits: Mapping[str, float], notes: Notes) -> Material:
    """White where a picture or vertex colours give the colour; the picture is the first `comment TextureFile`."""
    if len(textures) > 1:
        notes.add(codes.FEATURE_IGNORED, "header", f"{len(textures)} texture files; only the first is used")
    texture = None
    if textures and textures[0] in bundle.files:
        texture = Images(limits, notes).texture(textures[0], bundle.files[textures[0]], "color", ImageUse())
    if texture is None:
        return Material(id="material")
    return Material(id="material", base_color=(1.0, 1.0, 1.0, 1.0), base_color_texture=texture)
