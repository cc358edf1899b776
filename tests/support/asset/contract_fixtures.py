"""Small fixtures that keep a contract of the registry, built in code, and what is done to them to break it."""

from __future__ import annotations

import math
from pathlib import Path

from casa_assets import registry
from casa_assets.checks.check import Package
from casa_assets.formats.mjcf import write
from casa_assets.model.asset.asset import Asset, Base, Collider, Region, Site
from casa_assets.model.asset.behavior import Behavior, Condition, Effect, EffectKind, Rule, Variable
from casa_assets.model.asset.material import Material
from casa_assets.model.asset.parts import Cylinder
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from casa_assets.model.registry.contract import Contract
from tests.support.asset import asset_parts as kit
from tests.support.asset.articulated_assets import microwave
from tests.support.asset.assets import category, write_to

LOW, HIGH = 0.35, math.radians(80)


def packed(asset: Asset, folder: Path, contract: Contract | None = None) -> Package:
    """The MJCF package of an asset below `folder`, with the contract that it names unless another is given."""
    named = contract or registry.load().contracts.get(asset.contract or "")
    return Package(asset, category(asset), write_to(write(asset), folder / asset.id), named)


def block(name: str, size: Vec3, at: Vec3, label: str | None = None) -> Collider:
    return kit.box_collider(name, size, at, "steel", label=label)


def oven() -> Asset:
    """A microwave oven with everything that the contract `microwave` asks for."""
    plain = microwave()
    key = (0.03, 0.01, 0.02)
    start, stop = (block(f"{n}_button", key, (0.2, -0.184, z), "button") for n, z in (("start", 0.05), ("stop", 0.1)))
    tray = kit.formed("tray", Cylinder(radius=0.15, height=0.006), "steel", (-0.04, 0.0, 0.027))
    grip: tuple[Vec3, Vec3] = ((0.02, 0.02, 0.2), (0.35, -0.05, 0.0))
    leaf = plain.link("door")
    door = leaf.replace(
        colliders=(leaf.colliders[0].replace(name="door", label="door"), block("door_handle_main", *grip, "handle")),
        visuals=(*leaf.visuals, kit.seen("grip_seen", "enamel", *grip, label="handle")),
    )
    root = plain.root.replace(colliders=(*plain.root.colliders, start, stop, tray))
    main = Region(name="main", pose=Pose(position=(0.0, (-0.21 + 0.2) / 2, 0.15)), size=(0.5, 0.2 - -0.21, 0.3))
    return plain.replace(
        contract="microwave",
        links=(root, door),
        regions=(main, *plain.regions[:2]),
        keyframes=(kit.keyframe("closed"), kit.keyframe("open", microjoint=-math.pi / 2)),
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
    shape = block("knob_left_main", *dial, "knob")
    seen = kit.seen("knob_seen", "enamel", *dial, label="knob")
    knob = kit.link("knob_left", (0.05, *dial), [seen], [shape], pose=Pose(position=(0.0, -0.2, 0.02)))
    ring = kit.seen("ring", "enamel", (0.15, 0.15, 0.001), (0.0, 0.05, 0.0205), label="burner")
    root = kit.link("object", (4.0, *plate), [kit.seen("plate", "enamel", *plate), ring], [block("plate_0", *plate)])
    turned = kit.hinge("knob_left_joint", "knob_left", (0.0, 0.0, -1.0), (0.0, math.pi), frictionloss=0.05)
    flame = Site(name="burner_on_left", pose=Pose(position=(0.0, 0.05, 0.03)), kind="cylinder", size=(0.12, 0.12, 0.02))
    return Asset(
        **kit.named("hob", "Q127956", "appliance"),
        base=Base.FIXED,
        links=(root, knob),
        joints=(turned.replace(grip="knob_left_main"),),
        sites=(flame, Site(name="burner_left_place_site", pose=Pose(position=(0.0, 0.05, 0.021)))),
        regions=(Region(name="main", pose=Pose(position=plate[1]), size=plate[0]),),
        keyframes=(kit.keyframe("closed"), kit.keyframe("on", knob_left_joint=2.0)),
        behavior=burning(LOW, HIGH),
        contract="stovetop",
        materials=(Material(id="enamel", base_color=(0.1, 0.1, 0.1, 1.0), roughness=0.3, substance="steel"),),
        substances=(kit.STEEL,),
    )


def burning(low: float, high: float) -> Behavior:
    """A burner that is low from one angle on and high from another, rad."""
    spans = {"off": (0.0, low), "low": (low, high), "high": (high, math.pi)}
    shown = Effect(variable="burner_left", value="low", kind=EffectKind.SHOW, target="burner_on_left")
    return Behavior(
        variables=(Variable(name="burner_left", values=("off", "low", "high"), initial="off"),),
        rules=tuple(
            Rule(variable="burner_left", to=value, when=(Condition(joint="knob_left_joint", interval=span),))
            for value, span in spans.items()
        ),
        effects=tuple(shown.replace(value=value) for value in ("low", "high")),
    )
