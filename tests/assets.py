"""Small assets built in code, shared by the tests of both writers and of the checks."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from casa_assets.model.asset import (
    Asset,
    Base,
    Collider,
    Drive,
    Exclusion,
    Inertial,
    Joint,
    JointKind,
    Link,
    Region,
    Site,
    State,
    Visual,
)
from casa_assets.model.category import Build, Category, Certainty, QCode, Span, Upright
from casa_assets.model.files import Files
from casa_assets.model.material import ColorSpace, Material, Substance
from casa_assets.model.pose import Pose
from casa_assets.model.provenance import Labels, Provenance
from casa_assets.model.record import Vec3
from casa_assets.model.shape import Box, Capsule, Cylinder, Hull, Sphere
from tests.meshes import box_mesh, lathe, texture, wall

CERAMIC = Substance(id="ceramic", density=2400.0, static_friction=0.6, dynamic_friction=0.45)
STEEL = Substance(id="steel", density=7800.0, static_friction=0.6, dynamic_friction=0.4, torsional_friction=0.004)
FRUIT = Substance(
    id="fruit",
    density=900.0,
    static_friction=0.7,
    dynamic_friction=0.6,
    torsional_friction=0.006,
    rolling_friction=5e-4,
)
CARDBOARD = Substance(id="cardboard", density=300.0, static_friction=0.5, dynamic_friction=0.4)

PROVENANCE = Provenance(
    source="generated", path="tests", sha256="0" * 64, title="Test", author="Casa", licence="CC0-1.0"
)


def write_to(files: Files, folder: Path) -> Path:
    """Puts files on disk below `folder` and returns it."""
    for path, data in files.entries.items():
        target = folder / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(data)
    return folder


def category(asset: Asset) -> Category:
    """A registry row that fits the asset."""
    span = Span(low=0.01, typical=0.2, high=1.0)
    return Category(
        id=asset.labels.category,
        parent=asset.labels.classes[1],
        qcode=asset.labels.qcode,
        longest_m=span,
        mass_kg=Span(low=0.01, typical=1.0, high=50.0),
        shape=(1.0, 1.0, 1.0),
        upright=Upright.STANDS,
        build=Build.SOLID,
        substance=asset.substances[0].id,
        fixed=asset.base is Base.FIXED,
    )


def rigid_mug() -> Asset:
    """A mug: one link, an open vessel of ten colliders, no textures; its inertia is not diagonal."""
    steps = 8
    walls = tuple(
        Collider(name=f"wall_{i}", shape=Hull(mesh=wall(i, steps)), substance="ceramic") for i in range(steps)
    )
    floor = Collider(
        name="floor",
        shape=Cylinder(radius=0.04, height=0.006),
        substance="ceramic",
        pose=Pose(position=(0.0, 0.0, 0.003)),
    )
    handle = Collider(
        name="handle",
        shape=Capsule(radius=0.005, height=0.05),
        substance="ceramic",
        pose=Pose(position=(0.06, 0.0, 0.05)),
    )
    profile = [(0.0, 0.006), (0.035, 0.006), (0.035, 0.095), (0.04, 0.095), (0.04, 0.0), (0.0, 0.0)]
    return Asset(
        id="mug_0123456789",
        links=(
            Link(
                name="object",
                inertial=Inertial(
                    mass=0.3, center_of_mass=(0.004, 0.0, 0.042), inertia=(4e-4, 4.3e-4, 3.6e-4, 0.0, 1.5e-5, 0.0)
                ),
                visuals=(
                    Visual(name="body", mesh=lathe(profile, 32), material="glaze"),
                    Visual(name="grip", mesh=box_mesh((0.01, 0.01, 0.06), (0.06, 0.0, 0.05)), material="glaze"),
                ),
                colliders=(*walls, floor, handle),
            ),
        ),
        sites=(Site(name="fill", pose=Pose(position=(0.0, 0.0, 0.09))),),
        materials=(Material(id="glaze", base_color=(0.6, 0.05, 0.02, 1.0), roughness=0.2, substance="ceramic"),),
        substances=(CERAMIC,),
        labels=_labels("mug", ("mug", "drinkware", "tableware"), "Q386215"),
        provenance=PROVENANCE,
    )


def ball() -> Asset:
    """An orange: one sphere, which rolls unless something stops it."""
    radius, mass = 0.036, 0.17
    arc = [(radius * math.sin(t), radius - radius * math.cos(t)) for t in np.linspace(math.pi, 0.0, 17)]
    inertia = 0.4 * mass * radius**2
    return Asset(
        id="orange_0123456789",
        links=(
            Link(
                name="object",
                inertial=Inertial(
                    mass=mass, center_of_mass=(0.0, 0.0, radius), inertia=(inertia, inertia, inertia, 0.0, 0.0, 0.0)
                ),
                visuals=(Visual(name="peel", mesh=lathe(arc, 32), material="peel"),),
                colliders=(
                    Collider(
                        name="peel_0",
                        shape=Sphere(radius=radius),
                        substance="fruit",
                        pose=Pose(position=(0.0, 0.0, radius)),
                    ),
                ),
            ),
        ),
        materials=(Material(id="peel", base_color=(0.9, 0.3, 0.02, 1.0), roughness=0.5, substance="fruit"),),
        substances=(FRUIT,),
        labels=_labels("orange", ("orange", "fruit", "food"), "Q13191"),
        provenance=PROVENANCE,
    )


def textured_box() -> Asset:
    """A carton with all three kinds of texture; the picture's top half is red, its bottom is green and blue."""
    size = (0.2, 0.06, 0.12)
    picture = np.zeros((16, 16, 3), dtype=np.uint8)
    picture[:8] = (230, 20, 20)
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
        id="carton_0123456789",
        links=(
            Link(
                name="object",
                inertial=box_inertial(0.5, size, (0.0, 0.0, 0.06)),
                visuals=(Visual(name="carton", mesh=box_mesh(size, (0.0, 0.0, 0.06)), material="print"),),
                colliders=(
                    Collider(
                        name="carton_0",
                        shape=Box(size=size),
                        substance="cardboard",
                        pose=Pose(position=(0.0, 0.0, 0.06)),
                    ),
                ),
            ),
        ),
        materials=(carton,),
        substances=(CARDBOARD,),
        labels=_labels("carton", ("carton", "packaging"), "Q838692"),
        provenance=PROVENANCE,
    )


def microwave(base: Base = Base.FIXED) -> Asset:
    """A microwave oven: carcass and door, one hinge, an exclusion, regions, a site and two states."""
    panels: dict[str, tuple[Vec3, Vec3]] = {
        "bottom": ((0.5, 0.38, 0.02), (0.0, 0.01, 0.01)),
        "top": ((0.5, 0.38, 0.02), (0.0, 0.01, 0.29)),
        "left": ((0.02, 0.38, 0.26), (-0.24, 0.01, 0.15)),
        "right": ((0.1, 0.38, 0.26), (0.2, 0.01, 0.15)),
        "back": ((0.38, 0.02, 0.26), (-0.04, 0.19, 0.15)),
    }
    carcass = Link(
        name="object",
        inertial=box_inertial(9.0, (0.5, 0.38, 0.3), (0.0, 0.01, 0.15)),
        visuals=tuple(Visual(name=f"{n}_panel", mesh=box_mesh(*p), material="enamel") for n, p in panels.items()),
        colliders=tuple(
            Collider(name=f"{n}_0", shape=Box(size=size), substance="steel", pose=Pose(position=at))
            for n, (size, at) in panels.items()
        ),
    )
    door_size: Vec3 = (0.38, 0.02, 0.28)
    door = Link(
        name="door",
        parent="object",
        pose=Pose(position=(-0.24, -0.19, 0.15)),
        inertial=box_inertial(1.5, door_size, (0.19, -0.01, 0.0)),
        visuals=(Visual(name="door_main", mesh=box_mesh(door_size, (0.19, -0.01, 0.0)), material="glass"),),
        colliders=(
            Collider(
                name="door_0", shape=Box(size=door_size), substance="steel", pose=Pose(position=(0.19, -0.011, 0.0))
            ),
        ),
    )
    return Asset(
        id="microwave_0123456789",
        base=base,
        links=(carcass, door),
        joints=(
            Joint(
                name="microjoint",
                child="door",
                kind=JointKind.HINGE,
                axis=(0.0, 0.0, 1.0),
                anchor=(0.0, -0.02, 0.0),
                range=(-math.pi / 2, 0.0),
                damping=0.5,
                frictionloss=0.3,
                armature=0.01,
            ),
        ),
        sites=(Site(name="plate_place", pose=Pose(position=(-0.04, 0.0, 0.03)), radius=0.01),),
        regions=(
            Region(name="int", pose=Pose(position=(-0.04, 0.0, 0.15)), size=(0.36, 0.34, 0.24)),
            Region(name="tray", pose=Pose(position=(-0.04, 0.0, 0.025)), kind="cylinder", size=(0.3, 0.3, 0.01)),
            Region(name="door_front", link="door", pose=Pose(position=(0.19, -0.03, 0.0)), size=(0.38, 0.01, 0.28)),
        ),
        states=(
            State(name="door_open", joint="microjoint", value="open", interval=(0.9, 1.0)),
            State(name="door_closed", joint="microjoint", value="closed", interval=(0.0, 0.005)),
        ),
        exclusions=(Exclusion(first="object", second="door"),),
        materials=(
            Material(id="enamel", base_color=(0.7, 0.7, 0.7, 1.0), metallic=0.3, roughness=0.3, substance="steel"),
            Material(id="glass", base_color=(0.05, 0.05, 0.06, 0.5), roughness=0.05, substance="glass"),
        ),
        substances=(STEEL,),
        labels=_labels("microwave", ("microwave", "appliance"), "Q127956"),
        provenance=PROVENANCE,
    )


def drawer_unit() -> Asset:
    """A cabinet with a driven drawer in a turned frame, and a knob that is rigidly attached to the drawer."""
    turned = Pose(position=(0.0, -0.05, 0.1), quaternion=(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))
    return Asset(
        id="cabinet_0123456789",
        base=Base.FIXED,
        links=(
            Link(
                name="object",
                inertial=box_inertial(8.0, (0.4, 0.5, 0.02), (0.0, 0.0, 0.01)),
                visuals=(Visual(name="carcass", mesh=box_mesh((0.4, 0.5, 0.02), (0.0, 0.0, 0.01)), material="paint"),),
                colliders=(
                    Collider(
                        name="carcass_0",
                        shape=Box(size=(0.4, 0.5, 0.02)),
                        substance="steel",
                        pose=Pose(position=(0.0, 0.0, 0.01)),
                    ),
                ),
            ),
            Link(
                name="drawer",
                parent="object",
                pose=turned,
                inertial=box_inertial(2.0, (0.4, 0.3, 0.1), (0.01, 0.02, 0.0)),
                visuals=(Visual(name="box", mesh=box_mesh((0.4, 0.3, 0.1), (0.0, 0.0, 0.0)), material="paint"),),
                colliders=(
                    Collider(
                        name="box_0",
                        shape=Hull(mesh=box_mesh((0.4, 0.3, 0.1), (0.0, 0.0, 0.0), shared=True)),
                        substance="cardboard",
                        pose=Pose(quaternion=(math.cos(0.1), 0.0, 0.0, math.sin(0.1))),
                    ),
                ),
            ),
            Link(
                name="knob",
                parent="drawer",
                pose=Pose(position=(-0.22, 0.0, 0.0), quaternion=(math.cos(0.3), math.sin(0.3), 0.0, 0.0)),
                inertial=Inertial(mass=0.05, center_of_mass=(0.0, 0.0, 0.0), inertia=(1e-5, 1e-5, 8e-6, 0.0, 0.0, 0.0)),
                visuals=(
                    Visual(name="knob_main", mesh=box_mesh((0.03, 0.03, 0.03), (0.0, 0.0, 0.0)), material="paint"),
                ),
                colliders=(
                    Collider(
                        name="knob_0",
                        shape=Cylinder(radius=0.01, height=0.03),
                        substance="steel",
                        pose=Pose(quaternion=(math.cos(0.4), 0.0, math.sin(0.4), 0.0)),
                    ),
                ),
            ),
        ),
        joints=(
            Joint(
                name="drawer_joint",
                child="drawer",
                kind=JointKind.SLIDE,
                axis=(-1.0, 0.0, 0.0),
                range=(0.0, 0.28),
                damping=2.0,
                drive=Drive(stiffness=5.0, damping=1.5, target=0.0),
            ),
        ),
        states=(State(name="drawer_open", joint="drawer_joint", value="open", interval=(0.9, 1.0)),),
        exclusions=(Exclusion(first="knob", second="object"),),
        materials=(Material(id="paint", base_color=(0.2, 0.3, 0.4, 1.0), substance="steel"),),
        substances=(CARDBOARD, STEEL),
        labels=_labels("cabinet", ("cabinet", "furniture"), "Q1049754"),
        provenance=PROVENANCE,
    )


EVERY = (rigid_mug, ball, textured_box, microwave, drawer_unit)


def box_inertial(mass: float, size: Vec3, center: Vec3) -> Inertial:
    """Inertia of a solid box of full `size`, metres, kg."""
    x, y, z = (s * s for s in size)
    k = mass / 12
    return Inertial(mass=mass, center_of_mass=center, inertia=(k * (y + z), k * (x + z), k * (x + y), 0.0, 0.0, 0.0))


def _labels(name: str, classes: tuple[str, ...], qcode: str) -> Labels:
    return Labels(category=name, classes=classes, qcode=QCode(id=qcode, label=name, certainty=Certainty.CERTAIN))
