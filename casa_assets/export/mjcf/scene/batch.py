"""Batch form of a scene -> one flat scene_batch.xml of primitives that sleep at rest, without impossible pairs.

Names are those of the other forms. Two geoms can touch if the contype of one has a bit of the conaffinity of the other.
The bits of `contype` and `conaffinity` are:

| | contype | conaffinity |
|---|---|---|
| added robots and objects, with MuJoCo's defaults | 1 | 1 |
| static parts | 1, THINGS | |
| static parts overhead | 1 | |
| loose objects | 1, THINGS | THINGS |
| moving parts of fixtures | 1, THINGS, bit of the set of parts that can meet | bit of that set |
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from lxml import etree

from casa_assets.export.mjcf import collider, contact, number
from casa_assets.export.mjcf.body import BodyContext
from casa_assets.export.mjcf.scene import room
from casa_assets.export.mjcf.scene.appearance import Appearance, Look
from casa_assets.export.mjcf.scene.kitchen import add_placement, add_poses, add_texts
from casa_assets.export.mjcf.visual import Meshes
from casa_assets.export.mujoco_values import VIEWER_GROUPS
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.files import Files
from casa_assets.model.kitchen.batch_scene import BatchScene

FILE = "scene_batch.xml"
# Bits of contype and conaffinity: of everything by default, of loose things, and the first of fixtures that can meet.
DEFAULT, THINGS, FIRST_MEETING = 1, 2, 2
# MuJoCo has 32 bits, the last of which is a sign.
LAST_MEETING = 30
# Everything that touches is seen.
GROUPS = replace(VIEWER_GROUPS, colliders=VIEWER_GROUPS.visuals)


def write(batch: BatchScene, sleeps: bool = True, shared: str = "../assets") -> Files:
    """Return the MJCF of the batch form of a scene; the same form gives the same bytes.

    Args:
        sleeps: let the engine skip bodies at rest until something touches or drives them. False for engines without
            sleep. No body is asleep in the file itself: mujoco_warp 4.0 rejects a model that begins so.
        shared: path from the folder of scene_batch.xml to the one that scenes share.
    Returns:
        `scene_batch.xml`, and the pictures of the shared folder as `assets/textures/<name>_<hash>.png`.
    """
    scene = batch.scene
    root = etree.Element("mujoco", {"model": scene.id})
    etree.SubElement(root, "compiler", {"angle": "radian", "autolimits": "true", "fusestatic": "true"})
    option = {"timestep": "0.002", "integrator": "implicitfast", "gravity": number.numbers(scene.gravity)}
    flags = {"multiccd": "enable", **({"sleep": "enable"} if sleeps else {})}
    etree.SubElement(etree.SubElement(root, "option", option), "flag", flags)
    room.add_frame(root, scene)
    assets = etree.SubElement(root, "asset")
    room.add_sky(assets, scene)
    world = etree.SubElement(root, "worldbody")
    room.add_lights_and_cameras(world, scene)
    full = {asset.id: asset for asset in scene.assets}
    appearance = Appearance(batch)
    _add_world(world, batch, full, appearance)
    contexts = []
    meeting = _meeting_bits(batch)
    for place, form in zip(scene.placements, batch.forms, strict=True):
        looks = {c.name: appearance.parts[place.name, c.name] for link in form.links for c in link.colliders}
        form = _turned(form, looks)
        context = BodyContext(form, Meshes((), {}), {}, GROUPS, place.name)
        body = add_placement(world, place, context)
        geoms = {geom.get("name"): geom for geom in body.iter("geom")}
        for name, look in looks.items():
            _paint(geoms[f"{place.name}__{name}"], look)
        if form.base is Base.FREE:
            _set_bits(body, DEFAULT | THINGS, THINGS)
        else:
            for link in form.links:
                bit = meeting.get((place.name, link.name), 0)
                _set_bits(_body(body, context.body_name(link.name)), DEFAULT | THINGS | bit, bit)
        contexts.append(context)
    block = etree.SubElement(root, "contact")
    for context in contexts:
        for exclusion in context.asset.exclusions:
            contact.add(block, exclusion, context)
    add_texts(root, scene, contexts)
    add_poses(root, scene, contexts)
    appearance.add_resources(assets, shared)
    text = etree.tostring(root, encoding="us-ascii", pretty_print=True)
    return Files.of({FILE: text, **appearance.resources.entries})


def _turned(form: Asset, looks: Mapping[str, Look]) -> Asset:
    """A form whose boxes are described as their looks require."""
    links = [
        link.replace(colliders=tuple(looks[collider.name].collider for collider in link.colliders))
        for link in form.links
    ]
    return form.replace(links=tuple(links))


def _paint(geom: etree._Element, look: Look) -> None:
    """Apply a look to a geom. Its colour is removed, since MuJoCo would use it instead of the material's."""
    del geom.attrib["rgba"]
    for name, value in look.attributes.items():
        geom.set(name, value)


def _add_world(world: etree._Element, batch: BatchScene, assets: Mapping[str, Asset], appearance: Appearance) -> None:
    """Add everything that never moves to the world body."""
    places = {place.name: place for place in batch.scene.placements}
    for item, look in zip(batch.world, appearance.world, strict=True):
        place = places[item.placement]
        substance = assets[place.asset].substance(item.collider.substance)
        group = VIEWER_GROUPS.shell if item.is_overhead else VIEWER_GROUPS.visuals
        geom = collider.add(world, look.collider, substance, Meshes((), {}), group, f"{item.placement}__")
        _paint(geom, look)
        geom.set("contype", str(DEFAULT if item.is_overhead else DEFAULT | THINGS))
        geom.set("conaffinity", "0")


def _meeting_bits(batch: BatchScene) -> dict[tuple[str, str], int]:
    """(placement, link) -> bit of the set of links that it can meet; if there are too many, sets share the last bit."""
    bits = {}
    for number_, group in enumerate(batch.meeting):
        bit = 1 << min(FIRST_MEETING + number_, LAST_MEETING)
        bits.update({(ref.placement, ref.link): bit for ref in group})
    return bits


def _body(root: etree._Element, name: str) -> etree._Element:
    """Return the body of that name: `root` or one below it."""
    return next(body for body in root.iter("body") if body.get("name") == name)


def _set_bits(body: etree._Element, contype: int, conaffinity: int) -> None:
    """Set the bits of the colliding geoms of a body; for a loose object, also of all bodies that it carries."""
    everything = conaffinity == THINGS
    for geom in body.iter("geom") if everything else body.findall("geom"):
        if geom.get("contype") == "1":
            geom.set("contype", str(contype))
            geom.set("conaffinity", str(conaffinity))
