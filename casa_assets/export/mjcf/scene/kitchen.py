"""Scene -> one flat scene.xml, and the meshes and images that it names in a folder that many scenes share.

Names: the root body of a placement is called like it, everything else in it `<placement>__<name>`; the joint of a free
base is `<placement>__free`. Groups of geoms: 0 collides, 1 is seen, 2 is the ceiling, which the viewer hides by a key.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lxml import etree

from casa_assets.export.mjcf import body, collider, contact, keyframe, label, mean_color, number, visual
from casa_assets.export.mjcf.mesh import Meshes
from casa_assets.export.mjcf.scene import resources, room
from casa_assets.export.mjcf.scene.resources import SceneResources
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.files import Files
from casa_assets.model.kitchen.scene import FREE_JOINT, Layer, LightScene, PlacedLink, Placement, Scene
from casa_assets.model.pose import Pose

FILE = "scene.xml"
CEILING_GROUP = 2
# Poses that every scene has: as it begins, everything closed (which is zero), and all that has such a pose open.
START, CLOSED, OPEN = "start", "closed", "open"


@dataclass(frozen=True)
class Groups:
    """MuJoCo's groups of geoms that collide, that are seen, and that are seen of a ceiling."""

    touched: int = collider.GROUP
    seen: int = visual.GROUP
    ceiling: int = CEILING_GROUP


def write(
    scene: Scene | LightScene,
    shared: str = "../assets",
    groups: Groups | None = None,
) -> Files:
    """The MJCF of a scene; the same scene is the same bytes.

    The light form has no images and no meshes; what collides is seen, in the mean colour of what it stands for. In it
    what is fixed and what moves on it are never tried for contact, wherever they are. In the full form they are, but
    for the pairs that the scene excludes, which is what the USD says as well.

    Args:
        scene: what to write, whole or in its light form.
        shared: leads from the folder of scene.xml to the shared folder.
        groups: of geoms; those of robosuite where None.
    Returns:
        `scene.xml`, and the files of the shared folder as `assets/meshes/<hash>.obj` and
        `assets/textures/<name>_<hash>.png`.
    """
    light = scene if isinstance(scene, LightScene) else None
    scene = scene if isinstance(scene, Scene) else scene.scene
    assets = {asset.id: asset for asset in (light.forms if light else scene.assets)}
    tints = {asset.id: _tints(asset, assets[asset.id]) for asset in scene.assets} if light else {}
    parts = resources.gather([] if light else list(assets.values()))
    drafts = [_draft(place, assets[place.asset], parts, tints, groups or Groups()) for place in scene.placements]
    text = _document(scene, drafts, parts, shared, spared=light is not None)
    return Files.of({FILE: text, **parts.entries})


def _tints(asset: Asset, light: Asset) -> dict[str, str]:
    """Collider of the light asset -> colour."""
    known = mean_color.collider_colors(asset)
    names = [item.name for link in light.links for item in link.colliders]
    return {name: known[name] if name in known else known[LightScene.collider_of(name)] for name in names}


def _draft(
    place: Placement, asset: Asset, parts: SceneResources, tints: Mapping[str, Mapping[str, str]], groups: Groups
) -> body.BodyContext:
    ceiling = place.layer is Layer.CEILING
    seen_as_touched = asset.id in tints
    return body.BodyContext(
        asset=asset,
        meshes=parts.meshes.get(asset.id, Meshes((), {})),
        materials={item.id: resources.material_name(asset.id, item.id) for item in asset.materials},
        touched=groups.ceiling if ceiling and seen_as_touched else groups.touched,
        seen=groups.ceiling if ceiling else groups.seen,
        placement=place.name,
        tints=tints.get(asset.id, {}),
    )


def _document(scene: Scene, drafts: list[body.BodyContext], parts: SceneResources, folder: str, spared: bool) -> bytes:
    root = etree.Element("mujoco", {"model": scene.id})
    compiler = {"angle": "radian", "autolimits": "true"}
    if spared:
        # What never moves becomes one body with the world, and MuJoCo has about half as many poses to find each step.
        compiler["fusestatic"] = "true"
    etree.SubElement(root, "compiler", compiler)
    option = {"timestep": "0.002", "integrator": "implicitfast", "gravity": number.numbers(scene.gravity)}
    # Several contacts between a pair of meshes, so that what stands does not rock. MuJoCo 4 does so by itself.
    etree.SubElement(etree.SubElement(root, "option", option), "flag", {"multiccd": "enable"})
    room.add_frame(root, scene)
    assets = etree.SubElement(root, "asset")
    room.add_sky(assets, scene)
    resources.add_all(assets, parts, folder)
    world = etree.SubElement(root, "worldbody")
    room.add_lights(world, scene)
    for place, draft in zip(scene.placements, drafts, strict=True):
        placed = _add_placement(world, place, draft)
        if spared and draft.asset.base is Base.FIXED:
            contact.exclude_from_world(placed)
    _add_exclusions(root, drafts, () if spared else scene.exclusions)
    _add_texts(root, scene, drafts)
    _add_poses(root, scene, drafts)
    return etree.tostring(root, encoding="us-ascii", pretty_print=True)


def world_from_root(place: Placement, asset: Asset) -> Pose:
    """Pose of the root link of a placement in the world."""
    return place.pose @ asset.root.pose


def _add_placement(world: etree._Element, place: Placement, draft: body.BodyContext) -> etree._Element:
    root = draft.asset.root.replace(pose=world_from_root(place, draft.asset))
    placed = body.add(world, root, draft)
    if draft.asset.base is Base.FREE:
        placed.insert(0, etree.Element("freejoint", {"name": draft.prefix + FREE_JOINT}))
    return placed


def _add_exclusions(
    root: etree._Element, drafts: list[body.BodyContext], more: Sequence[tuple[PlacedLink, PlacedLink]]
) -> None:
    """Add the contact exclusions of each asset, and those of the scene."""
    pairs = etree.SubElement(root, "contact")
    for draft in drafts:
        for exclusion in draft.asset.exclusions:
            contact.add(pairs, exclusion, draft)
    of = {draft.placement: draft for draft in drafts}
    said = {tuple(sorted((e.get("body1", ""), e.get("body2", "")))) for e in pairs}
    for pair in more:
        first, second = (of[end.placement].body_name(end.link) for end in pair)
        if tuple(sorted((first, second))) not in said:
            contact.exclude(pairs, first, second)


def _add_texts(root: etree._Element, scene: Scene, drafts: list[body.BodyContext]) -> None:
    """The texts of each asset, and for each placement which asset it is and what it belongs to."""
    custom = etree.SubElement(root, "custom")
    for place, draft in zip(scene.placements, drafts, strict=True):
        said = {"asset": place.asset, "layer": place.layer.value, **label.texts(draft.asset, draft.prefix)}
        for name, data in said.items():
            etree.SubElement(custom, "text", {"name": draft.prefix + name, "data": data})


def _add_poses(root: etree._Element, scene: Scene, drafts: list[body.BodyContext]) -> None:
    poses: dict[str, list[float]] = {START: [], CLOSED: [], OPEN: []}
    for place, draft in zip(scene.placements, drafts, strict=True):
        asset = draft.asset
        named = {key.name: {at.joint: at.value for at in key.joints} for key in asset.keyframes}
        closed = named.get(CLOSED, {})
        stands = {START: {at.joint: at.value for at in place.joints}, CLOSED: closed, OPEN: named.get(OPEN, closed)}
        base = world_from_root(place, asset)
        free = (*base.position, *base.quaternion) if asset.base is Base.FREE else ()
        order = keyframe.joints(asset, asset.root.name)
        for name, values in poses.items():
            values += [*free, *(stands[name].get(joint, 0.0) for joint in order)]
    block = etree.SubElement(root, "keyframe")
    for name, values in poses.items():
        position = {"qpos": number.numbers(values)} if values else {}
        etree.SubElement(block, "key", {"name": name, **position})
