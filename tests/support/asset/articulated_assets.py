"""Small assets with joints, built in code."""

from __future__ import annotations

import math

from casa_assets.model.asset.asset import Asset, Base, Drive, Exclusion, Inertial, Link, Region, Site, State
from casa_assets.model.asset.behavior import Behavior, Condition, Effect, EffectKind, Rule, Variable
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Cylinder, Hull
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from tests.support.asset import asset_parts as kit
from tests.support.mesh.meshes import box_mesh


def microwave(base: Base = Base.FIXED) -> Asset:
    """A microwave oven: carcass and door, one hinge, an exclusion, regions, a site and two states."""
    panels: dict[str, tuple[Vec3, Vec3]] = {
        "bottom": ((0.5, 0.38, 0.02), (0.0, 0.01, 0.01)),
        "top": ((0.5, 0.38, 0.02), (0.0, 0.01, 0.29)),
        "left": ((0.02, 0.38, 0.26), (-0.24, 0.01, 0.15)),
        "right": ((0.1, 0.38, 0.26), (0.2, 0.01, 0.15)),
        "back": ((0.38, 0.02, 0.26), (-0.04, 0.19, 0.15)),
    }
    carcass = kit.link(
        "object",
        (9.0, (0.5, 0.38, 0.3), (0.0, 0.01, 0.15)),
        (kit.seen(f"{n}_panel", "enamel", *p) for n, p in panels.items()),
        (kit.box_collider(f"{n}_0", size, at, "steel") for n, (size, at) in panels.items()),
    )
    size, at = (0.38, 0.02, 0.28), (0.19, -0.01, 0.0)
    door = kit.link(
        "door",
        (1.5, size, at),
        [kit.seen("door_main", "glass", size, at)],
        [kit.box_collider("door_0", size, (0.19, -0.011, 0.0), "steel")],
        pose=Pose(position=(-0.24, -0.19, 0.15)),
    )
    turned = kit.hinge("microjoint", "door", kit.Z, (-math.pi / 2, 0.0), damping=0.5, frictionloss=0.3)
    return Asset(
        **kit.named("microwave", "Q127956", "appliance"),
        base=base,
        links=(carcass, door),
        joints=(turned.replace(anchor=(0.0, -0.02, 0.0), armature=0.01),),
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
        substances=(kit.STEEL,),
    )


def drawer_unit() -> Asset:
    """A cabinet with a driven drawer in a turned frame, and a knob that is rigidly attached to the drawer."""
    turned = Pose(position=(0.0, -0.05, 0.1), quaternion=(math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5)))
    plate, box = ((0.4, 0.5, 0.02), (0.0, 0.0, 0.01)), (0.4, 0.3, 0.1)
    board = kit.box_collider("carcass_0", *plate, "steel")
    hull = kit.formed("box_0", Hull(mesh=box_mesh(box, kit.HERE, shared=True)), "cardboard")
    hull = hull.replace(pose=Pose(quaternion=(math.cos(0.1), 0.0, 0.0, math.sin(0.1))))
    grip = kit.formed("knob_0", Cylinder(radius=0.01, height=0.03), "steel")
    pulled = kit.slide("drawer_joint", "drawer", (-1.0, 0.0, 0.0), (0.0, 0.28), damping=2.0)
    return Asset(
        **kit.named("cabinet", "Q1049754", "furniture"),
        base=Base.FIXED,
        links=(
            kit.link("object", (8.0, *plate), [kit.seen("carcass", "paint", *plate)], [board]),
            kit.link("drawer", (2.0, box, (0.01, 0.02, 0.0)), [kit.seen("box", "paint", box)], [hull], pose=turned),
            Link(
                name="knob",
                parent="drawer",
                pose=Pose(position=(-0.22, 0.0, 0.0), quaternion=(math.cos(0.3), math.sin(0.3), 0.0, 0.0)),
                inertial=Inertial(mass=0.05, center_of_mass=kit.HERE, inertia=(1e-5, 1e-5, 8e-6, 0.0, 0.0, 0.0)),
                visuals=(kit.seen("knob_main", "paint", (0.03, 0.03, 0.03)),),
                colliders=(grip.replace(pose=Pose(quaternion=(math.cos(0.4), 0.0, math.sin(0.4), 0.0))),),
            ),
        ),
        joints=(pulled.replace(drive=Drive(stiffness=5.0, damping=1.5, target=0.0)),),
        states=(State(name="drawer_open", joint="drawer_joint", value="open", interval=(0.9, 1.0)),),
        exclusions=(Exclusion(first="knob", second="object"),),
        materials=(Material(id="paint", base_color=(0.2, 0.3, 0.4, 1.0), substance="steel"),),
        substances=(kit.CARDBOARD, kit.STEEL),
    )


def grill() -> Asset:
    """The microwave with all that a stateful fixture may have.

    A handle that the door carries, a rack behind the door, a turned knob, glow, labels, grips, coloured sites of each
    kind, named poses, a state machine and a contract.
    """
    plain = microwave()
    door = plain.link("door")
    door = door.replace(
        visuals=tuple(v.replace(label="door") for v in door.visuals),
        colliders=tuple(c.replace(label="door") for c in door.colliders),
    )
    lamp = kit.seen("lamp_main", "lamp", (0.06, 0.04, 0.01), (-0.04, 0.1, 0.27), label="lamp")
    swung = plain.joints[0].replace(grip="handle_0")
    pulled = kit.slide("rack_joint", "rack", (0.0, -1.0, 0.0), (0.0, 0.2), damping=3.0, frictionloss=0.5)
    twisted = kit.hinge("knob_joint", "knob", (0.1, 0.0, 1.0), (0.0, 2.4), damping=0.01, armature=1e-4, grip="knob_0")
    carried = Pose(position=(0.36, -0.05, 0.0), quaternion=(math.cos(0.1), 0.0, 0.0, math.sin(0.1)))
    at_top = Pose(position=(-0.04, 0.0, 0.26), quaternion=(math.cos(0.2), 0.0, math.sin(0.2), 0.0))
    dial = (0.03, 0.03, 0.03)
    grip = kit.formed("knob_0", Cylinder(radius=0.015, height=0.03), "steel", label="knob")
    # Its z looks out of the front.
    fixed = Pose(position=(0.2, -0.2, 0.1), quaternion=(math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0))
    seen = kit.seen("knob_main", "enamel", dial, label="knob")
    knob = kit.link("knob", (0.05, dial, kit.HERE), [seen], [grip], pose=fixed)
    return plain.replace(
        id="grill_0123456789",
        links=(
            plain.root.replace(visuals=(*plain.root.visuals, lamp)),
            door,
            _plate("handle", "door", carried, 0.2, (0.02, 0.02, 0.2)),
            _plate("rack", "object", Pose(position=(-0.04, 0.0, 0.1)), 0.6, (0.34, 0.3, 0.01)),
            knob,
        ),
        joints=(
            swung,
            pulled.replace(grip="rack_0", behind="microjoint"),
            twisted.replace(anchor=(0.001, 0.002, 0.0), drive=Drive(stiffness=0.02, damping=0.002, target=0.1)),
        ),
        sites=(
            *plain.sites,
            Site(name="heat_glow", kind="cylinder", size=(0.3, 0.3, 0.02), color=(1.0, 0.2, 0.05, 0.0), pose=at_top),
            Site(name="display", link="knob", kind="box", size=(0.02, 0.04, 0.001), color=(0.02, 0.6, 0.001, 1.0)),
        ),
        regions=(*plain.regions, Region(name="main", pose=Pose(position=(0.0, 0.01, 0.15)), size=(0.5, 0.38, 0.3))),
        keyframes=(
            kit.keyframe("closed"),
            kit.keyframe("on", knob_joint=1.2),
            kit.keyframe("open", rack_joint=0.15, microjoint=-1.3),
        ),
        behavior=_grilling(),
        contract="microwave",
        materials=(*plain.materials, Material(id="lamp", base_color=(1.0, 0.8, 0.5, 1.0), glow=0.7, substance="glass")),
        labels=kit.labels("grill", ("grill", "appliance"), "Q187528"),
    )


def _plate(name: str, parent: str, pose: Pose, mass: float, size: Vec3) -> Link:
    """A box of steel around its origin."""
    seen = kit.seen(f"{name}_main", "enamel", size, label=name)
    shape = kit.box_collider(f"{name}_0", size, kit.HERE, "steel", label=name)
    return kit.link(name, (mass, size, kit.HERE), [seen], [shape], pose=pose, parent=parent)


def _grilling() -> Behavior:
    turned = Condition(joint="knob_joint", interval=(0.5, 2.4))
    shown = Effect(variable="power", value="on", kind=EffectKind.SHOW, target="heat_glow", color=(1.0, 0.2, 0.05, 0.5))
    return Behavior(
        variables=(Variable(name="power", values=("off", "on"), initial="off"),),
        rules=(
            Rule(variable="power", to="on", when=(turned,)),
            Rule(variable="power", to="off", when=(turned.replace(negated=True),), after_s=0.5),
        ),
        effects=(shown, Effect(variable="power", value="on", kind=EffectKind.LIGHT, target="lamp_main")),
    )
