"""A plain box as an asset, and one thing about it changed at a time: examples for the checks of assets."""

from __future__ import annotations

import math

import numpy as np

from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.model.asset.asset import Asset, Collider, Inertial, Visual
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Cylinder, Hull, Mesh
from casa_assets.model.record import Vec3
from tests.support.asset.asset_parts import CARDBOARD, PROVENANCE, box_collider, box_inertial, formed, link, named, seen
from tests.support.asset.assets import ball, microwave, peel, rigid_mug
from tests.support.mesh.meshes import box_mesh, texture

SIZE: Vec3 = (0.2, 0.06, 0.12)


def plain_box(size: Vec3 = SIZE, mass: float | None = None, up: float = 0.0) -> Asset:
    """A plain box of full `size` standing on the origin, `up` above the ground; 300 kg/m^3 unless it has a mass."""
    center: Vec3 = (0.0, 0.0, size[2] / 2 + up)
    weight = 300 * math.prod(size) if mass is None else mass
    looks, shape = seen("sides", "print", size, center), box_collider("whole", size, center)
    return Asset(
        **named("carton", "Q838692", "packaging"),
        links=(link("object", (weight, size, center), [looks], [shape]),),
        materials=(Material(id="print", substance="cardboard"),),
        substances=(CARDBOARD,),
    )


def as_dense_as(water: float) -> Asset:
    return plain_box(mass=1000 * water * math.prod(SIZE))


def sliced(count: int) -> Asset:
    x, y, z = SIZE
    centers = [(-x / 2 + (i + 0.5) * x / count, 0.0, z / 2) for i in range(count)]
    return touched(*(box_collider(f"s_{i}", (x / count, y, z), c) for i, c in enumerate(centers)))


def touched(*colliders: Collider) -> Asset:
    return linked(colliders=colliders)


def linked(**changes: object) -> Asset:
    """A plain_box with fields of its link replaced."""
    return plain_box().replace(links=(plain_box().root.replace(**changes),))


def cornered(corners: int) -> Asset:
    """A prism of that many corners; a Hull refuses too many, so this one is built around its validator."""
    angle = np.arange(corners // 2) * 4 * math.pi / corners
    ring = np.stack([np.cos(angle) * SIZE[0] / 2, np.sin(angle) * SIZE[1] / 2, 0 * angle], axis=1)
    points, faces = convex_hull(np.concatenate([ring, ring + np.array((0.0, 0.0, SIZE[2]))]))
    hull = Hull.model_construct(kind="hull", mesh=Mesh(vertices=points, faces=faces))
    collider = formed("whole", hull, "cardboard")
    corner = points[faces].reshape(-1, 3)
    mesh = Mesh(vertices=corner, faces=np.arange(len(corner)).reshape(-1, 3))
    return linked(visuals=(Visual(name="sides", mesh=mesh, material="print"),), colliders=(collider,))


def dented(depth: float) -> Asset:
    """A hull with one corner more, `depth` below the middle of its top."""
    box = box_mesh(SIZE, (0.0, 0.0, SIZE[2] / 2), shared=True)
    top = [f for f in range(12) if (box.vertices[box.faces[f], 2] == SIZE[2]).all()]
    ring = [(1, 5), (5, 7), (7, 3), (3, 1)]
    faces = np.concatenate([np.delete(box.faces, top, axis=0), [(a, b, 8) for a, b in ring]])
    mesh = Mesh(vertices=np.vstack([box.vertices, (0.0, 0.0, SIZE[2] - depth)]), faces=faces)
    return touched(formed("whole", Hull(mesh=mesh), "cardboard"))


def opened() -> Asset:
    box = box_mesh(SIZE, (0.0, 0.0, SIZE[2] / 2), shared=True)
    return touched(formed("whole", Hull(mesh=box.replace(faces=box.faces[:-1])), "cardboard"))


def balanced_at(x: float) -> Asset:
    return linked(inertial=box_inertial(0.5, (0.01, 0.01, 0.01), (x, 0.0, SIZE[2] / 2)))


def spread_over(x: float) -> Asset:
    """All mass in two points `x` apart."""
    spread = 0.5 * (x / 2) ** 2
    inertia = (1e-9, spread, spread, 0.0, 0.0, 0.0)
    return linked(inertial=Inertial(mass=0.5, center_of_mass=(0.0, 0.0, SIZE[2] / 2), inertia=inertia))


def gapped(gap: float) -> Asset:
    """Its two collision shapes leave `gap` between them in the middle, along x."""
    x, y, z = SIZE
    wide = (x - gap) / 2
    left, right = (-(x - wide) / 2, 0.0, z / 2), ((x - wide) / 2, 0.0, z / 2)
    return touched(box_collider("left", (wide, y, z), left), box_collider("right", (wide, y, z), right))


def plugged(height: float) -> Asset:
    """A mug without a handle that came as a mesh; a cylinder of that height stands in it as a collision shape."""
    mug = rigid_mug()
    plug = formed("plug", Cylinder(radius=0.036, height=height), "ceramic", (0.0, 0.0, 0.005 + height / 2))
    shapes = (*(c for c in mug.root.colliders if c.name != "handle"), plug)
    body = mug.root.replace(visuals=mug.root.visuals[:1], colliders=shapes)
    return mug.replace(links=(body,), provenance=PROVENANCE.replace(source="folder"))


def short_by(gap: float, size: Vec3 = SIZE) -> Asset:
    """Its collision shape ends `gap` below its top."""
    whole, (x, y, z) = plain_box(size), size
    collider = box_collider("low", (x, y, z - gap), (0.0, 0.0, (z - gap) / 2))
    return whole.replace(links=(whole.root.replace(colliders=(collider,)),))


def licensed(licence: str) -> Asset:
    return plain_box().replace(provenance=PROVENANCE.replace(licence=licence))


def opening(low: float, high: float, stated: bool) -> Asset:
    oven = microwave()
    moved = oven.joints[0].replace(range=(low, high))
    return oven.replace(joints=(moved,), states=oven.states if stated else ())


def shown(*meshes: Mesh, material: str = "print") -> Asset:
    """A plain_box that is seen as these meshes."""
    return linked(visuals=tuple(Visual(name=f"look_{i}", mesh=m, material=material) for i, m in enumerate(meshes)))


def side(i: int = 0, size: Vec3 = SIZE) -> Mesh:
    """A box of the plain_box's size, or one of its halves in x, 2 mm apart: 1 or 2."""
    width = SIZE[0] / 2 - 0.001
    x = 0.0 if i == 0 else (2 * i - 3) * (SIZE[0] - width) / 2
    return box_mesh(size if i == 0 else (width, *SIZE[1:]), (x, 0.0, SIZE[2] / 2))


def turned(mesh: Mesh, normals: bool = True, faces: bool = True) -> Mesh:
    assert mesh.normals is not None
    return mesh.replace(
        normals=-mesh.normals if normals else mesh.normals, faces=mesh.faces[:, ::-1] if faces else mesh.faces
    )


def with_sliver() -> Asset:
    return shown(side().replace(faces=np.vstack([side().faces, (0, 0, 1)])))


def lined(wall: float) -> Asset:
    """A hollow box: within the outer walls, inner ones that face inwards."""
    x, y, z = SIZE
    return shown(side(), turned(side(size=(x - 2 * wall, y - 2 * wall, z - 2 * wall))))


def half_turned() -> Asset:
    return shown(side(1), turned(side(2)))


def finer_ball(steps: int) -> Asset:
    return ball().replace(links=(ball().root.replace(visuals=(peel(steps),)),))


def pictured(width_px: int, stated_px: int | None = None, unwrapped: bool = True) -> Asset:
    picture = texture("label", np.full((4, width_px, 3), 200, dtype=np.uint8))
    if stated_px:
        picture = picture.replace(width_px=stated_px)
    mesh = side() if unwrapped else side().replace(uv=None)
    return shown(mesh).replace(materials=(Material(id="print", base_color_texture=picture, substance="cardboard"),))


def with_fin(corners: int) -> Asset:
    """A plain_box with a loose piece of so many corners inside."""
    points = np.array([(0.0, 0.0, 0.01), (0.01, 0.0, 0.01), (0.0, 0.01, 0.01), (0.0, 0.0, 0.02)])[:corners]
    faces = np.array([(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)])[: 1 if corners == 3 else 4]
    return shown(side(), Mesh(vertices=points, faces=faces))
