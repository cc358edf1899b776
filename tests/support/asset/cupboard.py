"""A small cupboard with a door, a drawer, a knob and a key, and one thing about it changed at a time."""

from __future__ import annotations

import math

import numpy as np

from casa_assets.model.asset.asset import Asset, Base, Collider, Drive, Link, Region, State, Visual
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Cylinder, Mesh, Shape, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from tests.support.asset import asset_parts as kit
from tests.support.mesh.meshes import box_mesh

TILE = (0.8, 0.4)
shape = kit.box_collider
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
    swung = kit.hinge("door_hinge", "door", kit.Z, (-math.pi / 2, 0.0), damping=1.0, frictionloss=2.5)
    pulled = kit.slide("drawer_slide", "drawer", (0.0, -1.0, 0.0), (0.0, 0.3), damping=10.0, frictionloss=6.0)
    turned = kit.hinge("knob_turn", "knob", kit.Y, (0.0, 2.0), damping=0.01, frictionloss=0.05)
    pressed = kit.slide("key_press", "key", kit.Y, (0.0, 0.004), damping=0.5, frictionloss=0.2)
    return Asset(
        **kit.named("cupboard", "Q614467", "furniture"),
        base=Base.FIXED,
        links=(_carcass(), _door(), _drawer(), _knob(), _key()),
        joints=(
            swung.replace(grip="door_handle"),
            pulled.replace(grip="drawer_handle"),
            turned.replace(grip="knob_grip"),
            pressed.replace(grip="key_cap", drive=Drive(stiffness=250.0, damping=0.0, target=-0.004)),
        ),
        regions=(
            Region(name="main", pose=Pose(position=(0.0, -0.03, 0.35)), size=(0.6, 0.46, 0.7)),
            Region(name="int", pose=Pose(position=(0.0, -0.01, 0.21)), size=(0.54, 0.36, 0.38)),
            Region(name="drawer_int", link="drawer", pose=Pose(position=(0.0, -0.02, 0.495)), size=(0.46, 0.3, 0.1)),
        ),
        states=(State(name="door_open", joint="door_hinge", value="open", interval=(0.9, 1.0)),),
        keyframes=(kit.keyframe("closed"), kit.keyframe("open", door_hinge=-1.5, drawer_slide=0.28)),
        materials=(
            Material(id="paint", base_color=(0.2, 0.3, 0.4, 1.0)),
            Material(id="brass", base_color=(0.7, 0.6, 0.3, 1.0), metallic=1.0),
            Material(id="oak", base_color=(0.5, 0.4, 0.2, 1.0), tile_m=TILE),
        ),
        substances=(kit.CARDBOARD, kit.STEEL),
    ).replace(provenance=kit.PROVENANCE.replace(source="family"))


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


def with_grip(joint: str, replaced: Shape, **changes: object) -> Asset:
    """The cupboard with the shape, and other fields, of the collider that a hand takes of a joint replaced."""
    whole = cupboard()
    moved = next(j for j in whole.joints if j.name == joint)
    shapes = whole.link(moved.child).colliders
    changed = (c.replace(shape=replaced, **changes) if c.name == moved.grip else c for c in shapes)
    return link_changed(moved.child, colliders=tuple(changed))


def with_mass_within(size: float) -> Asset:
    """The mass of its door lies in a cube of that side."""
    return link_changed("door", inertial=kit.box_inertial(4.0, (size, size, size), (0.27, -0.009, 0.0)))


def caught_by(lip: float) -> Asset:
    """A foot below its drawer meets a lip on the divider, which is so much too high, metres, right away."""
    drawer = with_shapes("drawer", shape("foot", (0.1, 0.1, 0.01), (0.0, 0.0, 0.43)))
    carcass = with_shapes("object", shape("catch", (0.1, 0.02, 0.02), (0.0, -0.06005, 0.415 + lip))).root
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
    return kit.link(
        "object",
        (18.0, (0.6, 0.4, 0.7), (0.0, 0.0, 0.35)),
        (kit.seen(f"{n}_panel", "paint", size, at) for n, (size, at) in CARCASS.items()),
        (shape(n, size, at) for n, (size, at) in CARCASS.items()),
    )


def _door() -> Link:
    size, middle = (0.55, 0.018, 0.37), (0.275, -0.009, 0.0)
    grip, at = (0.014, 0.014, 0.14), (0.5, -0.048, 0.08)
    panel = Visual(name="door_panel", mesh=metric(box_mesh(size, middle)), material="oak")
    return kit.link(
        "door",
        (4.0, size, middle),
        [panel, kit.seen("door_bar", "brass", grip, at, label="handle")],
        [shape("door_main", size, middle), shape("door_handle", grip, at, "steel", "handle")],
        pose=Pose(position=HINGE),
    )


def _drawer() -> Link:
    grip, at = (0.14, 0.014, 0.014), (0.0, -0.25, 0.515)
    seen = [kit.seen(f"{n}_panel", "paint", size, at) for n, (size, at) in DRAWER.items()]
    return kit.link(
        "drawer",
        (3.0, (0.5, 0.36, 0.14), (0.0, -0.03, 0.49)),
        [*seen, kit.seen("drawer_bar", "brass", grip, at, label="handle")],
        [*(shape(n, *place) for n, place in DRAWER.items()), shape("drawer_handle", grip, at, "steel", "handle")],
    )


def _knob() -> Link:
    size = (0.04, 0.03, 0.04)
    grip = kit.formed("knob_grip", Cylinder(radius=0.02, height=0.03), "steel", label="knob")
    grip = grip.replace(pose=Pose(quaternion=(math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)))
    seen = kit.seen("knob_cap", "brass", size)
    return kit.link("knob", (0.05, size, kit.HERE), [seen], [grip], pose=Pose(position=KNOB))


def _key() -> Link:
    size = (0.03, 0.01, 0.03)
    cap = shape("key_cap", size, kit.HERE, "steel", "button")
    return kit.link("key", (0.02, size, kit.HERE), [kit.seen("key_top", "brass", size)], [cap], pose=Pose(position=KEY))


def ball_of(diameter: float) -> Sphere:
    """A round grip."""
    return Sphere(radius=diameter / 2)
