"""One mesh file as read by our readers and by trimesh, reduced to the same few facts."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import trimesh
from scipy.spatial import cKDTree

from casa_assets.geometry.mesh.trimesh_exchange import placed_meshes
from casa_assets.ingest import rejection_codes
from casa_assets.ingest.load import load
from casa_assets.ingest.sources import Found, collect, discover
from casa_assets.model.ingest.source import RawModel

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Reading:
    """What a reader made of a file.

    Attributes:
        soup: (T, 3, 3) corners of all triangles as drawn, file units and axes.
        materials: how many are used. pictures: size of each picture of base colours, sorted.
        has_uv, has_colors: whether any mesh has texture coordinates, or colours of vertices or faces.
        notes: codes of our remarks; none of trimesh.
    """

    soup: Floats
    materials: int
    pictures: tuple[tuple[int, int], ...]
    has_uv: bool
    has_colors: bool
    notes: frozenset[str] = frozenset()

    @property
    def area(self) -> float:
        """Area of all triangles, square units."""
        a, b, c = (self.soup[:, k] for k in range(3))
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)

    @property
    def bounds(self) -> Floats:
        """(2, 3) corners of the box around all triangles."""
        return np.array([self.soup.min(axis=(0, 1)), self.soup.max(axis=(0, 1))])


def differences(path: Path, one: Reading, other: Reading) -> list[str]:
    """What two readings of a file do not agree on, leaving out what RULES explain; empty where all is explained."""
    found: list[str] = []
    size = float(np.ptp(one.bounds, axis=0).max())
    if len(one.soup) != len(other.soup):
        found.append(f"triangles: {len(one.soup)} and {len(other.soup)}")
    elif (far := _farthest(one, other)) > 1e-5 * size and not cut_along_other_diagonals(path, far / size):
        found.append(f"a triangle without its like within {far / size:.2g} of the size")
    if np.abs(one.bounds - other.bounds).max() > 1e-5 * size:
        found.append("bounds")
    if abs(one.area - other.area) > 1e-5 * one.area:
        found.append(f"area: {one.area:.6g} and {other.area:.6g}")
    for name in ("materials", "pictures", "has_uv", "has_colors"):
        mine, theirs = getattr(one, name), getattr(other, name)
        if mine != theirs and not any(rule(path, name, one, other) for rule in RULES):
            found.append(f"{name}: {mine} and {theirs}")
    return found


def _farthest(one: Reading, other: Reading) -> float:
    """Largest distance from the middle of a triangle to the nearest middle in the other reading, both ways."""
    mine, theirs = one.soup.mean(axis=1), other.soup.mean(axis=1)
    return float(max(cKDTree(theirs).query(mine)[0].max(), cKDTree(mine).query(theirs)[0].max()))


def cut_along_other_diagonals(path: Path, far: float) -> bool:
    """Polygons of OBJ, PLY and COLLADA are cut into as many triangles by trimesh, some along another diagonal.

    The area of the whole is compared too, and a polygon is small beside the thing: `far` is a part of its size.
    """
    return path.suffix.lower() in (".obj", ".ply", ".dae") and far < 0.02


def stands_in_for_a_picture(path: Path, name: str, one: Reading, other: Reading) -> bool:
    """trimesh puts a picture of 2 x 2 pixels where there are texture coordinates and no picture can be had."""
    return name == "pictures" and not one.pictures and other.pictures == ((2, 2),)


def colors_give_way_to_a_picture(path: Path, name: str, one: Reading, other: Reading) -> bool:
    """trimesh drops vertex colours where a PLY names a picture, missing or not; we keep them where it is missing."""
    return name == "has_colors" and one.has_colors and rejection_codes.REFERENCE_MISSING in one.notes and other.has_uv


def picture_beside_the_folder(path: Path, name: str, one: Reading, other: Reading) -> bool:
    """trimesh opens nothing outside the folder of a mesh; we follow `..` within the package (Gazebo)."""
    is_outside = b"../" in path.read_bytes() or rejection_codes.FOUND_BY_BASE_NAME in one.notes
    return name in ("pictures", "materials") and len(other.pictures) < len(one.pictures) and is_outside


def materials_of_one_color(path: Path, name: str, one: Reading, other: Reading) -> bool:
    """trimesh forgets the names of COLLADA materials, so those of one colour count once (two blacks of a saucepan)."""
    return name == "materials" and path.suffix.lower() == ".dae" and 0 < other.materials < one.materials


RULES = (materials_of_one_color, stands_in_for_a_picture, colors_give_way_to_a_picture, picture_beside_the_folder)


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
    )


def theirs(path: Path) -> Reading:
    """By trimesh, as it reads a file: nothing merged."""
    scene = trimesh.load_scene(path, process=False)
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
