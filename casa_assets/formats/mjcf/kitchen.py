"""Scene -> one flat scene.xml, and the meshes and images that it names in a folder that many scenes share."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from lxml import etree

from casa_assets.asset.shown_materials import collider_colors
from casa_assets.core.numeric import Floats
from casa_assets.formats.mjcf import document, shapes
from casa_assets.formats.mjcf.document import BodyContext
from casa_assets.formats.mjcf.shapes import Meshes, MeshFile, MeshUse, collision_bounds
from casa_assets.formats.values import VIEWER_GROUPS, Groups, number, numbers, srgb
from casa_assets.model.asset.asset import Asset, Base
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import (
    CLOSED_POSE,
    FREE_JOINT,
    OPEN_POSE,
    START_POSE,
    Layer,
    Light,
    LightKind,
    LightScene,
    PlacedLink,
    Placement,
    Scene,
    carried_pose,
    key_positions,
)
from casa_assets.model.pose import Pose

# Resources ------------------------------------------------------------------------------------------------------------
# Assets of a scene -> its meshes, images and materials, each once, in a folder that scenes share.

# Hexadecimal digits of a mesh's name: of a million meshes two share one with a probability of 1e-13.
HASH_DIGITS = 24
# The folder that scenes share, in the paths that the writer returns.
FOLDER = "assets"


@dataclass(frozen=True)
class SceneResources:
    """Meshes, images and materials that the assets of a scene share.

    Attributes:
        meshes: asset id -> its meshes; their paths are relative to the shared folder.
        textures: path relative to the shared folder -> image.
        materials: name in the document -> material.
    """

    meshes: dict[str, Meshes]
    textures: dict[str, Texture]
    materials: dict[str, Material]

    @property
    def mesh_files(self) -> tuple[MeshFile, ...]:
        """Every `<mesh>` once, in the order of first use."""
        return tuple({file.name: file for meshes in self.meshes.values() for file in meshes.files}.values())

    @property
    def entries(self) -> dict[str, bytes]:
        """`assets/...` -> content."""
        found = {f"{FOLDER}/{file.path}": file.data for file in self.mesh_files}
        return found | {f"{FOLDER}/{path}": image.png for path, image in self.textures.items()}


def gather(assets: Sequence[Asset]) -> SceneResources:
    """Collect meshes, images and materials of assets; meshes are named by content, so equal ones share a file."""
    textures: dict[str, Texture] = {}
    materials: dict[str, Material] = {}
    for asset in assets:
        textures |= shapes.texture_files(asset)
        materials |= {material_name(asset.id, item.id): item for item in asset.materials}
    return SceneResources({asset.id: _meshes(asset) for asset in assets}, textures, materials)


def material_name(asset: str, item: str) -> str:
    """Name of a material in the document of a scene."""
    return f"{asset}__{item}"


def add_shared_resources(assets: etree._Element, resources: SceneResources, folder: str) -> None:
    """Every `<texture>`, `<material>` and `<mesh>` below `<asset>`; `folder`: path from the document to the files."""
    for path, image in resources.textures.items():
        shapes.add_texture(assets, image, f"{folder}/{path}")
    for name, item in resources.materials.items():
        shapes.add_material(assets, item, name)
    for file in resources.mesh_files:
        shapes.add_mesh(assets, file, folder)


def _meshes(asset: Asset) -> Meshes:
    of: dict[str, MeshFile] = {}
    for name, mesh, use in shapes.mesh_uses(asset):
        data = shapes.obj_text(mesh, bare=use is MeshUse.HULL)
        content = hashlib.sha256(data).hexdigest()[:HASH_DIGITS]
        # A surface without normals may have the very file of a hull; MuJoCo takes the two for different meshes.
        mesh_name = content if use is MeshUse.SURFACE else f"{content}__{use.value}"
        of[name] = MeshFile(mesh_name, f"{shapes.MESHES}/{content}.obj", data, use)
    return Meshes(tuple({file.name: file for file in of.values()}.values()), of)


# Room -----------------------------------------------------------------------------------------------------------------

# Clipping distances: a camera at a wrist sees the fingers, and what lies beyond a window is not cut off.
NEAR_M, FAR_M = 0.015, 60.0
# The sun's map of shadows goes this many times as far as the scene. With less the upper parts of walls lie beyond its
# edge, and MuJoCo draws rows of dark specks there.
SHADOW_REACH = 2.0
# Specular light as a share of a light's colour. Chosen by eye, as in the scene of a single asset.
SPECULAR_SHARE = 0.5
# The exponent with which a spot of full softness fades towards its edge. Chosen by eye.
MAX_SPOT_EXPONENT = 20.0
# Cutoff of a light that shines to all sides, degrees.
ALL_SIDES_DEG = "180"
# The free camera starts this many extents from the middle. Ref: mjv_defaultFreeCamera.
FREE_CAMERA_EXTENTS = 1.5
# Camera of a kitchen that sees all of it.
OVERVIEW = "overview"
# Largest picture that is rendered off screen.
OFFSCREEN_SIZE = {"offwidth": "1920", "offheight": "1440"}


@dataclass(frozen=True, eq=False)
class FirstView:
    """Initial view of the free camera: (3,) target point and distance from it, metres; angles in degrees.

    `reach` is the distance of the corners of the scene from its middle, metres.
    """

    reach: float
    target: Floats
    distance: float
    azimuth_deg: float
    elevation_deg: float
    fov_y_deg: float


def _add_frame(root: etree._Element, scene: Scene) -> None:
    """`<statistic>` and `<visual>`: first view, rendering options and ambient light."""
    first = _first_view(scene)
    extent = first.distance / FREE_CAMERA_EXTENTS
    frame = {"center": numbers(first.target), "extent": number(extent), "meansize": "0.3"}
    etree.SubElement(root, "statistic", frame)
    view = etree.SubElement(root, "visual")
    angles = {"azimuth": number(first.azimuth_deg), "elevation": number(first.elevation_deg)}
    etree.SubElement(view, "global", {**angles, "fovy": number(first.fov_y_deg), **OFFSCREEN_SIZE})
    etree.SubElement(view, "quality", {"shadowsize": "4096", "offsamples": "4"})
    ambient = {"ambient": numbers(scene.ambient), "diffuse": "0 0 0", "specular": "0 0 0"}
    etree.SubElement(view, "headlight", ambient)
    near, far = number(NEAR_M / extent), number(FAR_M / extent)
    shadows = {"shadowclip": number(SHADOW_REACH * first.reach / extent), "shadowscale": "0.8"}
    etree.SubElement(view, "map", {"znear": near, "zfar": far, **shadows})
    if scene.sky is not None:
        etree.SubElement(view, "rgba", {"haze": f"{srgb(scene.sky.horizon)} 1"})


def _first_view(scene: Scene) -> FirstView:
    """View of the camera `overview` if it exists, so that the free camera starts where our pictures are taken."""
    lower, upper = scene_bounds(scene)
    middle, reach = (lower + upper) / 2, max(float(np.linalg.norm(upper - lower)) / 2, 0.1)
    for camera in scene.cameras:
        if camera.name == OVERVIEW:
            eye, forward = np.array(camera.pose.position), -camera.pose.rotation[:, 2]
            distance = round(max(float((middle - eye) @ forward), 0.1), 3)
            x, y, z = (float(v) for v in forward)
            # Rounded: arc functions differ between processors in their last bit.
            angles = round(math.degrees(math.atan2(y, x)), 2), round(math.degrees(math.asin(z)), 2)
            return FirstView(reach, eye + distance * forward, distance, *angles, camera.fov_y_deg)
    return FirstView(reach, middle, FREE_CAMERA_EXTENTS * reach, 65.0, -30.0, 50.0)


def add_sky(assets: etree._Element, scene: Scene) -> None:
    """Add the skybox below `<asset>` if the scene has a sky."""
    if scene.sky is None:
        return
    colors = {"rgb1": srgb(scene.sky.zenith), "rgb2": srgb(scene.sky.horizon)}
    sky = {"name": "sky", "type": "skybox", "builtin": "gradient", **colors, "width": "256", "height": "1536"}
    etree.SubElement(assets, "texture", sky)


def add_lights_and_cameras(world: etree._Element, scene: Scene) -> None:
    """`<light>` and `<camera>` elements below `<worldbody>`."""
    for light in scene.lights:
        etree.SubElement(world, "light", _light(light))
    for camera in scene.cameras:
        lens = {"name": camera.name, **shapes.place(camera.pose), "fovy": number(camera.fov_y_deg)}
        etree.SubElement(world, "camera", lens)


def scene_bounds(scene: Scene) -> npt.NDArray[np.float64]:
    """(2, 3) corners of everything in the scene except a ceiling, joints at zero, world frame, metres."""
    boxes = {asset.id: collision_bounds(asset) for asset in scene.assets}
    corners = []
    for place in scene.placements:
        if place.layer is not Layer.CEILING or len(scene.placements) == 1:
            bounds = boxes[place.asset]
            grid = np.array([[bounds[k >> i & 1][i] for i in range(3)] for k in range(8)])
            corners.append(place.pose.apply(grid))
    points = np.concatenate(corners) if corners else np.zeros((1, 3))
    return np.array([points.min(axis=0), points.max(axis=0)])


def _light(light: Light) -> dict[str, str]:
    length = float(np.linalg.norm(light.direction))
    attributes = {
        "name": light.name,
        # `type`, which says the same, is newer than MuJoCo 3.3.1.
        "directional": "true" if light.kind is LightKind.DIRECTIONAL else "false",
        "pos": numbers(light.position),
        "dir": numbers(d / length for d in light.direction),
        # Linear, unlike other colours: MuJoCo adds up light without converting it from sRGB.
        "diffuse": numbers(light.color),
        "specular": numbers(SPECULAR_SHARE * c for c in light.color),
        "castshadow": "true" if light.castshadow else "false",
        "bulbradius": number(light.radius),
    }
    if light.kind is LightKind.DIRECTIONAL:
        return attributes
    attributes["attenuation"] = numbers(light.attenuation)
    if light.kind is LightKind.SPOT:
        exponent = number(MAX_SPOT_EXPONENT * light.softness)
        return attributes | {"cutoff": number(light.cone_deg), "exponent": exponent}
    return attributes | {"cutoff": ALL_SIDES_DEG, "exponent": "0"}


# Kitchen --------------------------------------------------------------------------------------------------------------
# Scene -> one flat scene.xml, and its meshes and images in a folder that many scenes share.
#
# Names: the root body of a placement has the placement's name, everything else in it `<placement>__<name>`; the joint
# of a free base is `<placement>__free`.

FILE = "scene.xml"


def write(scene: Scene | LightScene, shared: str = "../assets", groups: Groups = VIEWER_GROUPS) -> Files:
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
    shared_files = gather([] if light else list(assets.values()))
    contexts = [_context(place, assets[place.asset], shared_files, colors, groups) for place in scene.placements]
    text = _document(scene, contexts, shared_files, shared, is_light=light is not None)
    return Files.of({FILE: text, **shared_files.entries})


def light_colors(asset: Asset, light: Asset) -> dict[str, str]:
    """Collider of a light form -> `rgba`, three digits: colour of the full asset's visuals at that collider."""
    known = {name: numbers(round(c, 3) for c in color) for name, color in collider_colors(asset).items()}
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
        materials={item.id: material_name(asset.id, item.id) for item in asset.materials},
        groups=replace(groups, colliders=hidden, visuals=shown),
        placement=place.name,
        collider_colors=colors.get(asset.id, {}),
    )


def _document(
    scene: Scene, contexts: list[BodyContext], shared_files: SceneResources, folder: str, is_light: bool
) -> bytes:
    root, assets, world = begin_document(scene, is_fused=is_light)
    add_shared_resources(assets, shared_files, folder)
    for place, context in zip(scene.placements, contexts, strict=True):
        root_body = add_placement(world, place, context)
        if is_light and context.asset.base is Base.FIXED:
            document.exclude_from_world(root_body)
    add_exclusions(root, contexts, () if is_light else scene.exclusions)
    add_texts(root, scene, contexts)
    add_poses(root, scene, contexts)
    return etree.tostring(root, encoding="us-ascii", pretty_print=True)


def begin_document(scene: Scene, is_fused: bool, **flags: str) -> tuple[etree._Element, etree._Element, etree._Element]:
    """Root, `<asset>` and `<worldbody>` of a scene's document, with its sky, lights and cameras.

    Args:
        is_fused: what never moves becomes one body with the world, and MuJoCo computes about half as many poses per
            step. flags: of `<flag>`, besides several contacts between a pair of meshes, so that things at rest do
            not rock, which MuJoCo 4 has by default.
    """
    root = etree.Element("mujoco", {"model": scene.id})
    fused = {"fusestatic": "true"} if is_fused else {}
    etree.SubElement(root, "compiler", {"angle": "radian", "autolimits": "true", **fused})
    option = {"timestep": "0.002", "integrator": "implicitfast", "gravity": numbers(scene.gravity)}
    etree.SubElement(etree.SubElement(root, "option", option), "flag", {"multiccd": "enable", **flags})
    _add_frame(root, scene)
    assets = etree.SubElement(root, "asset")
    add_sky(assets, scene)
    world = etree.SubElement(root, "worldbody")
    add_lights_and_cameras(world, scene)
    return root, assets, world


def world_from_root(place: Placement, asset: Asset) -> Pose:
    """Pose of the root link of a placement in the world."""
    return place.pose @ asset.root.pose


def add_placement(world: etree._Element, place: Placement, context: BodyContext) -> etree._Element:
    """`<body>` of a placement below the world, with a free joint if its base is free."""
    root = context.asset.root.replace(pose=world_from_root(place, context.asset))
    root_body = document.add_body(world, root, context)
    if context.asset.base is Base.FREE:
        root_body.insert(0, etree.Element("freejoint", {"name": context.prefix + FREE_JOINT}))
    return root_body


def add_exclusions(
    root: etree._Element, contexts: list[BodyContext], scene_pairs: Sequence[tuple[PlacedLink, PlacedLink]] = ()
) -> None:
    """Add the contact exclusions of each asset and those of the scene, each pair once."""
    block = etree.SubElement(root, "contact")
    for context in contexts:
        for exclusion in context.asset.exclusions:
            document.add_exclusion(block, exclusion, context)
    of_placement = {context.placement: context for context in contexts}
    written = {frozenset((e.get("body1", ""), e.get("body2", ""))) for e in block}
    for pair in scene_pairs:
        first, second = (of_placement[end.placement].body_name(end.link) for end in pair)
        if frozenset((first, second)) not in written:
            document.exclude(block, first, second)


def add_texts(root: etree._Element, scene: Scene, contexts: list[BodyContext]) -> None:
    """Add the texts of each asset, and the asset and layer of each placement."""
    custom = etree.SubElement(root, "custom")
    for place, context in zip(scene.placements, contexts, strict=True):
        labels = document.label_texts(context.asset, context.prefix)
        texts = {"asset": place.asset, "layer": place.layer.value, **labels}
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
        joints = document.joint_order(asset, asset.root.name)
        base = world_from_root(place, asset)
        for name, values in qpos.items():
            carried = carried_pose(place, placements, assets, name)
            pose = base if carried is None else carried @ asset.root.pose
            free_joint = (*pose.position, *pose.quaternion) if asset.base is Base.FREE else ()
            values += [*free_joint, *(positions[name].get(joint, 0.0) for joint in joints)]
    block = etree.SubElement(root, "keyframe")
    for name, values in qpos.items():
        etree.SubElement(block, "key", {"name": name, **({"qpos": numbers(values)} if values else {})})
