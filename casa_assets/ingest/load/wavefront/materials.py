"""Wavefront MTL text -> material descriptions, and those -> Material."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.image import Images, ImageUse, Pixels, linear_from_srgb
from casa_assets.ingest.load.names import UniqueNames
from casa_assets.ingest.load.notes import Notes, printable
from casa_assets.ingest.load.text import decode, normalize_text
from casa_assets.model.asset.material import ColorSpace, Material, Texture

# Options before a file name and the most arguments each takes. Ref: Wavefront MTL specification, texture map options
_OPTIONS = {
    "-blendu": 1, "-blendv": 1, "-bm": 1, "-boost": 1, "-cc": 1, "-clamp": 1, "-imfchan": 1, "-mm": 2,
    "-o": 3, "-s": 3, "-t": 3, "-texres": 1, "-type": 1, "-colorspace": 1,
}  # fmt: skip
_NUMERIC = frozenset({"-o", "-s", "-t", "-mm"})
MAPS = frozenset({"map_kd", "map_bump", "bump", "norm", "map_kn", "map_norm", "map_pr", "map_pm"})
_UNSET = (0.8, 0.8, 0.8)


@dataclass
class MtlEntry:
    """One `newmtl` block.

    Attributes:
        color: Kd, sRGB display values in 0..1.
        alpha: d, or 1 - Tr; has_alpha: it came from d.
        shininess: Ns, or None.
        specular: greatest channel of Ks, or None.
        roughness, metallic: Pr, Pm of the PBR extension, or None.
        maps: keyword in lower case -> file name as written.
    """

    color: tuple[float, float, float] = _UNSET
    alpha: float = 1.0
    has_alpha: bool = False
    shininess: float | None = None
    specular: float | None = None
    roughness: float | None = None
    metallic: float | None = None
    maps: dict[str, str] = field(default_factory=dict)


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
            if not after.strip() or (word.lower() in _NUMERIC and index > 0 and not _is_number(value)):
                break
            rest = after.strip()
    return rest.strip('"')


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


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
            _set_value(entry, key, rest, name, notes)
    return out


def _set_value(entry: MtlEntry, key: str, rest: str, name: str, notes: Notes) -> None:
    try:
        values = [float(word) for word in rest.split()[:3] if not word.startswith("-halo")]
    except ValueError:
        values = []
    if not values or not all(math.isfinite(v) for v in values):
        notes.add(codes.BAD_VALUE, f"{name}/{key}", f"{key} {printable(rest, 40)!r} is not a number; ignored")
        return
    first = values[0]
    if key == "kd":
        r, g, b = values if len(values) == 3 else (first, first, first)
        entry.color = (r, g, b)
    elif key == "ks":
        entry.specular = max(values)
    elif key == "d":
        entry.alpha, entry.has_alpha = first, True
    elif key == "tr":
        # files with both disagree about what Tr means; d has one meaning only
        entry.alpha = entry.alpha if entry.has_alpha else 1.0 - first
    elif key == "ns":
        entry.shininess = first
    elif key == "pr":
        entry.roughness = first
    else:
        entry.metallic = first


@dataclass
class Materials:
    """Turns MTL entries into Materials, each once."""

    files: Mapping[str, bytes]
    images: Images
    notes: Notes
    names: UniqueNames = field(default_factory=UniqueNames)

    def material(self, name: str, entry: MtlEntry) -> Material:
        """Material of one entry; pictures that cannot be read are left out with a note."""
        color_map = self._texture(entry.maps.get("map_kd"), f"{name}_color")
        # With a picture, Kd is a leftover of the exporter as often as a tint: the picture is shown as it is.
        r, g, b = (1.0, 1.0, 1.0) if color_map else tuple(linear_from_srgb(c) for c in entry.color)
        alpha = min(1.0, max(0.0, entry.alpha))
        if alpha == 0.0:
            self.notes.add(codes.FULLY_TRANSPARENT, name, "d 0 (or Tr 1) would hide it; made opaque")
            alpha = 1.0
        rough_map, has_rough, has_metal = self._rough_map(entry, name)
        return Material(
            id=self.names.unique(name, "material"),
            base_color=(r, g, b, alpha),
            metallic=1.0 if has_metal else min(1.0, max(0.0, entry.metallic or 0.0)),
            roughness=1.0 if has_rough else _roughness(entry),
            base_color_texture=color_map,
            metallic_roughness_texture=rough_map,
            normal_texture=self._normal_map(entry, name),
        )

    def _texture(self, file: str | None, name: str) -> Texture | None:
        data = self.files.get(file) if file else None
        return None if data is None or file is None else self.images.texture(file, data, name, ImageUse())

    def _pixels(self, file: str | None) -> Pixels | None:
        data = self.files.get(file) if file else None
        return None if data is None or file is None else self.images.pixels(file, data)

    def _normal_map(self, entry: MtlEntry, name: str) -> Texture | None:
        """`norm` is a normal map; `bump` may be one or a height map, which only its colours tell."""
        for key in ("norm", "map_norm", "map_kn", "map_bump", "bump"):
            pixels = self._pixels(entry.maps.get(key))
            if pixels is None:
                continue
            if key in ("map_bump", "bump") and not _looks_like_normals(pixels):
                self.notes.add(codes.FEATURE_IGNORED, f"{name}/{key}", "a height map, not a normal map; left out")
                continue
            return self.images.encode(np.ascontiguousarray(pixels[:, :, :3]), f"{name}_normal", ColorSpace.RAW)
        return None

    def _rough_map(self, entry: MtlEntry, name: str) -> tuple[Texture | None, bool, bool]:
        """map_Pr and map_Pm packed as glTF has them: green roughness, blue metallic."""
        rough, metal = self._pixels(entry.maps.get("map_pr")), self._pixels(entry.maps.get("map_pm"))
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


def _roughness(entry: MtlEntry) -> float:
    """0..1 from Pr, or from Ns as Blender's exporter maps it, or matt."""
    if entry.roughness is not None:
        return min(1.0, max(0.0, entry.roughness))
    return roughness_of_shininess(entry.shininess, entry.specular)


def roughness_of_shininess(shininess: float | None, specular: float | None = None) -> float:
    """0..1 from Ns in 0..1000, None: matt. A thing without a highlight (`specular` near 0) is matt too.

    Ref: Blender's wavefront_obj exporter, Ns = 1000 (1 - roughness)^2.
    """
    if shininess is None:
        return 0.6
    guess = 1.0 - math.sqrt(min(1000.0, max(0.0, shininess)) / 1000.0)
    floor = 0.6 if specular is not None and specular < 0.01 else 0.05
    return max(floor, guess)


def _looks_like_normals(pixels: Pixels) -> bool:
    """Tangent-space normals are bluish: z near 1, x and y near the middle."""
    red, green, blue = (float(pixels[:, :, i].mean()) for i in range(3))
    return blue > 170 and abs(red - 128) < 40 and abs(green - 128) < 40
