"""Small assets with joints, built in code."""

from __future__ import annotations

import math

from casa_assets.model.asset.asset import (
    Asset,
    Base,
    Drive,
    Exclusion,
    Inertial,
    Joint,
    JointValue,
    Keyframe,
    Link,
    Region,
    Site,
    State,
)
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
    carcass = Link(
        name="object",
        inertial=kit.box_inertial(9.0, (0.5, 0.38, 0.3), (0.0, 0.01, 0.15)),
        visuals=tuple(kit.seen(f"{n}_panel", "enamel", *p) for n, p in panels.items()),
        colliders=tuple(kit.box_collider(f"{n}_0", size, at, "steel") for n, (size, at) in panels.items()),
    )
    door_size: Vec3 = (0.38, 0.02, 0.28)
    door = Link(
        name="door",
        parent="object",
        pose=Pose(position=(-0.24, -0.19, 0.15)),
        inertial=kit.box_inertial(1.5, door_size, (0.19, -0.01, 0.0)),
        visuals=(kit.seen("door_main", "glass", door_size, (0.19, -0.01, 0.0)),),
        colliders=(kit.box_collider("door_0", door_size, (0.19, -0.011, 0.0), "steel"),),
    )
    return Asset(
        id="microwave_0123456789",
        base=base,
        links=(carcass, door),
        joints=(
            kit.hinge("microjoint", "door", kit.Z, (-math.pi / 2, 0.0), damping=0.5, frictionloss=0.3).replace(
                anchor=(0.0, -0.02, 0.0), armature=0.01
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
        substances=(kit.STEEL,),
        labels=kit.labels("microwave", ("microwave", "appliance"), "Q127956"),
        provenance=kit.PROVENANCE,
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
                inertial=kit.box_inertial(8.0, (0.4, 0.5, 0.02), (0.0, 0.0, 0.01)),
                visuals=(kit.seen("carcass", "paint", (0.4, 0.5, 0.02), (0.0, 0.0, 0.01)),),
                colliders=(kit.box_collider("carcass_0", (0.4, 0.5, 0.02), (0.0, 0.0, 0.01), "steel"),),
            ),
            Link(
                name="drawer",
                parent="object",
                pose=turned,
                inertial=kit.box_inertial(2.0, (0.4, 0.3, 0.1), (0.01, 0.02, 0.0)),
                visuals=(kit.seen("box", "paint", (0.4, 0.3, 0.1)),),
                colliders=(
                    kit.formed(
                        "box_0", Hull(mesh=box_mesh((0.4, 0.3, 0.1), kit.HERE, shared=True)), "cardboard"
                    ).replace(pose=Pose(quaternion=(math.cos(0.1), 0.0, 0.0, math.sin(0.1)))),
                ),
            ),
            Link(
                name="knob",
                parent="drawer",
                pose=Pose(position=(-0.22, 0.0, 0.0), quaternion=(math.cos(0.3), math.sin(0.3), 0.0, 0.0)),
                inertial=Inertial(mass=0.05, center_of_mass=(0.0, 0.0, 0.0), inertia=(1e-5, 1e-5, 8e-6, 0.0, 0.0, 0.0)),
                visuals=(kit.seen("knob_main", "paint", (0.03, 0.03, 0.03)),),
                colliders=(
                    kit.formed("knob_0", Cylinder(radius=0.01, height=0.03), "steel").replace(
                        pose=Pose(quaternion=(math.cos(0.4), 0.0, math.sin(0.4), 0.0))
                    ),
                ),
            ),
        ),
        joints=(
            kit.slide("drawer_joint", "drawer", (-1.0, 0.0, 0.0), (0.0, 0.28), damping=2.0).replace(
                drive=Drive(stiffness=5.0, damping=1.5, target=0.0)
            ),
        ),
        states=(State(name="drawer_open", joint="drawer_joint", value="open", interval=(0.9, 1.0)),),
        exclusions=(Exclusion(first="knob", second="object"),),
        materials=(Material(id="paint", base_color=(0.2, 0.3, 0.4, 1.0), substance="steel"),),
        substances=(kit.CARDBOARD, kit.STEEL),
        labels=kit.labels("cabinet", ("cabinet", "furniture"), "Q1049754"),
        provenance=kit.PROVENANCE,
    )


def grill() -> Asset:
    """The microwave with all that a stateful fixture may have.

    A handle that the door carries, a rack behind the door, a turned knob, glow, labels, grips, coloured sites of each
    kind, named poses, a state machine and a contract.
    """
    plain = microwave()
    door = plain.link("door")
    lamp = kit.seen("lamp_main", "lamp", (0.06, 0.04, 0.01), (-0.04, 0.1, 0.27), label="lamp")
    swung = plain.joints[0].replace(grip="handle_0")
    return plain.replace(
        id="grill_0123456789",
        links=(
            plain.root.replace(visuals=(*plain.root.visuals, lamp)),
            door.replace(
                visuals=tuple(v.replace(label="door") for v in door.visuals),
                colliders=tuple(c.replace(label="door") for c in door.colliders),
            ),
            *_grill_parts(),
        ),
        joints=(swung, *_grill_joints()),
        sites=(
            *plain.sites,
            Site(name="heat_glow", kind="cylinder", size=(0.3, 0.3, 0.02), color=(1.0, 0.2, 0.05, 0.0), pose=_AT_TOP),
            Site(name="display", link="knob", kind="box", size=(0.02, 0.04, 0.001), color=(0.02, 0.6, 0.001, 1.0)),
        ),
        regions=(*plain.regions, Region(name="main", pose=Pose(position=(0.0, 0.01, 0.15)), size=(0.5, 0.38, 0.3))),
        keyframes=(
            Keyframe(name="closed"),
            Keyframe(name="on", joints=(JointValue(joint="knob_joint", value=1.2),)),
            Keyframe(
                name="open",
                joints=(JointValue(joint="rack_joint", value=0.15), JointValue(joint="microjoint", value=-1.3)),
            ),
        ),
        behavior=_grilling(),
        contract="microwave",
        materials=(*plain.materials, Material(id="lamp", base_color=(1.0, 0.8, 0.5, 1.0), glow=0.7, substance="glass")),
        labels=kit.labels("grill", ("grill", "appliance"), "Q187528"),
    )


_AT_TOP = Pose(position=(-0.04, 0.0, 0.26), quaternion=(math.cos(0.2), 0.0, math.sin(0.2), 0.0))


def _plate(name: str, parent: str, pose: Pose, mass: float, size: Vec3) -> Link:
    """A box of steel around its origin."""
    return Link(
        name=name,
        parent=parent,
        pose=pose,
        inertial=kit.box_inertial(mass, size, kit.HERE),
        visuals=(kit.seen(f"{name}_main", "enamel", size, label=name),),
        colliders=(kit.box_collider(f"{name}_0", size, kit.HERE, "steel", label=name),),
    )


def _grill_parts() -> tuple[Link, ...]:
    carried = Pose(position=(0.36, -0.05, 0.0), quaternion=(math.cos(0.1), 0.0, 0.0, math.sin(0.1)))
    return (
        _plate("handle", "door", carried, 0.2, (0.02, 0.02, 0.2)),
        _plate("rack", "object", Pose(position=(-0.04, 0.0, 0.1)), 0.6, (0.34, 0.3, 0.01)),
        Link(
            name="knob",
            parent="object",
            # Its z looks out of the front.
            pose=Pose(position=(0.2, -0.2, 0.1), quaternion=(math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)),
            inertial=kit.box_inertial(0.05, (0.03, 0.03, 0.03), kit.HERE),
            visuals=(kit.seen("knob_main", "enamel", (0.03, 0.03, 0.03), label="knob"),),
            colliders=(kit.formed("knob_0", Cylinder(radius=0.015, height=0.03), "steel", label="knob"),),
        ),
    )


def _grill_joints() -> tuple[Joint, ...]:
    return (
        kit.slide("rack_joint", "rack", (0.0, -1.0, 0.0), (0.0, 0.2), damping=3.0, frictionloss=0.5).replace(
            grip="rack_0", behind="microjoint"
        ),
        kit.hinge(
            "knob_joint", "knob", (0.1, 0.0, 1.0), (0.0, 2.4), damping=0.01, armature=1e-4, grip="knob_0"
        ).replace(anchor=(0.001, 0.002, 0.0), drive=Drive(stiffness=0.02, damping=0.002, target=0.1)),
    )


def _grilling() -> Behavior:
    turned = Condition(joint="knob_joint", interval=(0.5, 2.4))
    return Behavior(
        variables=(Variable(name="power", values=("off", "on"), initial="off"),),
        rules=(
            Rule(variable="power", to="on", when=(turned,)),
            Rule(variable="power", to="off", when=(turned.replace(negated=True),), after_s=0.5),
        ),
        effects=(
            Effect(variable="power", value="on", kind=EffectKind.SHOW, target="heat_glow", color=(1.0, 0.2, 0.05, 0.5)),
            Effect(variable="power", value="on", kind=EffectKind.LIGHT, target="lamp_main"),
        ),
    )
