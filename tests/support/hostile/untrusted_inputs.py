"""Loose meshes as they come from unknown authors, each with one defect that a filter has to find."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from casa_assets.model.asset.asset import Asset, Inertial, Link, Provenance, Site, Visual
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Affordance, Category, MatterFill, RestingPose, SizeRange
from tests.support.asset.asset_parts import CARDBOARD, box_collider, box_inertial, labels
from tests.support.asset.assets import category as row_of
from tests.support.mesh.meshes import box_mesh, lathe, some, texture

UNTRUSTED = Provenance(source="folder", path="tests", sha256="0" * 64, title="Test", author="Casa", licence="CC0-1.0")
SIZE: Vec3 = (0.06, 0.06, 0.12)
BROWN = (0.3, 0.15, 0.05, 1.0)
CUP = [(0.0, 0.006), (0.034, 0.006), (0.034, 0.09), (0.04, 0.09), (0.04, 0.0), (0.0, 0.0)]


def loose(
    *meshes: Mesh,
    boxes: tuple[tuple[Vec3, Vec3], ...] = ((SIZE, (0.0, 0.0, SIZE[2] / 2)),),
    inertial: Inertial | None = None,
    look: Material | None = None,
    kind: str = "carton",
    sites: tuple[Site, ...] = (),
) -> Asset:
    """A rigid thing that shows the meshes, and is touched by boxes of (full size, centre)."""
    material = look or Material(id="print", base_color=BROWN, substance="cardboard")
    size, center = boxes[0]
    link = Link(
        name="object",
        inertial=inertial or box_inertial(300 * math.prod(size), size, center),
        visuals=tuple(Visual(name=f"part_{i}", mesh=m, material="print") for i, m in enumerate(meshes)),
        colliders=tuple(box_collider(f"shape_{i}", size, at) for i, (size, at) in enumerate(boxes)),
    )
    return Asset(
        id=f"{kind}_0123456789",
        links=(link,),
        sites=sites,
        materials=(material,),
        substances=(CARDBOARD,),
        labels=labels(kind, (kind, "packaging"), "Q838692"),
        provenance=UNTRUSTED,
    )


def kind_of(
    asset: Asset,
    size: Vec3 = SIZE,
    build: MatterFill = MatterFill.SOLID,
    upright: RestingPose = RestingPose.STANDS,
    affords: tuple[Affordance, ...] = (),
) -> Category:
    """A registry row of things up to a fifth larger or smaller than `size`."""
    spans = tuple(SizeRange(low=0.8 * s, typical=s, high=1.2 * s) for s in size)
    longest = max(spans, key=lambda s: s.typical)
    return row_of(asset).replace(size_m=spans, longest_m=longest, build=build, upright=upright, affords=affords)


def carton(size: Vec3 = SIZE, center: Vec3 | None = None) -> Mesh:
    """A closed box on the ground."""
    return box_mesh(size, (0.0, 0.0, size[2] / 2) if center is None else center)


def without_side(mesh: Mesh, normal: Vec3) -> Mesh:
    """A box mesh less the triangles that face along `normal`."""
    keep = (some(mesh.normals)[mesh.faces[:, 0]] @ np.array(normal)) < 0.5
    return mesh.replace(faces=mesh.faces[keep])


def with_hole(side_m: float) -> Mesh:
    """A closed box but for a square hole in its top, without a thickness."""
    x, y, z = SIZE
    signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    rims = [[a * u / 2, b * v / 2, z] for u, v in ((x, y), (side_m, side_m)) for a, b in signs]
    rest = without_side(carton(), (0.0, 0.0, 1.0))
    start = len(rest.vertices)
    ring = [f for i in range(4) for j in [(i + 1) % 4] for f in ((i, j, 4 + i), (j, 4 + j, 4 + i))]
    faces = np.concatenate([rest.faces, np.array(ring) + start])
    return Mesh(vertices=np.concatenate([rest.vertices, rims]), faces=faces)


def crossed_cards() -> tuple[Mesh, ...]:
    """Two upright sheets through each other, as games show plants."""
    one = np.array([[-0.03, 0.0, 0.0], [0.03, 0.0, 0.0], [0.03, 0.0, 0.12], [-0.03, 0.0, 0.12]])
    faces = [(0, 1, 2), (0, 2, 3), (2, 1, 0), (3, 2, 0)]
    return Mesh(vertices=one, faces=faces), Mesh(vertices=one[:, [1, 0, 2]], faces=faces)


def mixed() -> Mesh:
    """A closed box of many triangles, every third one of which is turned."""
    fine = lathe([(0.0, 0.12), (0.03, 0.12), (0.03, 0.06), (0.03, 0.0), (0.0, 0.0)], 24)
    faces = fine.faces.copy()
    faces[::3] = faces[::3, ::-1]
    return fine.replace(faces=faces)


def painted(pixels: npt.NDArray[np.uint8]) -> Asset:
    """A closed box, each of whose sides shows the whole picture."""
    return loose(carton(), look=Material(id="print", base_color_texture=skin(pixels), substance="cardboard"))


def skin(pixels: npt.NDArray[np.uint8]) -> Texture:
    return texture("skin", pixels)


def checkers(side: int, blocks: int) -> npt.NDArray[np.uint8]:
    """A red and white picture of `side` pixels with so many fields along a side."""
    at = np.arange(side) * blocks // side
    field = (at[:, None] + at[None]) % 2
    return np.array([[250, 250, 250], [200, 20, 20]], dtype=np.uint8)[field]


def blurred(side: int, waves: int) -> npt.NDArray[np.uint8]:
    """A picture of soft waves, many pixels to each."""
    swing = np.sin(np.arange(side) / side * 2 * math.pi * waves)
    grey = np.rint(128 + 60 * (swing[:, None] + swing[None]) / 2).astype(np.uint8)
    return np.stack([grey, grey // 2, grey // 3], axis=2)


def cup(profile: list[tuple[float, float]] | None = None) -> Mesh:
    return lathe(CUP if profile is None else profile, 32)


def held(width: float) -> Site:
    """Where a hand takes it."""
    return Site(name="grasp_body", pose=Pose(position=(0.0, 0.0, 0.06)), kind="box", size=(width, 0.02, 0.02))
