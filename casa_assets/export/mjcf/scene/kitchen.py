"""Scene -> one flat scene.xml, and its meshes and images in a folder that many scenes share.

Names: the root body of a placement has the placement's name, everything else in it `<placement>__<name>`; the joint of
a free base is `<placement>__free`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from lxml import etree

from casa_assets.export.mjcf import body, contact, keyframe, label, number
from casa_assets.export.mjcf.body import BodyContext
from casa_assets.export.mjcf.scene import resources, room
from casa_assets.export.mjcf.scene.resources import SceneResources
from casa_assets.export.mjcf.visual import Meshes
from casa_assets.export.mujoco_values import VIEWER_GROUPS, Groups
from casa_assets.geometry.collider_colors import collider_colors
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.files import Files
from casa_assets.model.kitchen.named_poses import carried_pose, key_positions
from casa_assets.model.kitchen.scene import (
    CLOSED_POSE,
    FREE_JOINT,
    OPEN_POSE,
    START_POSE,
    Layer,
    LightScene,
    PlacedLink,
    Placement,
    Scene,
)
from casa_assets.model.pose import Pose

FILE = "scene.xml"


def write(
    scene: Scene | LightScene,
    shared: str = "../assets",
    groups: Groups = VIEWER_GROUPS,
) -> Files:
    """Return the MJCF of a scene; the same scene gives the same bytes.

    The light form has no images and no meshes: its colliders are drawn, in the mean colour of the visuals that they
    represent. In it, no contact is possible between fixed bodies and bodies that move on a fixed base. In the full
    form, only the pairs that the scene excludes never collide, as in the USD.

    Args:
        scene: the scene, in its full or light form.
        shared: path from the folder of scene.xml to the shared folder.
        groups: groups of geoms; ROBOSUITE_GROUPS for files that robosuite merges into its own model.
    Returns:
        `scene.xml`, and the files of the shared folder as `assets/meshes/<hash>.obj` and
        `assets/textures/<name>_<hash>.png`.
    """
    light = scene if isinstance(scene, LightScene) else None
    scene = scene if isinstance(scene, Scene) else scene.scene
    assets = {asset.id: asset for asset in (light.light_assets if light else scene.assets)}
    colors = {asset.id: light_colors(asset, assets[asset.id]) for asset in scene.assets} if light else {}
    shared_files = resources.gather([] if light else list(assets.values()))
    contexts = [_context(place, assets[place.asset], shared_files, colors, groups) for place in scene.placements]
    text = _document(scene, contexts, shared_files, shared, is_light=light is not None)
    return Files.of({FILE: text, **shared_files.entries})


def light_colors(asset: Asset, light: Asset) -> dict[str, str]:
    """Collider of a light form -> `rgba`, three digits: colour of the full asset's visuals at that collider."""
    known = {name: number.numbers(round(c, 3) for c in color) for name, color in collider_colors(asset).items()}
    names = [collider.name for link in light.links for collider in link.colliders]
    return {name: known[name] if name in known else known[LightScene.collider_of(name)] for name in names}


def _context(
    place: Placement,
    asset: Asset,
    shared_files: SceneResources,
    colors: Mapping[str, Mapping[str, str]],
    groups: Groups,
) -> BodyContext:
    shown = groups.shell if place.layer is Layer.CEILING else groups.visuals
    # Colliders that are drawn are shown: robosuite's cameras hide the group that only collides.
    hidden = shown if asset.id in colors else groups.colliders
    return BodyContext(
        asset=asset,
        meshes=shared_files.meshes.get(asset.id, Meshes((), {})),
        materials={item.id: resources.material_name(asset.id, item.id) for item in asset.materials},
        groups=replace(groups, colliders=hidden, visuals=shown),
        placement=place.name,
        collider_colors=colors.get(asset.id, {}),
    )


def _document(
    scene: Scene, contexts: list[BodyContext], shared_files: SceneResources, folder: str, is_light: bool
) -> bytes:
    root = etree.Element("mujoco", {"model": scene.id})
    compiler = {"angle": "radian", "autolimits": "true"}
    if is_light:
        # What never moves becomes one body with the world, and MuJoCo computes about half as many poses per step.
        compiler["fusestatic"] = "true"
    etree.SubElement(root, "compiler", compiler)
    option = {"timestep": "0.002", "integrator": "implicitfast", "gravity": number.numbers(scene.gravity)}
    # Several contacts between a pair of meshes, so that what stands does not rock. MuJoCo 4 does so by default.
    etree.SubElement(etree.SubElement(root, "option", option), "flag", {"multiccd": "enable"})
    room.add_frame(root, scene)
    assets = etree.SubElement(root, "asset")
    room.add_sky(assets, scene)
    resources.add_all(assets, shared_files, folder)
    world = etree.SubElement(root, "worldbody")
    room.add_lights_and_cameras(world, scene)
    for place, context in zip(scene.placements, contexts, strict=True):
        root_body = add_placement(world, place, context)
        if is_light and context.asset.base is Base.FIXED:
            contact.exclude_from_world(root_body)
    _add_exclusions(root, contexts, () if is_light else scene.exclusions)
    add_texts(root, scene, contexts)
    add_poses(root, scene, contexts)
    return etree.tostring(root, encoding="us-ascii", pretty_print=True)


def world_from_root(place: Placement, asset: Asset) -> Pose:
    """Pose of the root link of a placement in the world."""
    return place.pose @ asset.root.pose


def add_placement(world: etree._Element, place: Placement, context: BodyContext) -> etree._Element:
    """`<body>` of a placement below the world, with a free joint if its base is free."""
    root = context.asset.root.replace(pose=world_from_root(place, context.asset))
    root_body = body.add(world, root, context)
    if context.asset.base is Base.FREE:
        root_body.insert(0, etree.Element("freejoint", {"name": context.prefix + FREE_JOINT}))
    return root_body


def _add_exclusions(
    root: etree._Element, contexts: list[BodyContext], scene_pairs: Sequence[tuple[PlacedLink, PlacedLink]]
) -> None:
    """Add the contact exclusions of each asset and those of the scene, each pair once."""
    block = etree.SubElement(root, "contact")
    for context in contexts:
        for exclusion in context.asset.exclusions:
            contact.add(block, exclusion, context)
    of_placement = {context.placement: context for context in contexts}
    written = {frozenset((e.get("body1", ""), e.get("body2", ""))) for e in block}
    for pair in scene_pairs:
        first, second = (of_placement[end.placement].body_name(end.link) for end in pair)
        if frozenset((first, second)) not in written:
            contact.exclude(block, first, second)


def add_texts(root: etree._Element, scene: Scene, contexts: list[BodyContext]) -> None:
    """Add the texts of each asset, and the asset and layer of each placement."""
    custom = etree.SubElement(root, "custom")
    for place, context in zip(scene.placements, contexts, strict=True):
        texts = {"asset": place.asset, "layer": place.layer.value, **label.texts(context.asset, context.prefix)}
        for name, data in texts.items():
            etree.SubElement(custom, "text", {"name": context.prefix + name, "data": data})


def add_poses(root: etree._Element, scene: Scene, contexts: list[BodyContext]) -> None:
    """Add the keyframes `start`, `closed` and `open`: joints that an asset's own keyframe does not name are at zero.

    Objects that rest in a drawer move along with it.
    """
    qpos: dict[str, list[float]] = {START_POSE: [], CLOSED_POSE: [], OPEN_POSE: []}
    placements, assets = {place.name: place for place in scene.placements}, scene.asset_of
    for place, context in zip(scene.placements, contexts, strict=True):
        asset = context.asset
        positions = key_positions(place, asset)
        joints = keyframe.joint_order(asset, asset.root.name)
        base = world_from_root(place, asset)
        for name, values in qpos.items():
            carried = carried_pose(place, placements, assets, name)
            pose = base if carried is None else carried @ asset.root.pose
            free_joint = (*pose.position, *pose.quaternion) if asset.base is Base.FREE else ()
            values += [*free_joint, *(positions[name].get(joint, 0.0) for joint in joints)]
    block = etree.SubElement(root, "keyframe")
    for name, values in qpos.items():
        etree.SubElement(block, "key", {"name": name, **({"qpos": number.numbers(values)} if values else {})})
