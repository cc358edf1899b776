"""Loose objects of the kinds that RoboCasa's atomic tasks ask for: boxes and vessels of each category's usual size."""

from __future__ import annotations

import hashlib

import numpy as np

from casa_assets import registry
from casa_assets.model.asset.asset import Asset, Link, Visual
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.asset.provenance import split_of
from casa_assets.model.record import Vec3
from casa_assets.model.registry.category import Category
from tests.asset_parts import CARDBOARD, PROVENANCE, box_collider, box_inertial, labels
from tests.meshes import box_mesh

# At least one for each group of objects that an atomic task of RoboCasa v1.0 draws from, as far as it can be grasped,
# washed, heated, cooked or cooled as that task demands.
SOLID = (
    *("apple", "lemon", "banana", "carrot", "corn", "tomato", "potato", "bell_pepper"),
    *("bread", "bread_flat", "sandwich_bread", "hotdog_bun", "bagel", "cake", "cupcake", "donut", "cheese"),
    *("hot_dog", "burrito", "fish", "steak", "chicken_drumstick", "egg", "ice_cube", "milk", "can", "wine"),
    *("rolling_pin", "tongs", "ladle", "whisk", "peeler", "measuring_cup", "spoon", "knife"),
)
VESSELS = ("plate", "bowl", "mug", "cup", "glass_cup", "pan", "pot", "saucepan", "oven_tray", "tray", "tupperware")
# They hold nothing here, but stand as themselves.
CLOSED = ("kettle_non_electric", "cutting_board")
WALL_M = 0.004
# Those for which tasks leave little room: a plate between a microwave and the edge of the worktop, a tray on half of
# an oven's rack, a box that PackDessert makes 2.5 times as wide, bread and cake in the bowl of a stand mixer, flat
# bread that CheesyBread lays on a board, 1.5 times as wide, and cheese on it. The pan is the square in its round
# bowl, without the handle: a box around both would stand in the backguard behind a burner.
OWN_SIZES: dict[str, Vec3] = {
    "plate": (0.16, 0.16, 0.02),
    "pan": (0.19, 0.19, 0.06),
    "oven_tray": (0.32, 0.24, 0.02),
    "tupperware": (0.12, 0.1, 0.05),
    **dict.fromkeys(("bread", "cake"), (0.06, 0.05, 0.03)),
    "bread_flat": (0.12, 0.1, 0.02),
    "cheese": (0.04, 0.04, 0.02),
}


def task_objects() -> tuple[Asset, ...]:
    """Two objects of each kind, one for training and one for testing, in the order of the lists."""
    return tuple(
        _made(name, digest, name in VESSELS) for name in (*SOLID, *VESSELS, *CLOSED) for digest in _digests(name)
    )


def _digests(name: str) -> tuple[str, str]:
    """Two digests of sources: the first is kept for training, the second for testing."""
    tail = hashlib.sha256(name.encode()).hexdigest()[8:]
    return f"00000001{tail}", f"00000005{tail}"


def _made(name: str, digest: str, is_vessel: bool) -> Asset:
    category = registry.load().categories[name]
    size = OWN_SIZES.get(name) or _size(category)
    boxes = _vessel(size) if is_vessel else [(size, (0.0, 0.0, size[2] / 2))]
    return Asset(
        id=f"{name}_{digest[:10]}",
        links=(
            Link(
                name="object",
                inertial=box_inertial(category.mass_kg.typical, size, (0.0, 0.0, size[2] / 2)),
                visuals=(Visual(name="body", mesh=_joined(boxes), material="paint"),),
                colliders=tuple(box_collider(f"body_{k}", sides, center) for k, (sides, center) in enumerate(boxes)),
            ),
        ),
        materials=(Material(id="paint", base_color=_color(name)),),
        substances=(CARDBOARD,),
        labels=labels(name, (name,), category.qcode.id).replace(split=split_of(digest)),
        provenance=PROVENANCE.replace(sha256=digest),
    )


def _size(category: Category) -> Vec3:
    """Usual extents as it rests, metres, at most those of a hand's load."""
    if category.size_m is not None:
        x, y, z = (side.typical for side in category.size_m)
    else:
        x, y, z = (part * category.longest_m.typical for part in category.shape)
    return round(x, 4), round(y, 4), round(z, 4)


def _vessel(size: Vec3) -> list[tuple[Vec3, Vec3]]:
    """Size and middle of a floor and four walls, metres."""
    x, y, z = size
    wall = min(WALL_M, z / 3)
    side = (wall, y, z)
    front = (x - 2 * wall, wall, z)
    return [
        ((x - 2 * wall, y - 2 * wall, wall), (0.0, 0.0, wall / 2)),
        *((side, (sign * (x - wall) / 2, 0.0, z / 2)) for sign in (-1, 1)),
        *((front, (0.0, sign * (y - wall) / 2, z / 2)) for sign in (-1, 1)),
    ]


def _joined(boxes: list[tuple[Vec3, Vec3]]) -> Mesh:
    meshes = [box_mesh(size, center) for size, center in boxes]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    return Mesh(
        vertices=np.concatenate([mesh.vertices for mesh in meshes]),
        faces=np.concatenate([mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]),
        normals=np.concatenate([mesh.normals for mesh in meshes]) if meshes[0].normals is not None else None,
    )


def _color(name: str) -> tuple[float, float, float, float]:
    red, green, blue = hashlib.sha256(name.encode()).digest()[:3]
    return red / 255, green / 255, blue / 255, 1.0
