"""Small fixtures that keep a contract of the registry, built in code, and what is done to them to break it."""

from __future__ import annotations

import math
from pathlib import Path

from casa_assets import registry
from casa_assets.checks.check import Package
from casa_assets.formats.mjcf import write
from casa_assets.model.asset.asset import Asset, Base, Collider, JointValue, Keyframe, Link, Region, Site, Visual
from casa_assets.model.asset.behavior import Behavior, Condition, Effect, EffectKind, Rule, Variable
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Cylinder
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from casa_assets.model.registry.contract import Contract
from tests.support.asset import asset_parts as kit
from tests.support.asset.articulated_assets import microwave
from tests.support.asset.assets import category, write_to
from tests.support.mesh.meshes import box_mesh

LOW, HIGH = 0.35, math.radians(80)


def packed(asset: Asset, folder: Path, contract: Contract | None = None) -> Package:
    """The MJCF package of an asset below `folder`, with the contract that it names unless another is given."""
    root = write_to(write(asset), folder / asset.id)
    known = registry.load().contracts.get(asset.contract or "")
    return Package(asset, category(asset), root, contract or known)


def block(name: str, size: Vec3, at: Vec3, label: str | None = None) -> Collider:
    return kit.box_collider(name, size, at, "steel", label=label)


def oven() -> Asset:
    """A microwave oven with everything that the contract `microwave` asks for."""
    plain = microwave()
    keys = (
        block("start_button", (0.03, 0.01, 0.02), (0.2, -0.184, 0.05), "button"),
        block("stop_button", (0.03, 0.01, 0.02), (0.2, -0.184, 0.1), "button"),
    )
    tray = kit.formed("tray", Cylinder(radius=0.15, height=0.006), "steel", (-0.04, 0.0, 0.027))
    grip = block("door_handle_main", (0.02, 0.02, 0.2), (0.35, -0.05, 0.0), "handle")
    leaf = plain.link("door")
    door = leaf.replace(
        colliders=(leaf.colliders[0].replace(name="door", label="door"), grip),
        visuals=(*leaf.visuals, kit.seen("grip_seen", "enamel", (0.02, 0.02, 0.2), (0.35, -0.05, 0.0), label="handle")),
    )  # fmt: skip
    root = plain.root.replace(colliders=(*plain.root.colliders, *keys, tray))
    low, high = (-0.25, -0.21, 0.0), (0.25, 0.2, 0.3)
    middle = tuple((a + b) / 2 for a, b in zip(low, high, strict=True))
    size = tuple(b - a for a, b in zip(low, high, strict=True))
    return plain.replace(
        contract="microwave",
        links=(root, door),
        regions=(Region(name="main", pose=Pose(position=middle), size=size), *plain.regions[:2]),
        keyframes=(
            Keyframe(name="closed"),
            Keyframe(name="open", joints=(JointValue(joint="microjoint", value=-math.pi / 2),)),
        ),
        behavior=heating(),
    )


def heating() -> Behavior:
    """Start heats while the door is closed; stop and the door end it."""
    ajar = Condition(joint="microjoint", interval=(-math.pi / 2, -0.005 * math.pi / 2))
    start, stop = (Condition(contact=f"{name}_button", begins=True) for name in ("start", "stop"))
    return Behavior(
        variables=(Variable(name="power", values=("off", "on"), initial="off"),),
        rules=(
            Rule(variable="power", from_values=("on",), to="off", when=(ajar,)),
            Rule(variable="power", from_values=("on",), to="off", when=(stop,)),
            Rule(variable="power", from_values=("off",), to="on", when=(start, ajar.replace(negated=True))),
        ),
        effects=(Effect(variable="power", value="on", kind=EffectKind.HEAT, target="int"),),
    )


def hob() -> Asset:
    """A hob of one burner with everything that the contract `stovetop` asks for."""
    plate: tuple[Vec3, Vec3] = ((0.3, 0.5, 0.02), (0.0, 0.0, 0.01))
    dial: tuple[Vec3, Vec3] = ((0.04, 0.04, 0.02), (0.0, 0.0, 0.012))
    knob = Link(
        name="knob_left",
        parent="object",
        pose=Pose(position=(0.0, -0.2, 0.02)),
        inertial=kit.box_inertial(0.05, *dial),
        visuals=(kit.seen("knob_seen", "enamel", *dial, label="knob"),),
        colliders=(block("knob_left_main", *dial, "knob"),),
    )
    ring = box_mesh((0.15, 0.15, 0.001), (0.0, 0.05, 0.0205))
    root = Link(
        name="object",
        inertial=kit.box_inertial(4.0, *plate),
        visuals=(
            kit.seen("plate", "enamel", *plate),
            Visual(name="ring", mesh=ring, material="enamel", label="burner"),
        ),
        colliders=(block("plate_0", *plate),),
    )
    flame = Site(name="burner_on_left", pose=Pose(position=(0.0, 0.05, 0.03)), kind="cylinder", size=(0.12, 0.12, 0.02))
    return Asset(
        id="hob_0123456789",
        base=Base.FIXED,
        links=(root, knob),
        joints=(
            kit.hinge(
                "knob_left_joint",
                "knob_left",
                (0.0, 0.0, -1.0),
                (0.0, math.pi),
                frictionloss=0.05,
                grip="knob_left_main",
            ),
        ),
        sites=(flame, Site(name="burner_left_place_site", pose=Pose(position=(0.0, 0.05, 0.021)))),
        regions=(Region(name="main", pose=Pose(position=(0.0, 0.0, 0.01)), size=(0.3, 0.5, 0.02)),),
        keyframes=(
            Keyframe(name="closed"),
            Keyframe(name="on", joints=(JointValue(joint="knob_left_joint", value=2.0),)),
        ),
        behavior=burning(LOW, HIGH),
        contract="stovetop",
        materials=(Material(id="enamel", base_color=(0.1, 0.1, 0.1, 1.0), roughness=0.3, substance="steel"),),
        substances=(kit.STEEL,),
        labels=kit.labels("hob", ("hob", "appliance"), "Q127956"),
        provenance=kit.PROVENANCE,
    )


def burning(low: float, high: float) -> Behavior:
    """A burner that is low from one angle on and high from another, rad."""
    spans = {"off": (0.0, low), "low": (low, high), "high": (high, math.pi)}
    return Behavior(
        variables=(Variable(name="burner_left", values=("off", "low", "high"), initial="off"),),
        rules=tuple(
            Rule(variable="burner_left", to=value, when=(Condition(joint="knob_left_joint", interval=span),))
            for value, span in spans.items()
        ),
        effects=tuple(
            Effect(variable="burner_left", value=v, kind=EffectKind.SHOW, target="burner_on_left")
            for v in ("low", "high")
        ),
    )
