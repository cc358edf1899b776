"""Visuals, colliders, sites and materials -> elements of MJCF, with the OBJ files and pictures that they name."""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import numpy.typing as npt
from lxml import etree
from PIL import Image, ImageStat

from casa_assets.formats.values import FORMAT, SITE_GROUP, contact_dimensions, number, numbers, site_group, srgb
from casa_assets.mesh.solid.primitive import link_bounds
from casa_assets.model.asset.asset import Asset, Collider, Region, Site, Visual
from casa_assets.model.asset.material import Material, Substance, Texture
from casa_assets.model.asset.parts import MAX_HULL_VERTICES, Box, Capsule, Cylinder, Hull, Mesh, MeshShape, Sphere
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3


def place(pose: Pose) -> dict[str, str]:
    """Attributes `pos` and, unless there is no rotation, `quat` of parent_from_element."""
    attributes = {"pos": numbers(pose.position)}
    if any(pose.quaternion[1:]):
        attributes["quat"] = numbers(pose.quaternion)
    return attributes


def rows(prefix: str, array: npt.NDArray[np.float64]) -> str:
    """(N, K) values rounded to float32, one line each: `v 0.1 0.2 0.3`."""
    single = array.astype(np.float32).astype(np.float64) + 0.0  # + 0.0 turns -0.0 into 0.0
    line = " ".join([prefix, *[FORMAT] * array.shape[1]]) + "\n"
    return (line * len(array)) % tuple(single.ravel().tolist())


# Material -------------------------------------------------------------------------------------------------------------
# Material -> `<texture>` and `<material>`.
#
# MuJoCo's own renderer draws one colour image per material. Maps of roughness and normals would have to be `<layer>`
# elements, which MuJoCo does not accept together with the `texture` attribute, the only one that robosuite knows. So
# only the colour image is written, metallic and roughness are one number each for the whole surface; only USD has the
# maps.

TEXTURES = "textures"
# MuJoCo multiplies shininess by this to get the exponent of the highlight. Ref: MuJoCo XML reference, asset/material.
FULL_EXPONENT = 128.0


def material_names(asset: Asset) -> dict[str, str]:
    """Material id -> name in the document, unique per content: consumers merge materials of many models by name."""
    return {m.id: f"{m.id}_{m.digest[:12]}" for m in asset.materials}


def texture_files(asset: Asset) -> dict[str, Texture]:
    """Path relative to model.xml -> colour image, in the order of first use."""
    images = [m.base_color_texture for m in asset.materials]
    return {texture_path(image): image for image in images if image is not None}


def add_materials(assets: etree._Element, asset: Asset) -> None:
    """Every `<texture>`, then every `<material>`, below `<asset>`."""
    for path, image in texture_files(asset).items():
        add_texture(assets, image, path)
    for material, name in zip(asset.materials, material_names(asset).values(), strict=True):
        add_material(assets, material, name)


def add_texture(assets: etree._Element, image: Texture, path: str) -> None:
    """`<texture>` of an image whose file is at `path`, relative to the document."""
    etree.SubElement(assets, "texture", {"name": _stem(image), "type": "2d", "file": path})


def add_material(assets: etree._Element, material: Material, name: str) -> None:
    """`<material>` named `name`, with a reference to the texture of its colour image."""
    metallic, roughness = material.metallic, material.roughness
    if material.metallic_roughness_texture is not None:
        # The mean of the map over the whole surface.
        with Image.open(io.BytesIO(material.metallic_roughness_texture.png)) as image:
            _, green, blue = ImageStat.Stat(image.convert("RGB")).mean
        metallic, roughness = metallic * blue / 255, roughness * green / 255
    metallic, roughness = round(metallic, 3), round(roughness, 3)
    attributes = {"name": name}
    if material.base_color_texture is not None:
        attributes |= {"texture": _stem(material.base_color_texture), "texuniform": "false"}
    attributes |= {
        "rgba": srgb(material.base_color),
        # Strength of the highlight, 0..1: zero on rough surfaces, full on polished metal. Chosen by eye.
        "specular": number((1.0 - roughness) * (0.4 + 0.6 * metallic)),
        "shininess": number(_shininess(roughness)),
        "metallic": number(metallic),
        "roughness": number(roughness),
    }
    if material.glow:
        attributes["emission"] = number(material.glow)
    etree.SubElement(assets, "material", attributes)


def _shininess(roughness: float) -> float:
    """Width of the highlight, 0..1, from the Blinn-Phong exponent 2 / a^2 - 2 with a = roughness^2.

    Ref: Walter et al. 2007, Microfacet models for refraction; the exponent is capped at MuJoCo's largest.
    """
    alpha = max(roughness, 0.05) ** 2
    return min(1.0, (2.0 / alpha**2 - 2.0) / FULL_EXPONENT)


def texture_path(image: Texture) -> str:
    """Path of an image, relative to model.xml or to the folder that scenes share."""
    return f"{TEXTURES}/{image.file_name}"


def _stem(image: Texture) -> str:
    return image.file_name.removesuffix(".png")


# Visual ---------------------------------------------------------------------------------------------------------------

MESHES = "meshes"


class MeshUse(StrEnum):
    """Purpose of a mesh; the value is MuJoCo's `inertia` of the mesh."""

    HULL = "convex"  # exact for a closed convex mesh
    SURFACE = "shell"  # asks for no volume: open, flat and inside-out meshes load too


@dataclass(frozen=True)
class MeshFile:
    """A `<mesh>` and the file behind it.

    Attributes:
        name: unique per content, since consumers merge the assets of many models by name.
        path: relative to model.xml.
        data: OBJ text.
        use: hull or surface.
    """

    name: str
    path: str
    data: bytes
    use: MeshUse


@dataclass(frozen=True)
class Meshes:
    """The mesh files of an asset, in the order of first use; `of` maps a visual's or collider's name to its mesh."""

    files: tuple[MeshFile, ...]
    of: dict[str, MeshFile]


def add_visual(
    body: etree._Element, visual: Visual, file: MeshFile, material: str, group: int, prefix: str = ""
) -> None:
    """`<geom>` below `<body>`; `material`: name of a `<material>`; `prefix`: prefix of the geom's name."""
    attributes = {
        "name": prefix + visual.name,
        "type": "mesh",
        "mesh": file.name,
        "material": material,
        "group": str(group),
        "contype": "0",
        "conaffinity": "0",
        "mass": "0",
    }
    etree.SubElement(body, "geom", attributes)


def gather_meshes(asset: Asset) -> Meshes:
    """Mesh files of every visual and of every collider that is a mesh."""
    paths: dict[str, str] = {}
    known: dict[tuple[str, MeshUse], MeshFile] = {}
    of: dict[str, MeshFile] = {}
    for name, mesh, use in mesh_uses(asset):
        data = obj_text(mesh, bare=use is MeshUse.HULL)
        content = hashlib.sha256(data).hexdigest()
        path = paths.setdefault(content, f"{MESHES}/{name}_{content[:12]}.obj")
        of[name] = known.setdefault((content, use), MeshFile(f"{name}_{content[:12]}", path, data, use))
    return Meshes(tuple(known.values()), of)


def mesh_uses(asset: Asset) -> list[tuple[str, Mesh, MeshUse]]:
    """(name of the visual or collider, its mesh, its use) of every visual and collider that is a mesh."""
    items: list[tuple[str, Mesh, MeshUse]] = []
    for link in asset.links:
        items += [(v.name, v.mesh, MeshUse.SURFACE) for v in link.visuals]
        for c in link.colliders:
            if isinstance(c.shape, Hull | MeshShape):
                use = MeshUse.HULL if isinstance(c.shape, Hull) else MeshUse.SURFACE
                items.append((c.name, c.shape.mesh, use))
    return items


def add_mesh(assets: etree._Element, file: MeshFile, folder: str = "") -> None:
    """`<mesh>` below `<asset>`; `folder`: path from the document to the mesh files, empty if they are next to it."""
    path = f"{folder}/{file.path}" if folder else file.path
    attributes = {"name": file.name, "file": path, "inertia": file.use.value}
    if file.use is MeshUse.HULL:
        attributes["maxhullvert"] = str(MAX_HULL_VERTICES)
    etree.SubElement(assets, "mesh", attributes)


def obj_text(mesh: Mesh, bare: bool = False) -> bytes:
    """OBJ text with values rounded to float32; one index is used for position, texture coordinate and normal.

    Args:
        mesh: triangles, metres.
        bare: leave out texture coordinates and normals.
    """
    uv, normals = (None, None) if bare else (mesh.uv, mesh.normals)
    text = rows("v", mesh.vertices)
    if uv is not None:
        text += rows("vt", uv)
    if normals is not None:
        text += rows("vn", normals)
    corner = "%d" + ("/%d" if uv is not None else "/" if normals is not None else "")
    corner += "/%d" if normals is not None else ""
    line = "f " + " ".join([corner] * 3) + "\n"
    index = np.repeat(mesh.faces.ravel() + 1, corner.count("%d"))
    text += (line * len(mesh.faces)) % tuple(index.tolist())
    return text.encode("ascii")


# Collider -------------------------------------------------------------------------------------------------------------

COLOR = "0.2 0.6 0.9 0.4"


def add_collider(
    body: etree._Element, collider: Collider, substance: Substance, meshes: Meshes, group: int, prefix: str = ""
) -> etree._Element:
    """`<geom>` below `<body>`; its name begins with `prefix`."""
    attributes = {"name": prefix + collider.name, **_shape(collider, meshes), **place(collider.pose)}
    attributes |= {
        "group": str(group),
        "contype": "1",
        "conaffinity": "1",
        "condim": str(contact_dimensions(collider.shape)),
        # Sliding, torsional (m), rolling (m). MuJoCo's one sliding coefficient is the dynamic one.
        "friction": numbers((substance.dynamic_friction, substance.torsional_friction, substance.rolling_friction)),
        # All mass is in <inertial>. A consumer that ignores that finds a body without mass and says so, where a density
        # would silently give it the weight of hulls that overlap.
        "mass": "0",
        "rgba": COLOR,
    }
    return etree.SubElement(body, "geom", attributes)


def _shape(collider: Collider, meshes: Meshes) -> dict[str, str]:
    shape = collider.shape
    if isinstance(shape, Box):
        return {"type": "box", "size": numbers(s / 2 for s in shape.size)}
    if isinstance(shape, Sphere):
        # Three times: robocasa's loader scales sizes by axis and refuses a single number; MuJoCo reads the first.
        return {"type": "sphere", "size": numbers([shape.radius] * 3)}
    if isinstance(shape, Cylinder | Capsule):
        return {"type": shape.kind, "size": numbers((shape.radius, shape.height / 2))}
    # MuJoCo collides any mesh as its convex hull. A hull is that already; a static mesh (MeshShape) becomes it.
    return {"type": "mesh", "mesh": meshes.of[collider.name].name}


# Site -----------------------------------------------------------------------------------------------------------------
# Sites, and regions: named volumes that robocasa reads from massless geoms with names `reg_...`.

REGION_COLOR = "0 1 0 0"
# Names under which robocasa looks for the bounding region. Ref: robocasa v1.0, fixtures and objects.
OUTER_REGIONS = ("bbox", "main")
# Site of an asset -> name under which robocasa v1.0 looks for its place beside `object`.
BESIDE_OBJECT = {"lid_site": "anchor_site"}
SIZE_SITE_RADIUS_M = 0.005
# Region whose corners robocasa v0.2 reads from sites -> prefix of the names of these sites.
CORNER_PREFIXES = {"main": "ext", "int": "int"}


def add_site(body: etree._Element, site: Site, prefix: str = "") -> None:
    """`<site>` below the body of its link; its name begins with `prefix`."""
    size = number(site.radius) if site.size is None else _half_size(site.kind, site.size)
    attributes = {"name": prefix + site.name, "type": site.kind, **place(site.pose), "size": size}
    etree.SubElement(body, "site", attributes | {"group": str(site_group(site)), "rgba": srgb(site.color)})


def _half_size(kind: str, size: Vec3) -> str:
    """MuJoCo's `size`: half sizes of a box; radius and half the height of a cylinder."""
    x, y, z = (s / 2 for s in size)
    return numbers((x, y, z) if kind == "box" else (x, z))


def add_corners(body: etree._Element, region: Region, prefix: str = "") -> None:
    """Add the four sites from which robocasa v0.2 reads a fixture's outer (`main`) and inner (`int`) size.

    `p0` is a corner; `px`, `py` and `pz` are its neighbours along each axis.
    """
    corner_prefix = CORNER_PREFIXES.get(region.name)
    if corner_prefix is None or region.kind != "box":
        return
    half = np.array(region.size) / 2
    for end, signs in (("p0", (-1, -1, -1)), ("px", (1, -1, -1)), ("py", (-1, 1, -1)), ("pz", (-1, -1, 1))):
        point = region.pose.apply((half * np.array(signs))[None])[0]
        name, size = f"{prefix}{corner_prefix}_{end}", number(SIZE_SITE_RADIUS_M)
        attributes = {"name": name, "pos": numbers(point), "size": size}
        etree.SubElement(body, "site", attributes | {"group": str(SITE_GROUP), "rgba": "0 0 0 0"})


def add_region(body: etree._Element, region: Region, group: int, prefix: str = "") -> None:
    """`<geom name="<prefix>reg_...">` below the body of its link: invisible, without contacts or mass."""
    attributes = {
        "name": f"{prefix}reg_{region.name}",
        "type": region.kind,
        **place(region.pose),
        "size": _half_size(region.kind, region.size),
        "group": str(group),
        "contype": "0",
        "conaffinity": "0",
        "mass": "0",
        "rgba": REGION_COLOR,
    }
    etree.SubElement(body, "geom", attributes)


def outer_region(asset: Asset) -> Region | None:
    """Bounding box of all colliders (of visuals if there are no colliders).

    None if the asset already has such a region.
    """
    if any(region.name in OUTER_REGIONS for region in asset.regions):
        return None
    lower, upper = collision_bounds(asset)
    return Region(name=OUTER_REGIONS[0], pose=Pose(position=_vec3((lower + upper) / 2)), size=_vec3(upper - lower))


def collision_bounds(asset: Asset) -> npt.NDArray[np.float64]:
    """(2, 3) corners of all colliders, asset frame, joints at zero, metres.

    If the asset has no colliders, the corners of its visuals.
    """
    boxes = [b for k in asset.links if (b := link_bounds(k, asset.asset_from_link(k.name))) is not None]
    return np.array([np.min(boxes, axis=0)[0], np.max(boxes, axis=0)[1]]) if boxes else asset.bounds


def add_size_sites(outer: etree._Element, asset: Asset) -> None:
    """Add the three sites from which robocasa v0.2 reads an object's size, and BESIDE_OBJECT; in the object's frame."""
    lower, upper = asset.bounds
    half_x, half_y = (upper[:2] - lower[:2]) / 2
    points = {
        "bottom_site": (0.0, 0.0, lower[2]),
        "top_site": (0.0, 0.0, upper[2]),
        "horizontal_radius_site": (half_x, half_y, 0.0),
    }
    on_root = [site for site in asset.sites if site.link == asset.root.name]
    points |= {BESIDE_OBJECT[site.name]: site.pose.position for site in on_root if site.name in BESIDE_OBJECT}
    own = {site.name for site in asset.sites}
    for name, point in points.items():
        if name not in own:
            attributes = {"name": name, "pos": numbers(point), "size": number(SIZE_SITE_RADIUS_M)}
            etree.SubElement(outer, "site", attributes | {"rgba": "0 0 0 0"})


def _vec3(values: npt.NDArray[np.float64]) -> Vec3:
    x, y, z = (float(v) for v in values)
    return x, y, z
