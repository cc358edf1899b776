"""Exchange with trimesh in memory: assets as trimesh scenes, and trimesh meshes and scenes as placed arrays.

The only module that imports trimesh. Files from strangers are read by our own readers, which look at lengths before
they allocate; trimesh is the type in which meshes are handed over between programs, and reads a few rare formats.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
import trimesh
from PIL import Image
from trimesh.poses import compute_stable_poses
from trimesh.visual import ColorVisuals, TextureVisuals
from trimesh.visual.material import MultiMaterial, PBRMaterial, SimpleMaterial

from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.asset.parts import joint_positions
from casa_assets.model.kitchen.scene import Scene
from casa_assets.model.pose import Pose

Bytes = npt.NDArray[np.uint8]
MeshOrScene = trimesh.Trimesh | trimesh.Scene

# Key of a scene's or mesh's metadata under which the axis that points up is stated: `x`, `y` or `z`.
UP_KEY = "up_axis"


What = Literal["visual", "collision"]


def to_trimesh(asset: Asset, what: What = "visual") -> trimesh.Scene:
    """Convert an asset to a trimesh scene, every joint at zero: its visual meshes or its collision shapes.

    Returns:
        Metres, z up. A node per link, placed as in the asset; below it a geometry per visual or collider, named like
        it. Visuals have normals, texture coordinates and a PBR material; trimesh keeps base colours in steps of 1/255.
        Round colliders are polyhedra of 32 sides; `metadata` states the kind of shape, the link and the substance.
    """
    scene = trimesh.Scene(metadata={"name": asset.id, UP_KEY: "z"})
    for link in asset.links:
        parent = link.parent or scene.graph.base_frame
        scene.graph.update(link.name, frame_from=parent, matrix=link.pose.matrix)  # type: ignore[no-untyped-call]
    for owner, name, geometry, pose in _geometries(asset, what):
        transform = None if pose is None else pose.matrix
        scene.add_geometry(geometry, node_name=name, geom_name=name, parent_node_name=owner, transform=transform)
    return scene


def kitchen_to_trimesh(kitchen: Scene, what: What = "visual") -> trimesh.Scene:
    """Convert a kitchen to a trimesh scene, every joint where it starts; see `to_trimesh`.

    Nodes are named `<placement>__<link>` and `<placement>__<visual or collider>`. Copies of an asset share geometries.
    """
    scene = trimesh.Scene(metadata={"name": kitchen.id, UP_KEY: "z"})

    def put(node: str, parent: Any, pose: Pose, **geometry: str) -> None:
        scene.graph.update(node, frame_from=parent, matrix=pose.matrix, **geometry)  # type: ignore[no-untyped-call]

    assets = {asset.id: (asset, list(_geometries(asset, what))) for asset in kitchen.assets}
    for placement in kitchen.placements:
        asset, geometries = assets[placement.asset]
        begin = joint_positions(placement.joints)
        for link in asset.links:
            pose, node = asset.parent_from_link(link.name, begin), f"{placement.name}__{link.name}"
            if link.parent is None:
                put(node, scene.graph.base_frame, placement.pose @ pose)
            else:
                put(node, f"{placement.name}__{link.parent}", pose)
        for owner, name, geometry, own_pose in geometries:
            scene.geometry.setdefault(f"{asset.id}__{name}", geometry)
            put(
                f"{placement.name}__{name}",
                f"{placement.name}__{owner}",
                own_pose or Pose(),
                geometry=f"{asset.id}__{name}",
            )
    return scene


def _geometries(asset: Asset, what: What) -> Iterator[tuple[str, str, trimesh.Trimesh, Pose | None]]:
    """Link, name, mesh, and pose in the link of each visual or collider; the pose is None for visuals."""
    looks = {m.id: _pbr(m) for m in asset.materials} if what == "visual" else {}
    for link in asset.links:
        for visual in link.visuals if what == "visual" else ():
            mesh = visual.mesh
            geometry = trimesh.Trimesh(
                vertices=mesh.vertices,
                faces=mesh.faces.astype(np.int64),
                vertex_normals=mesh.normals,
                visual=TextureVisuals(uv=mesh.uv, material=looks[visual.material]),  # type: ignore[no-untyped-call]
                metadata={"link": link.name, "label": visual.label or ""},
                process=False,
            )
            geometry.units = "meters"
            yield link.name, visual.name, geometry, None
        for collider in link.colliders if what == "collision" else ():
            points, faces = tessellate(collider.shape, Pose())
            stated = {"link": link.name, "shape": collider.shape.kind, "substance": collider.substance}
            geometry = trimesh.Trimesh(vertices=points, faces=faces, metadata=stated, process=False)
            geometry.units = "meters"
            yield link.name, collider.name, geometry, collider.pose


def resting_sides(asset: Asset, center: Floats) -> tuple[Floats, Floats, Floats]:
    """How an asset can rest on a plane: the sides of the hull of its collision shapes that its weight holds it on.

    Args:
        center: (3,) of its mass, frame of the asset, metres.
    Returns:
        (V, 3) corners of that hull; (N, 3, 3) rotations that turn each side down, the most likely first; (N,) how
        likely each is when it is put down turned at random.
    Ref: Goldberg et al. 1999, Part pose statistics.
    """
    hull = to_trimesh(asset, "collision").to_mesh().convex_hull
    matrices, shares = compute_stable_poses(hull, center_mass=center)
    rotations = np.array(matrices, dtype=np.float64).reshape(-1, 4, 4)[:, :3, :3]
    return np.array(hull.vertices), rotations, np.array(shares, dtype=np.float64)


def _pbr(material: Material) -> PBRMaterial:
    base = material.base_color_texture
    is_clear = material.base_color[3] < 1.0 or (base is not None and _image(base).mode == "RGBA")
    glows = material.glow > 0.0
    return PBRMaterial(  # type: ignore[no-untyped-call]
        name=material.id,
        baseColorFactor=np.array(material.base_color, dtype=np.float64),
        metallicFactor=material.metallic,
        roughnessFactor=material.roughness,
        baseColorTexture=None if base is None else _image(base),
        metallicRoughnessTexture=_maybe_image(material.metallic_roughness_texture),
        normalTexture=_maybe_image(material.normal_texture),
        emissiveFactor=[material.glow * c for c in material.base_color[:3]] if glows else None,
        emissiveTexture=_image(base) if glows and base is not None else None,
        alphaMode="BLEND" if is_clear else "OPAQUE",
    )


def _maybe_image(texture: Texture | None) -> Image.Image | None:
    return None if texture is None else _image(texture)


def _image(texture: Texture) -> Image.Image:
    image = Image.open(io.BytesIO(texture.png))
    image.load()
    return image


@dataclass(frozen=True)
class TrimeshMaterial:
    """Appearance of a trimesh material, simple or PBR.

    Attributes:
        name: as trimesh has it, may be empty.
        color: RGBA in 0..1; `is_linear` says whether it is linear light (PBR) or a display value (simple materials).
        metallic, roughness: 0..1, None if the material does not state them. shininess: Phong exponent, or None.
        emissive: linear RGB.
        alpha_mode: OPAQUE, MASK or BLEND. alpha_cutoff: for MASK, 0..1.
        images: `base`, `rough` (green roughness, blue metallic), `normal`, `emissive`.
    """

    name: str = ""
    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    is_linear: bool = True
    metallic: float | None = None
    roughness: float | None = None
    shininess: float | None = None
    emissive: tuple[float, float, float] = (0.0, 0.0, 0.0)
    alpha_mode: str = "OPAQUE"
    alpha_cutoff: float = 0.5
    images: Mapping[str, Image.Image] = field(default_factory=dict)


@dataclass(frozen=True)
class PlacedMesh:
    """One mesh with one material, in the frame of its scene.

    Attributes:
        name: of its node. vertices: (V, 3) units of the scene. faces: (F, 3), winding flipped if its node mirrors.
        normals: (V, 3) or None. uv: (V, 2), origin at the lower left, or None.
        colors: (V, 4) uint8 or None; display values, or linear light if `is_linear` (they came from glTF).
        finish: None if its appearance is given only by colours, or not at all.
    """

    name: str
    vertices: Floats
    faces: Ints
    normals: Floats | None
    uv: Floats | None
    colors: Bytes | None
    finish: TrimeshMaterial | None
    is_linear: bool = False


def placed_meshes(thing: MeshOrScene) -> Iterator[PlacedMesh]:
    """Every triangle mesh of a scene at its place, in the order of the nodes; paths and point clouds are passed over.

    Raises:
        ValueError: a face names a vertex that does not exist, or meshes of one scene have different units.
    """
    if isinstance(thing, trimesh.Trimesh):
        yield from _split(str(thing.metadata.get("name", "mesh")), thing, np.eye(4))
        return
    for node in thing.graph.nodes_geometry:
        matrix, name = thing.graph[node]
        geometry = thing.geometry[name]
        if isinstance(geometry, trimesh.Trimesh):
            yield from _split(str(node), geometry, np.asarray(matrix, dtype=np.float64))


def count_other_geometries(thing: MeshOrScene) -> int:
    """Number of geometries of a scene that are no triangle meshes."""
    found = [] if isinstance(thing, trimesh.Trimesh) else list(thing.geometry.values())
    return sum(not isinstance(g, trimesh.Trimesh) for g in found)


def metres_per_unit(thing: MeshOrScene) -> float | None:
    """Length of a unit, or None if not stated. Raises ValueError: the unit is unknown, or the meshes do not agree."""
    meshes = [thing] if isinstance(thing, trimesh.Trimesh) else list(thing.geometry.values())
    # trimesh writes down `None` as a word once somebody has set it.
    words = [str(m.units or "none") for m in meshes if isinstance(m, trimesh.Trimesh)]
    stated = {None if word == "none" else word for word in words}
    if len(stated) > 1:
        found = ", ".join(sorted(set(words)))
        raise ValueError(f"meshes of one scene have different units ({found}); call convert_units first")
    unit = next(iter(stated), None)
    return None if unit is None else float(trimesh.units.unit_conversion(unit, "meters"))


def up_axis(thing: MeshOrScene) -> str | None:
    """`x`, `y` or `z` where the metadata states it, `y` for what came out of a glTF file, else None."""
    stated = str(thing.metadata.get(UP_KEY, "")).lower()
    if stated in ("x", "y", "z"):
        return stated
    meshes = [thing] if isinstance(thing, trimesh.Trimesh) else list(thing.geometry.values())
    return "y" if any("from_gltf_primitive" in m.metadata for m in meshes) else None


def _split(name: str, mesh: trimesh.Trimesh, matrix: Floats) -> Iterator[PlacedMesh]:
    """A mesh at its place, one PlacedMesh for each of its materials."""
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    faces = np.asarray(mesh.faces, dtype=np.int64)
    if len(faces) and not 0 <= int(faces.min()) <= int(faces.max()) < len(vertices):
        raise ValueError(f"{name}: a face names vertex {int(faces.max())} of {len(vertices)}")
    normals = _stated_normals(mesh)
    uv, colors, finish = None, None, None
    visual = mesh.visual
    if isinstance(visual, TextureVisuals):
        uv = None if visual.uv is None or len(visual.uv) != len(vertices) else np.asarray(visual.uv, dtype=np.float64)
        drawn = mesh.vertex_attributes.get("color", visual.vertex_attributes.get("color"))
        colors = None if drawn is None or len(np.asarray(drawn)) != len(vertices) else _rgba(drawn)
        if isinstance(visual.material, MultiMaterial):
            of_face = np.zeros(len(faces)) if visual.face_materials is None else np.asarray(visual.face_materials)
            for index in np.unique(of_face.astype(np.int64)):
                finish = _finish(visual.material.materials[int(index)])
                yield _placed(PlacedMesh(name, vertices, faces[of_face == index], normals, uv, None, finish), matrix)
            return
        finish = _finish(visual.material)
    elif isinstance(visual, ColorVisuals) and visual.kind == "vertex":
        colors = _rgba(visual.vertex_colors)
    elif isinstance(visual, ColorVisuals) and visual.kind == "face":
        colors = np.repeat(_rgba(visual.face_colors), 3, axis=0)
        rows = faces.reshape(-1)  # faces share no vertices, so that colours do not run into each other
        vertices, normals = vertices[rows], None if normals is None else normals[rows]
        faces = np.arange(len(rows)).reshape(-1, 3)
    is_linear = "from_gltf_primitive" in mesh.metadata
    yield _placed(PlacedMesh(name, vertices, faces, normals, uv, colors, finish, is_linear), matrix)


def _stated_normals(mesh: trimesh.Trimesh) -> Floats | None:
    """(V, 3) normals that the mesh was given; None for those that trimesh computes by itself when they are asked for.

    trimesh keeps both in one cache. Whether somebody has asked must not change what is read, so those that are what it
    would compute count as not given.
    """
    if "vertex_normals" not in mesh._cache:
        return None
    given = np.asarray(mesh.vertex_normals, dtype=np.float64)
    own = trimesh.Trimesh(vertices=mesh.vertices, faces=mesh.faces, process=False).vertex_normals
    return None if np.allclose(given, own, atol=1e-9) else given


def _placed(one: PlacedMesh, matrix: Floats) -> PlacedMesh:
    """The mesh moved to its place."""
    linear = matrix[:3, :3]
    normals = one.normals
    if normals is not None and np.linalg.det(linear) != 0:
        normals = normals @ np.linalg.inv(linear)
    faces = one.faces[:, ::-1] if np.linalg.det(linear) < 0 else one.faces
    vertices = one.vertices @ linear.T + matrix[:3, 3]
    return replace(one, vertices=vertices, faces=faces, normals=normals)


def _rgba(values: Any) -> Bytes:
    """(N, 4) uint8 of colours in 0..255 or, as floats, in 0..1."""
    table = np.asarray(values)
    scaled = table if table.dtype == np.uint8 else np.rint(np.clip(np.nan_to_num(table), 0.0, 1.0) * 255.0)
    out = np.full((len(table), 4), 255, dtype=np.uint8)
    out[:, : table.shape[1]] = scaled[:, :4]
    return out


def _finish(material: Any) -> TrimeshMaterial | None:
    if isinstance(material, PBRMaterial):
        images = {
            "base": material.baseColorTexture,
            "rough": material.metallicRoughnessTexture,
            "normal": material.normalTexture,
            "emissive": material.emissiveTexture,
        }
        glow = np.zeros(3) if material.emissiveFactor is None else np.asarray(material.emissiveFactor)
        cutoff = 0.5 if material.alphaCutoff is None else float(material.alphaCutoff)
        return TrimeshMaterial(
            name=str(material.name or ""),
            color=_color(material.baseColorFactor),
            metallic=material.metallicFactor,
            roughness=material.roughnessFactor,
            emissive=(float(glow[0]), float(glow[1]), float(glow[2])),
            alpha_mode=material.alphaMode or "OPAQUE",
            alpha_cutoff=cutoff,
            images={key: image for key, image in images.items() if image is not None},
        )
    if isinstance(material, SimpleMaterial):
        return TrimeshMaterial(
            name=str(material.name or ""),
            color=_color(material.diffuse),
            is_linear=False,
            shininess=None if material.glossiness is None else float(material.glossiness),
            alpha_mode="BLEND",
            images={} if material.image is None else {"base": material.image},
        )
    return None


def _color(values: Any) -> tuple[float, float, float, float]:
    if values is None:
        return (1.0, 1.0, 1.0, 1.0)
    r, g, b, a = (float(v) for v in _rgba(np.atleast_2d(values))[0] / 255.0)
    return (r, g, b, a)


class _NoFiles(trimesh.resolvers.Resolver):
    """A resolver with no files: what a mesh refers to is never looked for, on the disk or the network."""

    def __init__(self) -> None:
        """Nothing is kept."""

    def get(self, key: str) -> bytes:
        """Raises FileNotFoundError."""
        raise FileNotFoundError(f"{key} is not read")

    def write(self, name: str, data: object) -> None:
        """Raises PermissionError."""
        raise PermissionError(f"{name} is not written")

    def namespaced(self, namespace: str) -> _NoFiles:
        """Itself."""
        return self

    def keys(self) -> list[str]:
        """None."""
        return []


def read_scene(data: bytes, file_type: str) -> trimesh.Scene:
    """Scene of the bytes of a file; vertices and faces exactly as in the file, nothing merged, no other file opened.

    Args:
        file_type: trimesh's name of the format, such as `off`.
    Raises:
        Exception: whatever trimesh raises on a broken file.
    """
    return trimesh.load_scene(
        io.BytesIO(data), file_type=file_type, resolver=_NoFiles(), allow_remote=False, process=False
    )
