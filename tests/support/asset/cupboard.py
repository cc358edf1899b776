"""A small cupboard with a door, a drawer, a knob and a key, and one thing about it changed at a time."""

from __future__ import annotations

import math

import numpy as np

from casa_assets.model.asset.asset import (
    Asset,
    Base,
    Collider,
    Drive,
    JointValue,
    Keyframe,
    Link,
    Region,
    State,
    Visual,
)
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Box, Cylinder, Mesh, Shape, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from tests.support.asset import asset_parts as kit
from tests.support.mesh.meshes import box_mesh

TILE = (0.8, 0.4)
# Name -> full size and middle, metres; the front of the carcass is at y = -0.2.
CARCASS: dict[str, tuple[Vec3, Vec3]] = {
    "left": ((0.02, 0.4, 0.7), (-0.29, 0.0, 0.35)),
    "right": ((0.02, 0.4, 0.7), (0.29, 0.0, 0.35)),
    "bottom": ((0.56, 0.4, 0.02), (0.0, 0.0, 0.01)),
    "top": ((0.56, 0.4, 0.02), (0.0, 0.0, 0.69)),
    "back": ((0.56, 0.02, 0.66), (0.0, 0.19, 0.35)),
    "divider": ((0.56, 0.38, 0.02), (0.0, -0.01, 0.41)),
    "fascia": ((0.56, 0.02, 0.07), (0.0, -0.19, 0.645)),
}
# In the frame of the drawer, which is that of the asset while it is shut.
DRAWER: dict[str, tuple[Vec3, Vec3]] = {
    "drawer_front": ((0.55, 0.018, 0.18), (0.0, -0.211, 0.515)),
    "drawer_floor": ((0.5, 0.362, 0.01), (0.0, -0.021, 0.44)),
    "drawer_left": ((0.01, 0.362, 0.12), (-0.245, -0.021, 0.505)),
    "drawer_right": ((0.01, 0.362, 0.12), (0.245, -0.021, 0.505)),
    "drawer_back": ((0.48, 0.01, 0.12), (0.0, 0.155, 0.505)),
}
HINGE: Vec3 = (-0.275, -0.202, 0.205)
KNOB: Vec3 = (-0.1, -0.217, 0.645)
KEY: Vec3 = (0.1, -0.211, 0.645)


def cupboard() -> Asset:
    """Fixed to its place: door below, drawer above, a knob and a sprung key on the fascia."""
    return Asset(
        id="cupboard_0123456789",
        base=Base.FIXED,
        links=(_carcass(), _door(), _drawer(), _knob(), _key()),
        joints=(
            kit.hinge(
                "door_hinge", "door", kit.Z, (-math.pi / 2, 0.0), damping=1.0, frictionloss=2.5, grip="door_handle"
            ),
            kit.slide(
                "drawer_slide",
                "drawer",
                (0.0, -1.0, 0.0),
                (0.0, 0.3),
                damping=10.0,
                frictionloss=6.0,
                grip="drawer_handle",
            ),
            kit.hinge("knob_turn", "knob", kit.Y, (0.0, 2.0), damping=0.01, frictionloss=0.05, grip="knob_grip"),
            kit.slide("key_press", "key", kit.Y, (0.0, 0.004), damping=0.5, frictionloss=0.2, grip="key_cap").replace(
                drive=Drive(stiffness=250.0, damping=0.0, target=-0.004)
            ),
        ),
        regions=(
            Region(name="main", pose=Pose(position=(0.0, -0.03, 0.35)), size=(0.6, 0.46, 0.7)),
            Region(name="int", pose=Pose(position=(0.0, -0.01, 0.21)), size=(0.54, 0.36, 0.38)),
            Region(name="drawer_int", link="drawer", pose=Pose(position=(0.0, -0.02, 0.495)), size=(0.46, 0.3, 0.1)),
        ),
        states=(State(name="door_open", joint="door_hinge", value="open", interval=(0.9, 1.0)),),
        keyframes=(
            Keyframe(name="closed"),
            Keyframe(
                name="open",
                joints=(JointValue(joint="door_hinge", value=-1.5), JointValue(joint="drawer_slide", value=0.28)),
            ),
        ),
        materials=(
            Material(id="paint", base_color=(0.2, 0.3, 0.4, 1.0)),
            Material(id="brass", base_color=(0.7, 0.6, 0.3, 1.0), metallic=1.0),
            Material(id="oak", base_color=(0.5, 0.4, 0.2, 1.0), tile_m=TILE),
        ),
        substances=(kit.CARDBOARD, kit.STEEL),
        labels=kit.labels("cupboard", ("cupboard", "furniture"), "Q614467"),
        provenance=kit.PROVENANCE.replace(source="family"),
    )


def joint_changed(name: str, **changes: object) -> Asset:
    """The cupboard with fields of a joint replaced."""
    whole = cupboard()
    return whole.replace(joints=tuple(j.replace(**changes) if j.name == name else j for j in whole.joints))


def link_changed(name: str, **changes: object) -> Asset:
    """The cupboard with fields of a link replaced."""
    whole = cupboard()
    return whole.replace(links=tuple(k.replace(**changes) if k.name == name else k for k in whole.links))


def with_shapes(link: str, *shapes: Collider) -> Asset:
    """The cupboard with more collision shapes on a link."""
    return link_changed(link, colliders=(*cupboard().link(link).colliders, *shapes))


def shape(name: str, size: Vec3, at: Vec3) -> Collider:
    """A box of full `size`, metres, in the frame of its link."""
    return kit.box_collider(name, size, at)


def with_grip(joint: str, replaced: Shape, **changes: object) -> Asset:
    """The cupboard with the shape, and other fields, of the collider that a hand takes of a joint replaced."""
    whole = cupboard()
    name = next(j.grip for j in whole.joints if j.name == joint)
    links = tuple(
        k.replace(colliders=tuple(c.replace(shape=replaced, **changes) if c.name == name else c for c in k.colliders))
        for k in whole.links
    )
    return whole.replace(links=links)


def with_mass_within(size: float) -> Asset:
    """The mass of its door lies in a cube of that side."""
    return link_changed("door", inertial=kit.box_inertial(4.0, (size, size, size), (0.27, -0.009, 0.0)))


def caught_by(lip: float) -> Asset:
    """A foot below its drawer meets a lip on the divider, which is so much too high, metres, right away."""
    foot = shape("foot", (0.1, 0.1, 0.01), (0.0, 0.0, 0.43))
    catch = shape("catch", (0.1, 0.02, 0.02), (0.0, -0.06005, 0.415 + lip))
    drawer = with_shapes("drawer", foot)
    carcass = with_shapes("object", catch).root
    return drawer.replace(links=(carcass, *drawer.links[1:]))


def with_pointer(length: float) -> Asset:
    """A bar on its knob points up; turned, it hangs before the drawer where it is long enough."""
    size, at = (0.02, 0.01, length), (0.0, -0.02, length / 2)
    knob = cupboard().link("knob")
    bar = kit.seen("pointer_bar", "brass", size, at)
    return link_changed("knob", visuals=(*knob.visuals, bar), colliders=(*knob.colliders, shape("pointer", size, at)))


def filled_to(height: float) -> Asset:
    """A block lies in its lower room, this high, or hangs from its top where it is negative."""
    middle = 0.02 + height / 2 if height > 0 else 0.4 + height / 2
    return with_shapes("object", shape("block", (0.3, 0.2, abs(height)), (0.0, 0.0, middle)))


def pictured_at(scale: float, part: slice = slice(None)) -> Asset:
    """The picture on its door, or on some of its corners, is shown at that scale."""
    shown = cupboard().link("door").visuals
    mesh = shown[0].mesh
    assert mesh.uv is not None
    uv = mesh.uv.copy()
    uv[part] *= scale
    return link_changed("door", visuals=(shown[0].replace(mesh=mesh.replace(uv=uv)), *shown[1:]))


def with_trim(proud: float, material: str = "brass") -> Asset:
    """A strip of metal let into the front of its door stands out by so much, metres."""
    strip = box_mesh((0.4, 0.01, 0.02), (0.27, -0.018 - proud + 0.005, 0.1))
    shown = cupboard().link("door").visuals
    return link_changed("door", visuals=(*shown, Visual(name="strip", mesh=metric(strip), material=material)))


def metric(mesh: Mesh) -> Mesh:
    """The same box with texture coordinates in metres over the tile of its picture."""
    assert mesh.normals is not None
    dropped = np.abs(mesh.normals).argmax(axis=1)
    kept = np.array([[1, 2], [0, 2], [0, 1]])[dropped]
    return mesh.replace(uv=np.take_along_axis(mesh.vertices, kept, axis=1) / np.array(TILE))


def _carcass() -> Link:
    return Link(
        name="object",
        inertial=kit.box_inertial(18.0, (0.6, 0.4, 0.7), (0.0, 0.0, 0.35)),
        visuals=tuple(kit.seen(f"{n}_panel", "paint", size, at) for n, (size, at) in CARCASS.items()),
        colliders=tuple(shape(n, size, at) for n, (size, at) in CARCASS.items()),
    )


def _door() -> Link:
    size: Vec3 = (0.55, 0.018, 0.37)
    middle: Vec3 = (0.275, -0.009, 0.0)
    grip, at = Box(size=(0.014, 0.014, 0.14)), (0.5, -0.048, 0.08)
    return Link(
        name="door",
        parent="object",
        pose=Pose(position=HINGE),
        inertial=kit.box_inertial(4.0, size, middle),
        visuals=(
            Visual(name="door_panel", mesh=metric(box_mesh(size, middle)), material="oak"),
            kit.seen("door_bar", "brass", grip.size, at, label="handle"),
        ),
        colliders=(shape("door_main", size, middle), _grip("door_handle", grip, at, "handle")),
    )


def _drawer() -> Link:
    grip, at = Box(size=(0.14, 0.014, 0.014)), (0.0, -0.25, 0.515)
    return Link(
        name="drawer",
        parent="object",
        inertial=kit.box_inertial(3.0, (0.5, 0.36, 0.14), (0.0, -0.03, 0.49)),
        visuals=(
            *(kit.seen(f"{n}_panel", "paint", size, at) for n, (size, at) in DRAWER.items()),
            kit.seen("drawer_bar", "brass", grip.size, at, label="handle"),
        ),
        colliders=(
            *(shape(n, size, at) for n, (size, at) in DRAWER.items()),
            _grip("drawer_handle", grip, at, "handle"),
        ),
    )


def _knob() -> Link:
    lying = Pose(quaternion=(math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0))
    return Link(
        name="knob",
        parent="object",
        pose=Pose(position=KNOB),
        inertial=kit.box_inertial(0.05, (0.04, 0.03, 0.04), kit.HERE),
        visuals=(kit.seen("knob_cap", "brass", (0.04, 0.03, 0.04)),),
        colliders=(_grip("knob_grip", Cylinder(radius=0.02, height=0.03), (0.0, 0.0, 0.0), "knob", lying),),
    )


def _key() -> Link:
    size: Vec3 = (0.03, 0.01, 0.03)
    return Link(
        name="key",
        parent="object",
        pose=Pose(position=KEY),
        inertial=kit.box_inertial(0.02, size, kit.HERE),
        visuals=(kit.seen("key_top", "brass", size, (0.0, 0.0, 0.0)),),
        colliders=(_grip("key_cap", Box(size=size), (0.0, 0.0, 0.0), "button"),),
    )


def _grip(name: str, form: Shape, at: Vec3, label: str, pose: Pose | None = None) -> Collider:
    placed = (pose or Pose()).replace(position=at)
    return Collider(name=name, shape=form, substance="steel", pose=placed, label=label)


def ball_of(diameter: float) -> Sphere:
    """A round grip."""
    return Sphere(radius=diameter / 2)
