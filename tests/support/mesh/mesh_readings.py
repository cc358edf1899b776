"""One mesh file as read by our readers and by trimesh, reduced to the same few facts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from lxml import etree
from scipy.spatial import cKDTree

from casa_assets.core.numeric import Floats, srgb_from_linear
from casa_assets.formats.read import load
from casa_assets.formats.read.ply import read_header, read_tables
from casa_assets.ingest.sources.discover import collect, discover
from casa_assets.ingest.sources.places import Found
from casa_assets.mesh.trimesh_exchange import placed_meshes
from casa_assets.model import rejection_codes
from casa_assets.model.asset.material import Material
from casa_assets.model.source import RawModel


@dataclass(frozen=True)
class Reading:
    """What a reader made of a file.

    `soup`: (T, 3, 3) corners of all triangles as drawn, file units and axes. `materials`: how many are used.
    `pictures`: size of each picture of base colours, sorted. `appearances`: how many materials are left when those of
    one colour (in steps of 1/255) and picture count once. `has_uv`, `has_colors`: whether any mesh has texture
    coordinates, or colours of vertices or faces. `notes`: codes of our remarks; none of trimesh.
    """

    soup: Floats
    materials: int
    pictures: tuple[tuple[int, int], ...]
    has_uv: bool
    has_colors: bool
    notes: frozenset[str] = frozenset()
    appearances: int = 0

    @property
    def area(self) -> float:
        """Area of all triangles, square units."""
        a, b, c = (self.soup[:, k] for k in range(3))
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)

    @property
    def bounds(self) -> Floats:
        """(2, 3) corners of the box around all triangles."""
        return np.array([self.soup.min(axis=(0, 1)), self.soup.max(axis=(0, 1))])


# Both readers compute in double precision from the same numbers, so they agree to this part of the size of the thing.
TOLERANCE = 1e-6


def differences(path: Path, one: Reading, other: Reading) -> list[str]:
    """What two readings of a file do not agree on, leaving out what is `explained`; empty where all is explained."""
    found: list[str] = []
    size = float(np.ptp(one.bounds, axis=0).max())
    if len(one.soup) != len(other.soup):
        found.append(f"triangles: {len(one.soup)} and {len(other.soup)}")
    # Polygons are cut into as many triangles by both readers, some of them along another diagonal, and a polygon is
    # small beside the thing. So this explains nothing in a file of triangles; the area of the whole is compared too.
    elif (far := _farthest(one, other)) > TOLERANCE * size and not (far < 0.02 * size and has_polygons(path)):
        found.append(f"a triangle without its like within {far / size:.2g} of the size")
    if np.abs(one.bounds - other.bounds).max() > TOLERANCE * size:
        found.append("bounds")
    # Two diagonals of a quad that is not quite flat give two areas.
    if abs(one.area - other.area) > (1e-5 if has_polygons(path) else TOLERANCE) * one.area:
        found.append(f"area: {one.area:.6g} and {other.area:.6g}")
    for name in ("materials", "pictures", "has_uv", "has_colors"):
        mine, theirs = getattr(one, name), getattr(other, name)
        if mine != theirs and not explained(path, name, one, other):
            found.append(f"{name}: {mine} and {theirs}")
    return found


def _farthest(one: Reading, other: Reading) -> float:
    """Largest distance from the middle of a triangle to the nearest middle in the other reading, both ways."""
    mine, theirs = one.soup.mean(axis=1), other.soup.mean(axis=1)
    return float(max(cKDTree(theirs).query(mine)[0].max(), cKDTree(mine).query(theirs)[0].max()))


def has_polygons(path: Path) -> bool:
    """Whether some face of an OBJ, PLY or COLLADA file has more than three corners; other formats have none."""
    kind, data = path.suffix.lower(), path.read_bytes()
    if kind == ".obj":
        lines = data.replace(b"\\\n", b" ").splitlines()
        return any(len(line.split()) > 4 for line in lines if line.lstrip().startswith((b"f ", b"f\t")))
    if kind == ".ply":
        face = read_tables(data, read_header(data, path.name), path.name).get("face")
        lengths = [counts for _, counts in face.lists.values()] if face is not None else []
        return any(bool((counts > 3).any()) for counts in lengths[:1])
    if kind == ".dae":
        root = etree.fromstring(data, etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=True))
        counts = " ".join(node.text or "" for node in root.iter("{*}vcount")).split()
        return any(int(count) > 3 for count in counts) or next(root.iter("{*}polygons"), None) is not None
    return False


def explained(path: Path, name: str, one: Reading, other: Reading) -> bool:
    """Whether a rule says why a fact is another in our reading (`one`) than in that of trimesh."""
    # trimesh gives COLLADA materials no name, so it cannot tell two of one colour and picture apart, and we can. Its
    # lower count is right only where it is the number of different appearances: a saucepan has six materials, two of
    # them the same black, and trimesh counts five. A material that one reader loses or paints otherwise stays one.
    is_one_color = path.suffix.lower() == ".dae" and other.materials == one.appearances
    match name:
        case "pictures" if not one.pictures and other.pictures == ((2, 2),):
            return True  # trimesh puts one of 2 x 2 pixels where there are texture coordinates and no picture
        case "pictures" | "materials" if len(other.pictures) < len(one.pictures):
            # trimesh opens nothing outside the folder of a mesh; we follow `..` within the package (Gazebo).
            is_outside = b"../" in path.read_bytes() or rejection_codes.FOUND_BY_BASE_NAME in one.notes
            return is_outside or (name == "materials" and is_one_color)
        case "materials":
            return is_one_color
        case "has_colors":
            # trimesh drops those of vertices where a PLY names a picture, missing or not; we keep them where it is.
            return one.has_colors and rejection_codes.REFERENCE_MISSING in one.notes and other.has_uv
    return False


def ours(path: Path, limits: dict[str, float]) -> Reading:
    """By the reader of this project. Raises Rejected."""
    (found,) = list(discover([path]))
    assert isinstance(found, Found), found
    model: RawModel = load(collect(found, limits), limits)
    looks = {p.material.id: p.material for p in model.parts}
    pictures = [m.base_color_texture for m in looks.values() if m.base_color_texture is not None]
    return Reading(
        soup=np.concatenate([p.mesh.vertices[p.mesh.faces] for p in model.parts]),
        materials=len(looks),
        pictures=_sizes((t.width_px, t.height_px) for t in pictures),
        has_uv=any(p.mesh.uv is not None for p in model.parts),
        has_colors=any(p.mesh.colors is not None for p in model.parts),
        notes=frozenset(n.code for n in model.notes),
        appearances=len({_appearance(m) for m in looks.values()}),
    )


def _appearance(material: Material) -> tuple[tuple[int, ...], bytes]:
    """Base colour as sRGB in steps of 1/255, as trimesh keeps it, and its picture."""
    *rgb, alpha = material.base_color
    color = (*(srgb_from_linear(channel) for channel in rgb), alpha)
    picture = material.base_color_texture
    return tuple(round(255 * channel) for channel in color), b"" if picture is None else picture.png


def theirs(path: Path) -> Reading:
    """By trimesh, as it reads a file: nothing merged, nothing repaired.

    Left to itself its scene graph takes a transform that is a rotation to within 1e-5 for one, and drops its scale: a
    lettuce whose node is scaled by 0.9999965 along z came out longer by 2e-6 of its size.
    """
    scene = trimesh.load_scene(path, process=False)
    scene.graph.repair_rigid = None
    scene.graph._cache.clear()
    placed = [p for p in placed_meshes(scene) if len(p.faces)]
    looks = [p.finish for p in placed]
    images = {id(f.images["base"]): f.images["base"] for f in looks if f is not None and "base" in f.images}
    keys = {(f.name, f.color, id(f.images.get("base"))) if f is not None else None for f in looks}
    return Reading(
        soup=np.concatenate([p.vertices[p.faces] for p in placed]),
        materials=len(keys),
        pictures=_sizes(image.size for image in images.values()),
        has_uv=any(p.uv is not None for p in placed),
        has_colors=any(p.colors is not None for p in placed),
    )


def _sizes(sizes: Iterable[tuple[int, int]]) -> tuple[tuple[int, int], ...]:
    return tuple(sorted(set(sizes)))
