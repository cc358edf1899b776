"""Wavefront OBJ and MTL -> RawModel: one part per object and material; numbers are parsed by numpy."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from casa_assets.core.numeric import Floats, Ints
from casa_assets.errors import Rejected
from casa_assets.formats.read.formats import Format, Reference, Role
from casa_assets.formats.read.guarded_xml import number_of
from casa_assets.formats.read.materials import Images, ImageUse, Pixels, linear_from_srgb, roughness_of_shininess
from casa_assets.formats.read.raw_parts import ReadPart, check_face_count, merged_corners, raw_model, rgba, triangulate
from casa_assets.formats.read.text import Notes, UniqueNames, decode, normalize_text, numbers, parsed_numbers, printable
from casa_assets.model import rejection_codes as codes
from casa_assets.model.asset.material import ColorSpace, Material, Texture
from casa_assets.model.source import Bundle, RawModel

# Options before a file name and the most arguments each takes. Ref: Wavefront MTL specification, texture map options
_OPTIONS = {
    "-blendu": 1, "-blendv": 1, "-bm": 1, "-boost": 1, "-cc": 1, "-clamp": 1, "-imfchan": 1, "-mm": 2,
    "-o": 3, "-s": 3, "-t": 3, "-texres": 1, "-type": 1, "-colorspace": 1,
}  # fmt: skip
MAPS = frozenset({"map_kd", "map_bump", "bump", "norm", "map_kn", "map_norm", "map_pr", "map_pm"})
# Statements that run or include something. Ref: Wavefront OBJ specification, "general statements"
_DIRECTIVES = frozenset({b"call", b"csh", b"shadow_obj", b"trace_obj", b"ctech", b"stech"})
MAX_GROUPS_AS_OBJECTS = 64


@dataclass
class MtlEntry:
    """One `newmtl` block.

    Attributes:
        values: keyword in lower case -> its numbers. Kd and Ks are display values in 0..1, Pr and Pm roughness and
            metallic of the PBR extension.
        maps: keyword in lower case -> file name as written.
    """

    values: dict[str, list[float]] = field(default_factory=dict)
    maps: dict[str, str] = field(default_factory=dict)

    def first(self, key: str) -> float | None:
        """First number of a keyword, None if it is not given."""
        return self.values[key][0] if key in self.values else None


def map_file(arguments: str) -> str:
    """File name of a map statement, options such as `-o 0 0 0 -bm 1` stripped; names may hold spaces."""
    rest = arguments.strip()
    while rest.startswith("-"):
        word, _, after = rest.partition(" ")
        max_arguments = _OPTIONS.get(word.lower())
        if max_arguments is None:
            break
        rest = after.strip()
        for index in range(max_arguments):
            value, _, after = rest.partition(" ")
            is_optional = word.lower() in ("-o", "-s", "-t", "-mm") and index > 0
            if not after.strip() or (is_optional and math.isnan(number_of(value)) and value.lower() != "nan"):
                break
            rest = after.strip()
    return rest.strip('"')


def statements(data: bytes, name: str) -> list[tuple[str, str]]:
    """(keyword in lower case, rest of the line) of every statement of an MTL file."""
    out = []
    for line in normalize_text(data, name).replace(b"\\\n", b" ").split(b"\n"):
        words = decode(line).strip().replace("\t", " ").split(" ", 1)
        if len(words) == 2 and not words[0].startswith("#"):
            out.append((words[0].lower(), words[1].strip()))
    return out


def parse_mtl(data: bytes, name: str, notes: Notes) -> dict[str, MtlEntry]:
    """Materials of one MTL file by name. Raises Rejected ENCODING where it is no text."""
    out: dict[str, MtlEntry] = {}
    entry = MtlEntry()
    for key, rest in statements(data, name):
        if key == "newmtl":
            entry = out.setdefault(rest, MtlEntry())
        elif key in MAPS:
            entry.maps[key] = map_file(rest)
        elif key in ("kd", "ks", "d", "tr", "ns", "pr", "pm"):
            try:
                values = [float(word) for word in rest.split()[:3] if not word.startswith("-halo")]
            except ValueError:
                values = []
            if values and all(math.isfinite(v) for v in values):
                entry.values[key] = values
            else:
                notes.add(codes.BAD_VALUE, f"{name}/{key}", f"{key} {printable(rest, 40)!r} is not a number; ignored")
    return out


@dataclass
class Materials:
    """Turns MTL entries into Materials, each once."""

    files: Mapping[str, bytes]
    images: Images
    notes: Notes
    names: UniqueNames = field(default_factory=UniqueNames)

    def material(self, name: str, entry: MtlEntry) -> Material:
        """Material of one entry; pictures that cannot be read are left out with a note."""
        file = entry.maps.get("map_kd", "")
        data = self.files.get(file)
        color_map = None if data is None else self.images.texture(file, data, f"{name}_color", ImageUse())
        # With a picture, Kd is a leftover of the exporter as often as a tint: the picture is shown as it is.
        color = entry.values.get("kd", [0.8, 0.8, 0.8])
        color = color if len(color) == 3 else color[:1] * 3
        r, g, b = (1.0, 1.0, 1.0) if color_map else tuple(linear_from_srgb(c) for c in color)
        # Files with both disagree about what Tr means; d has one meaning only.
        alpha = entry.first("d")
        alpha = min(1.0, max(0.0, 1.0 - (entry.first("tr") or 0.0) if alpha is None else alpha))
        if alpha == 0.0:
            self.notes.add(codes.FULLY_TRANSPARENT, name, "d 0 (or Tr 1) would hide it; made opaque")
            alpha = 1.0
        rough_map, has_rough, has_metal = self._rough_map(entry, name)
        specular = max(entry.values["ks"]) if "ks" in entry.values else None
        roughness = entry.first("pr")
        if roughness is None:
            roughness = roughness_of_shininess(entry.first("ns"), specular)
        return Material(
            id=self.names.unique(name, "material"),
            base_color=(r, g, b, alpha),
            metallic=1.0 if has_metal else min(1.0, max(0.0, entry.first("pm") or 0.0)),
            roughness=1.0 if has_rough else min(1.0, max(0.0, roughness)),
            base_color_texture=color_map,
            metallic_roughness_texture=rough_map,
            normal_texture=self._normal_map(entry, name),
        )

    def _pixels(self, file: str) -> Pixels | None:
        data = self.files.get(file)
        return None if data is None else self.images.pixels(file, data)

    def _normal_map(self, entry: MtlEntry, name: str) -> Texture | None:
        """The normal map: `norm`, or `bump`, which may be a height map instead; only its colours show which.

        Tangent-space normals are bluish: z near 1, x and y near the middle.
        """
        for key in ("norm", "map_norm", "map_kn", "map_bump", "bump"):
            pixels = self._pixels(entry.maps.get(key, ""))
            if pixels is None:
                continue
            red, green, blue = (float(pixels[:, :, i].mean()) for i in range(3))
            is_bluish = blue > 170 and abs(red - 128) < 40 and abs(green - 128) < 40
            if key in ("map_bump", "bump") and not is_bluish:
                self.notes.add(codes.FEATURE_IGNORED, f"{name}/{key}", "a height map, not a normal map; left out")
                continue
            return self.images.encode(np.ascontiguousarray(pixels[:, :, :3]), f"{name}_normal", ColorSpace.RAW)
        return None

    def _rough_map(self, entry: MtlEntry, name: str) -> tuple[Texture | None, bool, bool]:
        """map_Pr and map_Pm packed as glTF has them: green roughness, blue metallic."""
        rough, metal = self._pixels(entry.maps.get("map_pr", "")), self._pixels(entry.maps.get("map_pm", ""))
        if rough is None and metal is None:
            return None, False, False
        if rough is not None and metal is not None and rough.shape[:2] != metal.shape[:2]:
            self.notes.add(codes.FEATURE_IGNORED, f"{name}/map_Pm", "its size is not that of map_Pr; left out")
            metal = None
        given = [p for p in (rough, metal) if p is not None]
        packed = np.full((*given[0].shape[:2], 3), 255, dtype=np.uint8)
        if rough is not None:
            packed[:, :, 1] = rough[:, :, 0]
        if metal is not None:
            packed[:, :, 2] = metal[:, :, 0]
        return self.images.encode(packed, f"{name}_rough", ColorSpace.RAW), rough is not None, metal is not None


@dataclass
class FaceBucket:
    """Faces with the same number of corners, written in the same form.

    Attributes:
        corners: n of each face.
        form: `v`, `vt`, `vn` or `vtn`: which indices each corner has.
        text: `1/2/3 4/5/6 ...` of each face.
        order: place of each face among all.
        group: number of (object, material) of each face.
        seen: count of v, vt, vn read before each face, only where an index is negative.
    """

    corners: int
    form: str
    text: list[bytes] = field(default_factory=list)
    order: list[int] = field(default_factory=list)
    group: list[int] = field(default_factory=list)
    seen: list[tuple[int, int, int]] = field(default_factory=list)


@dataclass
class ObjLines:
    """All statements of an OBJ that matter.

    Attributes:
        v, vt, vn: the numbers of each line, as text.
        faces: buckets by (corners, form, whether negative).
        groups: (object, material) in order of first use.
        libraries: mtllib arguments as written.
        bad_faces: lines that name no triangle.
        face_count: faces that name three corners or more.
    """

    v: list[bytes] = field(default_factory=list)
    vt: list[bytes] = field(default_factory=list)
    vn: list[bytes] = field(default_factory=list)
    faces: dict[tuple[int, str, bool], FaceBucket] = field(default_factory=dict)
    groups: list[tuple[str, str]] = field(default_factory=list)
    libraries: list[str] = field(default_factory=list)
    bad_faces: int = 0
    face_count: int = 0


def read_lines(data: bytes, notes: Notes) -> ObjLines:
    """Sort the lines of a plain OBJ text (see text.plain)."""
    if b"\\\n" in data:
        data = data.replace(b"\\\n", b" ")
    # Some exporters name their objects by `g`; others write a group for every smooth patch.
    has_objects = data.startswith(b"o ") or b"\no " in data or b"\no\t" in data
    use_groups = False
    if not has_objects and data.count(b"\ng ") < 10_000:
        use_groups = 0 < len({line for line in data.split(b"\n") if line.startswith(b"g ")}) <= MAX_GROUPS_AS_OBJECTS
    out = ObjLines()
    tables = {b"v": out.v, b"vt": out.vt, b"vn": out.vn}
    known: dict[tuple[str, str], int] = {}
    thing, material, group = "", "", -1
    for line in data.split(b"\n"):
        words = line.split(None, 1)
        if len(words) < 2:
            out.bad_faces += words == [b"f"]
            continue
        key, rest = words
        table = tables.get(key)
        if table is not None:
            table.append(rest)
        elif key == b"f":
            if group < 0:
                group = known.setdefault((thing, material), len(known))
            _add_face(out, rest, group)
        elif key == b"usemtl":
            material, group = decode(rest).strip(), -1
        elif key == b"o" or (use_groups and key == b"g"):
            thing, group = decode(rest).strip(), -1
        elif key == b"mtllib":
            out.libraries.append(decode(rest).strip())
        elif key in _DIRECTIVES:
            notes.add(codes.DIRECTIVE_IGNORED, "directives", "statements that run or include something are ignored")
    out.groups = list(known)
    return out


def _add_face(out: ObjLines, rest: bytes, group: int) -> None:
    if b"#" in rest:
        rest = rest.partition(b"#")[0]
    corners = len(rest.split())
    slashes = rest.count(b"/")
    if corners < 3:
        out.bad_faces += 1
        return
    if slashes == 0:
        form = "v"
    elif slashes == corners:
        form = "vt"
    elif slashes == 2 * corners:
        form = "vn" if rest.count(b"//") == corners else "vtn"
    else:
        form = "mixed"
    if form == "mixed" or (form == "vtn" and b"//" in rest) or b"/ " in rest or rest.rstrip().endswith(b"/"):
        # rare: only the vertex of each corner is kept
        rest, form = b" ".join(word.partition(b"/")[0] for word in rest.split()), "v"
    is_negative = b"-" in rest
    bucket = out.faces.get((corners, form, is_negative))
    if bucket is None:
        bucket = out.faces[corners, form, is_negative] = FaceBucket(corners, form)
    bucket.text.append(rest)
    bucket.order.append(out.face_count)
    bucket.group.append(group)
    if is_negative:
        bucket.seen.append((len(out.v), len(out.vt), len(out.vn)))
    out.face_count += 1


def corner_indices(bucket: FaceBucket) -> Ints:
    """(F, n, k) indices as written, k as the form has; a face that cannot be parsed is all 0, which no vertex is."""
    kinds = len(bucket.form)
    joined = b" ".join(bucket.text).replace(b"/", b" ")
    values = parsed_numbers(joined)
    wanted = len(bucket.text) * bucket.corners * kinds
    if values is not None and len(values) == wanted:
        integers = np.clip(np.nan_to_num(values), -1e15, 1e15)
        return np.where(integers == np.floor(integers), integers, 0).astype(np.int64).reshape(-1, bucket.corners, kinds)
    out = np.zeros((len(bucket.text), bucket.corners, kinds), dtype=np.int64)
    for i, text in enumerate(bucket.text):
        words = text.replace(b"/", b" ").split()
        if len(words) == bucket.corners * kinds and all(re.fullmatch(rb"[+-]?\d{1,15}", w) for w in words):
            out[i] = np.array([int(w) for w in words]).reshape(bucket.corners, kinds)
    return out


def references(data: bytes, name: str) -> list[Reference]:
    """Material files, as written."""
    found = re.findall(rb"^[ \t]*mtllib[ \t]+([^\n]+)", normalize_text(data, name), re.MULTILINE)
    return [Reference(decode(f).strip(), Role.MATERIAL) for f in found]


def material_references(data: bytes, name: str) -> list[Reference]:
    """Pictures of an MTL file that are read, as written. Raises Rejected ENCODING where it is no text."""
    return [Reference(map_file(rest), Role.IMAGE) for key, rest in statements(data, name) if key in MAPS]


def load(bundle: Bundle, limits: Mapping[str, float], notes: Notes) -> RawModel:
    """RawModel of an OBJ; the format declares neither unit nor up axis."""
    name = printable(bundle.main)
    lines = read_lines(normalize_text(bundle.files[bundle.main], name), notes)
    if not lines.v and not lines.face_count:
        raise Rejected(codes.EMPTY_FILE, f"{name}: holds neither vertices nor faces; fetch or export it again")
    check_face_count(sum(len(b.text) * (b.corners - 2) for b in lines.faces.values()), limits, name)
    vertices = numbers(lines.v, 3, 7, "v")
    uvs = numbers(lines.vt, 1, 2, "vt")
    normals = numbers(lines.vn, 3, 3, "vn")
    triangles = _triangles(lines, vertices[:, :3], (len(uvs), len(normals)), name, notes)
    check_face_count(len(triangles[0]), limits, name)
    corners, groups = triangles
    if not len(corners):
        bare = ReadPart("part", vertices[:, :3], np.zeros((0, 3), dtype=np.int64), Material(id="none"))
        return raw_model([bare], notes, name, Format.OBJ)
    materials = _materials(bundle, lines, limits, notes)
    colors = _colors(vertices, notes)
    parts = []
    for number, (object_name, material) in enumerate(lines.groups):
        used = corners[groups == number].reshape(-1, 3)
        if len(used):
            name_of_part = object_name or material or "part"
            part = _read_part(name_of_part, used, vertices[:, :3], uvs, normals, colors, materials[material])
            part.nodes = (object_name,) if object_name else ()
            parts.append(part)
    return raw_model(parts, notes, name, Format.OBJ)


def _triangles(
    lines: ObjLines, vertices: Floats, others: tuple[int, int], name: str, notes: Notes
) -> tuple[Ints, Ints]:
    """(T, 3, 3) v, vt, vn of the corners of all triangles in file order, 0-based, -1 for none; (T,) group of each."""
    sizes = (len(vertices), *others)
    found: list[tuple[Ints, Ints, Ints]] = []
    bad = lines.bad_faces
    fanned = 0
    for bucket in lines.faces.values():
        raw = corner_indices(bucket)
        corners = np.full((*raw.shape[:2], 3), -1, dtype=np.int64)
        columns = {"v": (0,), "vt": (0, 1), "vn": (0, 2), "vtn": (0, 1, 2)}[bucket.form]
        seen = np.array(bucket.seen, dtype=np.int64).reshape(-1, 3)
        for k, column in enumerate(columns):
            index = raw[:, :, k]
            corners[:, :, column] = np.where(index < 0, index + seen[:, None, column] if len(seen) else -1, index - 1)
            outside = (corners[:, :, column] < 0) | (corners[:, :, column] >= sizes[column])
            corners[:, :, column][outside] = -1
        good = (corners[:, :, 0] >= 0).all(axis=1)
        bad += int((~good).sum())
        corners = corners[good]
        local, polygon, fans = triangulate(vertices[corners[:, :, 0]])
        fanned += fans
        tri = corners[polygon[:, None], local]
        order = np.array(bucket.order, dtype=np.int64)[good][polygon]
        group = np.array(bucket.group, dtype=np.int64)[good][polygon]
        found.append((tri, order, group))
    count = sum(len(order) for _, order, _ in found)
    if bad and not count:
        message = f"{name}: all {bad} faces name vertices that do not exist; export it again"
        raise Rejected(codes.OUT_OF_BOUNDS, message)
    if bad:
        message = f"{bad} faces with fewer than three corners or missing vertices were dropped"
        notes.add(codes.FACE_DROPPED, "f", message)
    if fanned:
        message = f"{fanned} concave or crossed faces were cut as fans; triangulate them first"
        notes.add(codes.POLYGON_FAN, "f", message)
    if not count:
        return np.zeros((0, 3, 3), dtype=np.int64), np.zeros(0, dtype=np.int64)
    every_tri, every_order, every_group = (np.concatenate([f[i] for f in found]) for i in range(3))
    sort = np.argsort(every_order, kind="stable")
    return every_tri[sort], every_group[sort]


def _read_part(
    name: str,
    corners: Ints,
    vertices: Floats,
    uvs: Floats,
    normals: Floats,
    colors: npt.NDArray[np.uint8] | None,
    material: Material,
) -> ReadPart:
    """Corners, (C, 3), with the same (v, vt, vn) become one vertex."""
    v, vt, vn = corners.T
    has_uv, has_normals = bool((vt >= 0).any()), bool((vn >= 0).all())
    first, faces = merged_corners([v, *([vt] if has_uv else []), *([vn] if has_normals else [])])
    return ReadPart(
        name=name,
        vertices=vertices[v[first]],
        faces=faces,
        material=material,
        uv=np.where((vt[first] >= 0)[:, None], uvs[vt[first]], 0.0) if has_uv else None,
        normals=normals[vn[first]] if has_normals else None,
        colors=None if colors is None else colors[v[first]],
    )


def _colors(vertices: Floats, notes: Notes) -> npt.NDArray[np.uint8] | None:
    """(V, 4) sRGB bytes of `v x y z r g b [a]`, in 0..1 or 0..255; None if the lines have no colours."""
    if not len(vertices) or np.isnan(vertices[:, 5]).all():
        return None
    rgb = vertices[:, 3:6]
    if not np.isfinite(rgb).all():
        notes.add(codes.BAD_COLOR, "v", "some vertex colours are missing or NaN; all are left out")
        return None
    scale = 255.0 if float(rgb.max()) <= 1.0 else 1.0
    return rgba(rgb * scale)


def _materials(bundle: Bundle, lines: ObjLines, limits: Mapping[str, float], notes: Notes) -> dict[str, Material]:
    entries: dict[str, MtlEntry] = {}
    libraries: dict[str, None] = {}
    for library in lines.libraries:
        for file in (library, *library.split()):
            if file in bundle.files and file != bundle.main and file not in libraries:
                libraries[file] = None
                if file == library:
                    break
    for file in libraries or sorted(f for f in bundle.files if f.lower().endswith(".mtl") and f != bundle.main):
        try:
            entries.update(parse_mtl(bundle.files[file], printable(file), notes))
        except Rejected as error:
            notes.add(codes.MATERIAL_MISSING, file, f"material file left out: {error.message}")
    by_case = {name.lower(): entry for name, entry in entries.items()}
    made = Materials(bundle.files, Images(limits, notes), notes)
    out: dict[str, Material] = {}
    for _, name in lines.groups:
        if name in out:
            continue
        entry = entries.get(name) or by_case.get(name.lower())
        if entry is None and not name and len(entries) == 1:
            entry = next(iter(entries.values()))
        if entry is None and name:
            message = f"material {printable(name, 40)!r} is not described; a grey one is used"
            notes.add(codes.MATERIAL_MISSING, name, message)
        out[name] = made.material(name or "material", entry or MtlEntry())
    return out
