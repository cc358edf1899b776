"""Small assets built in code, shared by the tests of both writers and of the checks."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from casa_assets.model.asset.asset import Asset, Base, Inertial, Link, Site, Visual
from casa_assets.model.asset.material import ColorSpace, Material
from casa_assets.model.asset.parts import Capsule, Cylinder, Hull, Sphere
from casa_assets.model.issue import Files
from casa_assets.model.pose import Pose
from casa_assets.model.registry.category import Category, MatterFill, RestingPose, SizeRange
from tests.support.asset.articulated_assets import drawer_unit as drawer_unit
from tests.support.asset.articulated_assets import microwave as microwave
from tests.support.asset.asset_parts import CARDBOARD, CERAMIC, FRUIT, box_collider, formed, link, named, seen
from tests.support.asset.asset_parts import PROVENANCE as PROVENANCE
from tests.support.asset.asset_parts import box_inertial as box_inertial
from tests.support.mesh.meshes import lathe, texture, wall


def write_to(files: Files, folder: Path) -> Path:
    """Puts files on disk below `folder` and returns it."""
    for path, data in files.entries.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data)
    return folder


def category(asset: Asset) -> Category:
    """A registry row that fits the asset."""
    span = SizeRange(low=0.01, typical=0.2, high=1.0)
    return Category(
        id=asset.labels.category,
        parent=asset.labels.classes[1],
        qcode=asset.labels.qcode,
        longest_m=span,
        mass_kg=SizeRange(low=0.01, typical=1.0, high=50.0),
        shape=(1.0, 1.0, 1.0),
        upright=RestingPose.STANDS,
        build=MatterFill.SOLID,
        substance=asset.substances[0].id,
        fixed=asset.base is Base.FIXED,
    )


def rigid_mug() -> Asset:
    """A mug: one link, an open vessel of ten colliders, no textures; its inertia is not diagonal."""
    steps = 8
    walls = tuple(formed(f"wall_{i}", Hull(mesh=wall(i, steps)), "ceramic") for i in range(steps))
    floor = formed("floor", Cylinder(radius=0.04, height=0.006), "ceramic", (0.0, 0.0, 0.003))
    handle = formed("handle", Capsule(radius=0.005, height=0.05), "ceramic", (0.06, 0.0, 0.05))
    profile = [(0.0, 0.006), (0.035, 0.006), (0.035, 0.095), (0.04, 0.095), (0.04, 0.0), (0.0, 0.0)]
    body = Visual(name="body", mesh=lathe(profile, 32), material="glaze")
    grip = seen("grip", "glaze", (0.01, 0.01, 0.06), (0.06, 0.0, 0.05))
    inertia = (4e-4, 4.3e-4, 3.6e-4, 0.0, 1.5e-5, 0.0)
    inertial = Inertial(mass=0.3, center_of_mass=(0.004, 0.0, 0.042), inertia=inertia)
    return Asset(
        **named("mug", "Q386215", "drinkware", "tableware"),
        links=(Link(name="object", inertial=inertial, visuals=(body, grip), colliders=(*walls, floor, handle)),),
        sites=(Site(name="fill", pose=Pose(position=(0.0, 0.0, 0.09))),),
        materials=(Material(id="glaze", base_color=(0.6, 0.05, 0.02, 1.0), roughness=0.2, substance="ceramic"),),
        substances=(CERAMIC,),
    )


def peel(steps: int) -> Visual:
    """How an orange is seen."""
    arc = [(0.036 * math.sin(t), 0.036 - 0.036 * math.cos(t)) for t in np.linspace(math.pi, 0.0, 17)]
    return Visual(name="peel", mesh=lathe(arc, steps), material="peel")


def ball() -> Asset:
    """An orange: one sphere, which rolls unless something stops it."""
    radius, mass = 0.036, 0.17
    at, k = (0.0, 0.0, radius), 0.4 * mass * radius**2
    inertial = Inertial(mass=mass, center_of_mass=at, inertia=(k, k, k, 0.0, 0.0, 0.0))
    shape = formed("peel_0", Sphere(radius=radius), "fruit", at)
    return Asset(
        **named("orange", "Q13191", "fruit", "food"),
        links=(Link(name="object", inertial=inertial, visuals=(peel(32),), colliders=(shape,)),),
        materials=(Material(id="peel", base_color=(0.9, 0.3, 0.02, 1.0), roughness=0.5, substance="fruit"),),
        substances=(FRUIT,),
    )


def textured_box() -> Asset:
    """A carton with all three kinds of texture; the picture's top half is red, its bottom is green and blue."""
    whole = (0.2, 0.06, 0.12), (0.0, 0.0, 0.06)
    picture = np.full((16, 16, 3), (230, 20, 20), dtype=np.uint8)
    picture[8:, :8] = (20, 200, 20)
    picture[8:, 8:] = (20, 20, 230)
    rough = np.tile(np.array([255, 150, 10], dtype=np.uint8), (8, 8, 1))
    flat = np.tile(np.array([128, 128, 255], dtype=np.uint8), (8, 8, 1))
    carton = Material(
        id="print",
        roughness=0.8,
        base_color=(1.0, 1.0, 1.0, 1.0),
        base_color_texture=texture("print_color", picture),
        metallic_roughness_texture=texture("print_rough", rough, ColorSpace.RAW),
        normal_texture=texture("print_normal", flat, ColorSpace.RAW),
        substance="cardboard",
    )
    return Asset(
        **named("carton", "Q838692", "packaging"),
        links=(link("object", (0.5, *whole), [seen("carton", "print", *whole)], [box_collider("carton_0", *whole)]),),
        materials=(carton,),
        substances=(CARDBOARD,),
    )


EVERY = (rigid_mug, ball, textured_box, microwave, drawer_unit)
