"""Asset -> model.xml of an object for RoboCasa's loaders of both generations, with its meshes and images.

One file serves both: v0.2 reads sizes from three sites next to the body `object`, v1.0 from the geom `reg_bbox` in it.
Elements that the loaders drop (exclusions, keyframes, options) are not written; attributes that they need on every geom
(group, pos, and size of three or two numbers) are written on the geom itself. Lids are always shut: RoboCasa sets the
pose of an object through its first joint, and robosuite adds the free joint after those in the file.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from lxml import etree

from casa_assets.addons.robocasa.writers.kitchens.parts import moved
from casa_assets.formats.mjcf import document, shapes
from casa_assets.formats.values import ROBOSUITE_GROUPS, numbers
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.files import Files
from casa_assets.model.pose import Pose

# Ref: robocasa v1.0, add_obj_liquid_site: the categories whose objects it is called for.
HOLD_LIQUID = ("cup", "glass_cup", "mug", "bowl", "pot", "pan", "saucepan")
LIQUID_SHARE = 0.8  # of width and height of such a vessel
# Ref: robocasa, folders beside the model.xml of an object.
VISUAL_FOLDER, COLLISION_FOLDER = "visual", "collision"
FILE, UPRIGHT_FILE = "model.xml", "model_upright.xml"


def write(asset: Asset, stood_up: bool = False) -> Files:
    """Return the files of one object; the same asset gives the same bytes.

    Args:
        asset: free to move; z up, origin under the middle of its footprint.
        stood_up: also write `model_upright.xml`, the same object turned upright onto its end or its edge.
    Returns:
        `model.xml`, `visual/*.obj`, `visual/*.png`, `collision/*.obj`; paths are relative to the XML. The origin is at
        half the height: RoboCasa tests only the origin to decide whether an object is in a sink or on a shelf, and an
        origin at the foot would sink slightly out of it.
    """
    rigid = asset.replace(joints=(), states=(), keyframes=(), exclusions=(), behavior=None)
    asset = moved(rigid, np.array((0.0, 0.0, asset.bounds[:, 2].mean())))
    thick = thickened(asset)
    meshes = _gather(thick)
    entries = {file.path: file.data for file in meshes.files}
    images = shapes.texture_files(asset).values()
    entries |= {f"{VISUAL_FOLDER}/{image.file_name}": image.png for image in images}
    root = _document(thick, meshes)
    (outer,) = root.findall("worldbody/body")
    shapes.add_size_sites(outer, asset)
    entries[FILE] = _text(root)
    if stood_up:
        stand_up(root, asset)
        entries[UPRIGHT_FILE] = _text(root)
    return Files.of(entries)


def _gather(asset: Asset) -> shapes.Meshes:
    """The mesh files of an asset in the folders that RoboCasa uses."""
    meshes = shapes.gather_meshes(asset)
    visual_paths = {meshes.of[v.name].path for link in asset.links for v in link.visuals}
    placed = {}
    for file in meshes.files:
        folder = VISUAL_FOLDER if file.path in visual_paths else COLLISION_FOLDER
        placed[file.name, file.use] = replace(file, path=f"{folder}/{file.path.rpartition('/')[2]}")
    return shapes.Meshes(
        files=tuple(placed.values()),
        of={name: placed[file.name, file.use] for name, file in meshes.of.items()},
    )


def _document(asset: Asset, meshes: shapes.Meshes) -> etree._Element:
    root = etree.Element("mujoco", {"model": asset.id})
    etree.SubElement(root, "compiler", {"angle": "radian", "autolimits": "true"})
    assets = etree.SubElement(root, "asset")
    for image in shapes.texture_files(asset).values():
        shapes.add_texture(assets, image, f"{VISUAL_FOLDER}/{image.file_name}")
    names = shapes.material_names(asset)
    for look in asset.materials:
        shapes.add_material(assets, look, names[look.id])
    with_volume = {meshes.of[name].name for name, shape, _ in shapes.mesh_uses(asset) if has_volume(shape)}
    for file in meshes.files:
        shapes.add_mesh(assets, file)
        if file.use is shapes.MeshUse.SURFACE and file.name in with_volume:
            assets[-1].set("inertia", "legacy")  # MuJoCo 3.2.6 does not know `shell`
    world = etree.SubElement(root, "worldbody")
    outer = etree.SubElement(world, "body")
    root_body = document.add_body(outer, asset.root, document.BodyContext(asset, meshes, names, ROBOSUITE_GROUPS))
    if root_body.find(f"geom[@name='reg_{shapes.OUTER_REGIONS[0]}']") is None:
        found = next(region for region in asset.regions if region.name in shapes.OUTER_REGIONS)
        shapes.add_region(root_body, found.replace(name=shapes.OUTER_REGIONS[0]), ROBOSUITE_GROUPS.regions)
    if asset.labels.category in HOLD_LIQUID:
        # Tasks colour the site `liquid` of a vessel: an upright cylinder inside it, invisible until then.
        lower, upper = asset.bounds
        radius, half_height = LIQUID_SHARE * min(upper[:2] - lower[:2]) / 2, LIQUID_SHARE * (upper[2] - lower[2]) / 2
        at, size = numbers((0.0, 0.0, (lower[2] + upper[2]) / 2)), numbers((radius, half_height))
        attributes = {"name": "liquid", "type": "cylinder", "pos": at, "size": size, "rgba": "0 0 0 0"}
        etree.SubElement(root_body, "site", attributes)
    document.add_labels(root, asset)
    return root


def _text(root: etree._Element) -> bytes:
    return etree.tostring(root, encoding="us-ascii", pretty_print=True)


# Meshes without volume ------------------------------------------------------------------------------------------------
# MuJoCo refuses a mesh without volume, even a visual one without mass, unless its `inertia` is `shell`. RoboCasa v0.2
# needs MuJoCo 3.2.6, which does not know that value.

# A hundred times what MuJoCo calls too small, m^3. Ref: MuJoCo 3.2, mjMINVAL in its compiler of meshes.
MIN_VOLUME_M3 = 1e-13
# Height of the pyramid behind a flat face: share of the face's width, and at most so many metres. A choice: too small
# to be seen.
DEPTH_SHARE, MAX_DEPTH_M = 0.1, 0.0005


def has_volume(mesh: Mesh) -> bool:
    """True if MuJoCo's oldest method finds a volume in a mesh (metres), closed or not.

    Ref: MuJoCo XML reference, asset/mesh/inertia, `legacy`: tetrahedra from the middle to all faces, without their
    signs.
    """
    corners = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    if not areas.sum() > 0:
        return False
    a, b, c = np.moveaxis(corners - np.average(corners.mean(axis=1), axis=0, weights=areas), 1, 0)
    return float(np.abs(np.einsum("fd,fd->f", a, np.cross(b, c))).sum()) / 6 > MIN_VOLUME_M3


def thickened(asset: Asset) -> Asset:
    """The asset with a small pyramid behind the largest face of every flat visual (a label, a blade)."""
    links = []
    for link in asset.links:
        is_flat = [not has_volume(visual.mesh) for visual in link.visuals]
        visuals = [
            v.replace(mesh=_with_pyramid(v.mesh)) if f else v for v, f in zip(link.visuals, is_flat, strict=True)
        ]
        links.append(link.replace(visuals=tuple(visuals)) if any(is_flat) else link)
    return asset.replace(links=tuple(links))


def _with_pyramid(mesh: Mesh) -> Mesh:
    """A mesh with a pyramid added on the back of its largest face."""
    corners = mesh.vertices[mesh.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled_areas = np.linalg.norm(normals, axis=1)
    largest = int(np.argmax(np.round(doubled_areas, 12)))
    if not doubled_areas[largest] > 0:
        return mesh
    normal = normals[largest] / doubled_areas[largest]
    depth = min(DEPTH_SHARE * float(np.sqrt(doubled_areas[largest])), MAX_DEPTH_M)
    a, b, c = (int(i) for i in mesh.faces[largest])
    tip = len(mesh.vertices)
    return Mesh(
        vertices=np.vstack([mesh.vertices, corners[largest].mean(axis=0) - depth * normal]),
        faces=np.vstack([mesh.faces, [(b, a, tip), (c, b, tip), (a, c, tip)]]),
        uv=None if mesh.uv is None else np.vstack([mesh.uv, mesh.uv[[a, b, c]].mean(axis=0)]),
        normals=None if mesh.normals is None else np.vstack([mesh.normals, -normal]),
    )


# Upright --------------------------------------------------------------------------------------------------------------
# The document of a lying object, turned upright by a quarter turn, as in a toaster or a cup.
#
# Ref: robocasa v1.0 reads `model_upright.xml` next to `model.xml` if a task asks for it (slices of bread, straws).

# Longer than this many times its width it stands on end (a straw), else on its edge (a slice of bread), whose thickness
# is along x: toasters have their slots beside each other along x, and tasks put bread into them without turning it.
MIN_SLENDERNESS = 2.5
ON_EDGE = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])  # y goes up; z, the thickness, goes along x
AROUND_Y = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])  # x goes up


def turn_of(asset: Asset) -> Pose:
    """stood_from_lying: quarter turns, and the translation that moves the middle of the object back to the origin.

    An object that is taller than wide is not turned.
    """
    lower, upper = asset.bounds
    x, y, z = upper - lower
    if z >= max(x, y):
        return Pose()
    rotation = AROUND_Y if x > MIN_SLENDERNESS * y else ON_EDGE
    corners = asset.bounds @ rotation.T
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    matrix = np.eye(4)
    matrix[:3, :3] = rotation
    matrix[:3, 3] = -(lower + upper) / 2
    return Pose.from_matrix(matrix)


def stand_up(root: etree._Element, asset: Asset) -> None:
    """Turn all elements in the document of an object in place; meshes and their files are not changed."""
    turn = turn_of(asset)
    if turn == Pose():
        return
    (outer,) = root.findall("worldbody/body")
    for element in outer.findall("body/*"):
        if element.tag == "inertial":
            _turn_inertial(element, turn)
        elif element.get("name", "").startswith("reg_") and element.get("type") == "box":
            _turn_box(element, turn)
        else:
            _turn_pose(element, turn)
    corners = turn.apply(asset.bounds)
    lower, upper = corners.min(axis=0), corners.max(axis=0)
    points = {
        "bottom_site": (0.0, 0.0, lower[2]),
        "top_site": (0.0, 0.0, upper[2]),
        "horizontal_radius_site": (*(upper[:2] - lower[:2]) / 2, 0.0),
    }
    for name, point in points.items():
        for site in outer.findall(f"site[@name='{name}']"):
            site.set("pos", _numbers_text(point))


def _numbers(element: etree._Element, name: str, default: str = "") -> list[float]:
    return [float(word) for word in element.get(name, default).split()]


def _turned(element: etree._Element, turn: Pose) -> Pose:
    x, y, z = _numbers(element, "pos", "0 0 0")
    a, b, c, d = _numbers(element, "quat", "1 0 0 0")
    return turn @ Pose(position=(x, y, z), quaternion=(a, b, c, d))


def _turn_pose(element: etree._Element, turn: Pose) -> None:
    pose = _turned(element, turn)
    element.set("pos", _numbers_text(pose.position))
    if any(pose.quaternion[1:]):
        element.set("quat", _numbers_text(pose.quaternion))
    elif "quat" in element.attrib:
        del element.attrib["quat"]


def _turn_box(element: etree._Element, turn: Pose) -> None:
    """Turn an axis-aligned box so that it stays one: runtimes ignore the rotation of a region."""
    pose = _turned(element, turn)
    half = np.abs(pose.rotation) @ np.array(_numbers(element, "size"))
    element.set("pos", _numbers_text(pose.position))
    element.set("size", _numbers_text(half))
    if "quat" in element.attrib:
        del element.attrib["quat"]


def _turn_inertial(element: etree._Element, turn: Pose) -> None:
    xx, yy, zz, xy, xz, yz = _numbers(element, "fullinertia")
    tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    rotated = np.rint(turn.rotation) @ tensor @ np.rint(turn.rotation).T  # a quarter turn only changes places and signs
    element.set("pos", _numbers_text(turn.apply(np.array([_numbers(element, "pos", "0 0 0")]))[0]))
    inertia = (rotated[0, 0], rotated[1, 1], rotated[2, 2], rotated[0, 1], rotated[0, 2], rotated[1, 2])
    element.set("fullinertia", numbers(inertia))


def _numbers_text(values: Iterable[float]) -> str:
    """Text with twelve decimals: a quarter turn must not leave rounding errors such as 1e-17."""
    return numbers(round(float(value), 12) for value in values)
