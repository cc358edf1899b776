"""Asset or Scene -> one binary glTF file (GLB) for viewing: visuals, and on request colliders and regions.

A GLB has no physics. What a viewer needs to move the parts is in the `extras` of its nodes: see the table in this file.
"""

from __future__ import annotations

import hashlib
import io
import json
import math
import struct
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from casa_assets.core.numeric import Floats, Ints
from casa_assets.formats.values import rounded
from casa_assets.mesh import surface
from casa_assets.mesh.solid.primitive import tessellate
from casa_assets.model.asset.asset import Asset, Joint, Link, Region, Visual
from casa_assets.model.asset.material import ColorSpace, Material, Texture
from casa_assets.model.asset.parts import Box, Cylinder, Mesh, Shape, Sphere, joint_positions
from casa_assets.model.kitchen.scene import CLOSED_POSE, OUTER_FACE, Layer, Placement, Scene, key_positions
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

# Binary ---------------------------------------------------------------------------------------------------------------
# Arrays and pictures -> binary chunk of a GLB, its buffer views and accessors; equal content is written once.
#
# Ref: glTF 2.0 specification, 3.6 (binary data storage) and 4.4 (GLB file format).

FLOAT, UNSIGNED_SHORT, UNSIGNED_INT = 5126, 5123, 5125
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
MAGIC, VERSION = 0x46546C67, 2
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942
ALIGNMENT = 4
TYPE_OF_WIDTH = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}


class Rows(list[dict[str, Any]]):
    """Rows as glTF lists them, each once."""

    def __init__(self) -> None:
        super().__init__()
        self._index: dict[object, int] = {}

    def put(self, key: object, make: Callable[[], dict[str, Any]]) -> int:
        """Index of the row of a key, which is made if there is no such row."""
        if key not in self._index:
            row = make()
            self._index[key] = len(self)
            self.append(row)
        return self._index[key]


@dataclass
class Binary:
    """The binary chunk while it is being built.

    Attributes:
        data: its bytes, every part aligned.
        views, accessors: as glTF lists them.
    """

    data: bytearray = field(default_factory=bytearray)
    views: Rows = field(default_factory=Rows)
    accessors: Rows = field(default_factory=Rows)

    def view(self, content: bytes, target: int | None = None) -> int:
        """Index of the buffer view of some bytes; `target`: kind of the vertex data, None for a picture."""

        def row() -> dict[str, Any]:
            self.data += bytes(-len(self.data) % ALIGNMENT)
            start = len(self.data)
            self.data += content
            kind = {} if target is None else {"target": target}
            return {"buffer": 0, "byteOffset": start, "byteLength": len(content), **kind}

        return self.views.put(hashlib.sha256(f"{target} ".encode() + content).digest(), row)

    def vectors(self, rows: npt.NDArray[np.float64], with_bounds: bool = False) -> int:
        """Index of the accessor of (N, 2) or (N, 3) numbers, rounded to float32; `with_bounds`: for positions."""
        values = np.ascontiguousarray(rows, dtype=np.float32) + np.float32(0.0)  # no negative zero
        row = {"componentType": FLOAT, "count": len(values), "type": TYPE_OF_WIDTH[values.shape[1]]}
        if with_bounds:
            row |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        return self._accessor(self.view(values.astype("<f4").tobytes(), ARRAY_BUFFER), row, with_bounds)

    def indices(self, faces: npt.NDArray[np.int64]) -> int:
        """Index of the accessor of the corners of (F, 3) triangles."""
        is_small = int(faces.max()) < 65535  # the largest number of either width is kept for other purposes
        content = faces.astype("<u2" if is_small else "<u4").tobytes()
        kind = UNSIGNED_SHORT if is_small else UNSIGNED_INT
        row = {"componentType": kind, "count": int(faces.size), "type": TYPE_OF_WIDTH[1]}
        return self._accessor(self.view(content, ELEMENT_ARRAY_BUFFER), row, False)

    def _accessor(self, view: int, row: dict[str, Any], with_bounds: bool) -> int:
        key = (view, row["type"], row["componentType"], row["count"], with_bounds)
        return self.accessors.put(key, lambda: {"bufferView": view, **row})


def glb(document: dict[str, Any], binary: Binary) -> bytes:
    """Return the file of a document without buffers, views and accessors, which are taken from `binary`."""
    body = bytes(binary.data) + bytes(-len(binary.data) % ALIGNMENT)
    parts = {"buffers": [{"byteLength": len(body)}], "bufferViews": binary.views, "accessors": binary.accessors}
    parts = {} if not body else parts
    text = json.dumps({**document, **parts}, sort_keys=True, allow_nan=False, separators=(",", ":")).encode("ascii")
    text += b" " * (-len(text) % ALIGNMENT)
    chunks = struct.pack("<II", len(text), JSON_CHUNK) + text
    if body:
        chunks += struct.pack("<II", len(body), BINARY_CHUNK) + body
    return struct.pack("<III", MAGIC, VERSION, 12 + len(chunks)) + chunks


def placed(pose: Pose) -> dict[str, Any]:
    """`translation` (metres) and `rotation` (x, y, z, w) of a node; empty for the identity."""
    w, x, y, z = pose.quaternion
    found: dict[str, Any] = {}
    if any(pose.position):
        found["translation"] = rounded(pose.position)
    if (x, y, z) != (0.0, 0.0, 0.0):
        found["rotation"] = rounded((x, y, z, w))
    return found


# Material -------------------------------------------------------------------------------------------------------------
# Material -> metallic-roughness material of glTF, the same model as in the record, with reduced pictures.

COLOR_QUALITY, DATA_QUALITY = 85, 90
# Ref: OpenGL: GL_LINEAR, GL_LINEAR_MIPMAP_LINEAR, GL_REPEAT.
SAMPLER = {"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 10497}
# Shares of a picture whose alpha is neither nothing nor all, above which it is see-through and not cut out.
MAX_SOFT_SHARE = 0.05
PICTURE_PX = 512
# Pictures of this process by name and colour space: those of all styles, of 60 kB each.
_KEPT: dict[str, tuple[bytes, str, str]] = {}
_MOST_KEPT = 512


@dataclass
class Materials:
    """Materials, textures and images as glTF lists them; equal ones are written once; `binary` has the pictures."""

    binary: Binary
    rows: Rows = field(default_factory=Rows)
    images: Rows = field(default_factory=Rows)
    _mode_of: dict[str, str] = field(default_factory=dict)

    def index(self, material: Material) -> int:
        """Index of a material."""
        return self.rows.put(material.digest, lambda: self._row(material))

    def plain(self, name: str, color: Sequence[float]) -> int:
        """Index of a rough material of one linear RGBA colour, seen from both sides."""
        pbr = {"baseColorFactor": rounded(color), "metallicFactor": 0.0, "roughnessFactor": 0.9}
        mode = {} if color[3] >= 1.0 else {"alphaMode": "BLEND"}
        return self.rows.put(name, lambda: {"name": name, "pbrMetallicRoughness": pbr, "doubleSided": True, **mode})

    def document(self) -> dict[str, Any]:
        """Members of the glTF document."""
        found: dict[str, Any] = {"materials": self.rows} if self.rows else {}
        if self.images:
            textures = [{"sampler": 0, "source": i} for i in range(len(self.images))]
            found |= {"images": self.images, "textures": textures, "samplers": [SAMPLER]}
        return found

    def _row(self, material: Material) -> dict[str, Any]:
        pbr: dict[str, Any] = {
            "baseColorFactor": rounded(material.base_color),
            "metallicFactor": material.metallic,
            "roughnessFactor": material.roughness,
        }
        row: dict[str, Any] = {"name": material.id, "pbrMetallicRoughness": pbr}
        mode = "OPAQUE"
        if material.base_color_texture is not None:
            texture, mode = self._texture(material.base_color_texture)
            pbr["baseColorTexture"] = texture
        if material.base_color[3] < 1.0:
            mode = "BLEND"
        if material.metallic_roughness_texture is not None:
            pbr["metallicRoughnessTexture"], _ = self._texture(material.metallic_roughness_texture)
        if material.normal_texture is not None:
            row["normalTexture"], _ = self._texture(material.normal_texture)
        if material.glow:
            row["emissiveFactor"] = rounded([material.glow * c for c in material.base_color[:3]])
            if material.base_color_texture is not None:
                row["emissiveTexture"] = pbr["baseColorTexture"]
        return row if mode == "OPAQUE" else {**row, "alphaMode": mode}

    def _texture(self, texture: Texture) -> tuple[dict[str, int], str]:
        """Reference to a picture, and the alpha mode that it requires."""
        key = f"{texture.file_name} {texture.color_space.value}"

        def row() -> dict[str, Any]:
            # Kitchens of a style have the same pictures.
            if key not in _KEPT:
                if len(_KEPT) >= _MOST_KEPT:
                    _KEPT.clear()
                _KEPT[key] = encoded(texture)
            content, kind, self._mode_of[key] = _KEPT[key]
            return {"bufferView": self.binary.view(content), "mimeType": kind, "name": texture.name}

        return {"index": self.images.put(key, row)}, self._mode_of[key]


def encoded(texture: Texture) -> tuple[bytes, str, str]:
    """Encode a picture, scaled down to at most PICTURE_PX along a side.

    Returns:
        Its bytes; `image/png` if it has alpha, else `image/jpeg`; and the glTF alpha mode that it requires.
    """
    out = io.BytesIO()
    with Image.open(io.BytesIO(texture.png)) as opened:
        image = opened.convert("RGBA" if "A" in opened.getbands() or "transparency" in opened.info else "RGB")
    if image.mode == "RGBA" and image.getchannel("A").getextrema() == (255, 255):
        image = image.convert("RGB")
    if max(image.size) > PICTURE_PX:
        image.thumbnail((PICTURE_PX, PICTURE_PX), Image.Resampling.LANCZOS)
    if image.mode == "RGBA":
        image.save(out, "PNG", optimize=True)
        alpha = np.asarray(image.getchannel("A"))
        is_soft = float(((alpha > 8) & (alpha < 247)).mean()) > MAX_SOFT_SHARE
        return out.getvalue(), "image/png", "BLEND" if is_soft else "MASK"
    # Halved colour would smear the channels of data into each other.
    is_color = texture.color_space is ColorSpace.SRGB
    quality, sampling = (COLOR_QUALITY, "4:2:0") if is_color else (DATA_QUALITY, "4:4:4")
    image.save(out, "JPEG", quality=quality, subsampling=sampling, optimize=True)
    return out.getvalue(), "image/jpeg", "OPAQUE"


# Visual ---------------------------------------------------------------------------------------------------------------
# Visuals of a link -> meshes: one primitive for each material, so that a link is drawn in few calls.


@dataclass
class Meshes:
    """Meshes as glTF lists them; equal ones are written once, however many nodes show them."""

    binary: Binary
    materials: Materials
    rows: Rows = field(default_factory=Rows)

    def of_visuals(self, visuals: Sequence[Visual], looks: dict[str, Material]) -> int | None:
        """Index of the mesh of some visuals of one link, or None if they have no faces."""
        primitives = []
        for material in dict.fromkeys(visual.material for visual in visuals):
            joined = _joined([visual.mesh for visual in visuals if visual.material == material])
            if joined is not None:
                primitives.append(self._primitive(*joined, self.materials.index(looks[material])))
        return self._mesh(primitives) if primitives else None

    def bare(self, points: Floats, faces: Ints, material: int) -> int:
        """Index of a mesh of one material without normals, which viewers draw faceted."""
        return self._mesh([self._primitive(points, None, None, faces, material)])

    def _mesh(self, primitives: list[dict[str, Any]]) -> int:
        return self.rows.put(repr(primitives), lambda: {"primitives": primitives})

    def _primitive(
        self, points: Floats, normals: Floats | None, uv: Floats | None, faces: Ints, material: int
    ) -> dict[str, Any]:
        attributes = {"POSITION": self.binary.vectors(points, with_bounds=True)}
        if normals is not None:
            attributes["NORMAL"] = self.binary.vectors(normals)
        if uv is not None:
            attributes["TEXCOORD_0"] = self.binary.vectors(uv)
        return {"attributes": attributes, "indices": self.binary.indices(faces), "material": material}


def _joined(meshes: Sequence[Mesh]) -> tuple[Floats, Floats, Floats | None, Ints] | None:
    """Join meshes into points, unit normals, texture coordinates and faces, or None if there are no faces.

    Texture coordinates have v down, as in glTF, and are None if no mesh has any.
    """
    filled = [_with_normals(mesh) for mesh in meshes if len(mesh.faces)]
    if not filled:
        return None
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh, _ in filled)])
    faces = np.concatenate([m.faces.astype(np.int64) + start for (m, _), start in zip(filled, starts, strict=False)])
    uv = None
    if any(mesh.uv is not None for mesh, _ in filled):
        rows = [np.zeros((len(m.vertices), 2)) if m.uv is None else m.uv for m, _ in filled]
        uv = np.concatenate(rows) * (1.0, -1.0) + (0.0, 1.0)
    points = np.concatenate([mesh.vertices for mesh, _ in filled])
    return points, np.concatenate([normals for _, normals in filled]), uv, faces


def _with_normals(mesh: Mesh) -> tuple[Mesh, Floats]:
    """Return the mesh and (V, 3) unit normals; a mesh without normals gets separate vertices for each face."""
    if mesh.normals is None:
        normals, areas = surface.face_normals(mesh.vertices, mesh.faces.astype(np.int64))
        normals[areas == 0] = (0.0, 0.0, 1.0)
        rows = mesh.faces.reshape(-1)
        faces = np.arange(len(rows), dtype=np.int32).reshape(-1, 3)
        mesh = Mesh(vertices=mesh.vertices[rows], faces=faces, uv=None if mesh.uv is None else mesh.uv[rows])
        return mesh, np.repeat(normals, 3, axis=0)
    lengths = np.linalg.norm(mesh.normals, axis=1, keepdims=True)
    upright = np.where(lengths > 0.0, mesh.normals, (0.0, 0.0, 1.0))
    return mesh, upright / np.where(lengths > 0.0, lengths, 1.0)


# Layer ----------------------------------------------------------------------------------------------------------------

STEPS = 24  # corners of a circle


class LayerName(StrEnum):
    """Value of `extras.layer` of a node that shows something."""

    VISUAL = "visual"
    OUTSIDE = "outside"  # faces of walls that look out of the room; a viewer leaves them out, to look in
    CEILING = "ceiling"  # likewise
    COLLIDER = "collider"
    REGION = "region"


# Linear RGBA; colliders take these in turn, so that neighbours differ.
COLLIDER_COLORS = (
    (0.90, 0.20, 0.12, 0.55),
    (0.08, 0.42, 0.75, 0.55),
    (0.95, 0.62, 0.05, 0.55),
    (0.12, 0.55, 0.22, 0.55),
    (0.48, 0.20, 0.70, 0.55),
    (0.02, 0.55, 0.58, 0.55),
)
REGION_COLOR = (0.05, 0.65, 0.30, 0.22)


def layer_nodes(link: Link, regions: tuple[Region, ...], meshes: Meshes) -> Iterator[dict[str, Any]]:
    """A node for each collider and region of a link, which viewers hide at first; `regions`: of the asset."""
    for number, collider in enumerate(link.colliders):
        turn = number % len(COLLIDER_COLORS)
        material = meshes.materials.plain(f"collider_{turn}", COLLIDER_COLORS[turn])
        facts = {"name": collider.name, "kind": collider.shape.kind, "substance": collider.substance}
        extras = {"layer": LayerName.COLLIDER.value, "collider": facts}
        yield {"name": collider.name, "extras": extras, **_shown(collider.shape, collider.pose, meshes, material)}
    for region in (region for region in regions if region.link == link.name):
        material = meshes.materials.plain("region", REGION_COLOR)
        width, depth, height = region.size
        # A cylinder whose box is not square is an ellipse; the scale of its node makes it one.
        shape: Shape = Box(size=region.size) if region.kind == "box" else Cylinder(radius=0.5, height=1.0)
        shown = _shown(shape, region.pose, meshes, material)
        if region.kind == "cylinder":
            shown["scale"] = rounded((width / 2, depth / 2, height))
        extras = {"layer": LayerName.REGION.value, "region": {"name": region.name, "kind": region.kind}}
        yield {"name": region.name, "extras": extras, **shown}


def _shown(shape: Shape, pose: Pose, meshes: Meshes, material: int) -> dict[str, Any]:
    """Mesh, pose and scale of a shape: primitives share one mesh of unit size, scaled by their nodes."""
    scale: Vec3 = (1.0, 1.0, 1.0)
    if isinstance(shape, Box):
        shape, scale = Box(size=(1.0, 1.0, 1.0)), shape.size
    elif isinstance(shape, Sphere):
        shape, scale = Sphere(radius=1.0), (shape.radius, shape.radius, shape.radius)
    elif isinstance(shape, Cylinder):
        shape, scale = Cylinder(radius=1.0, height=1.0), (shape.radius, shape.radius, shape.height)
    points, faces = tessellate(shape, Pose(), STEPS)
    used = np.unique(faces)
    mesh = meshes.bare(points[used], np.searchsorted(used, faces), material)
    sized = {} if scale == (1.0, 1.0, 1.0) else {"scale": rounded(scale)}
    return {"mesh": mesh, **placed(pose), **sized}


# Body -----------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Copy:
    """One copy of an asset in a document.

    Attributes:
        prefix: prefix of the names of its nodes and joints: empty, or the placement's name and a slash.
        layer: layer of its visuals.
        positions: joint name -> position in the file, rad or m; joints that are not named are at zero.
    """

    asset: Asset
    prefix: str = ""
    layer: LayerName = LayerName.VISUAL
    positions: Mapping[str, float] = field(default_factory=dict)


def add_nodes(document: Document, copy: Copy, below: int) -> dict[str, int]:
    """Add a node for each link below the node `below`; return link name -> index of its node."""
    asset = copy.asset
    looks = {material.id: material for material in asset.materials}
    found: dict[str, int] = {}
    for link in asset.links:
        moved_by = asset.joint_of(link.name)
        extras: dict[str, Any] = {"link": link.name}
        if moved_by is not None:
            extras["joint"] = joint_facts(asset, moved_by, copy)
        pose = asset.parent_from_link(link.name, copy.positions)
        row = {"name": copy.prefix + link.name, "extras": extras, **placed(pose)}
        found[link.name] = document.add(row, below if link.parent is None else found[link.parent])
        _add_visuals(document, link, looks, copy, found[link.name])
        for part in layer_nodes(link, asset.regions, document.meshes) if document.with_layers else ():
            document.add({**part, "name": f"{copy.prefix}{link.name}/{part['name']}"}, found[link.name])
    return found


def joint_facts(asset: Asset, joint: Joint, copy: Copy) -> dict[str, Any]:
    """`extras.joint` of the link that a joint moves; `rest` is the position of the joint in the file."""
    states = {s.value: rounded(s.interval) for s in asset.states if s.joint == joint.name}
    return {
        "name": copy.prefix + joint.name,
        "type": joint.kind.value,
        "axis": rounded(joint.axis),
        "anchor": rounded(joint.anchor),
        "range": rounded(joint.range),
        "rest": rounded([copy.positions.get(joint.name, 0.0)])[0],
        **({"states": states} if states else {}),
        **({} if joint.behind is None else {"behind": copy.prefix + joint.behind}),
    }


def _add_visuals(document: Document, link: Link, looks: dict[str, Any], copy: Copy, below: int) -> None:
    """Add one node for the visuals of a link, and another for faces that look out of the room."""
    groups: dict[LayerName, list[Visual]] = {}
    for visual in link.visuals:
        group = LayerName.OUTSIDE if visual.label == OUTER_FACE else copy.layer
        groups.setdefault(group, []).append(visual)
    for group, visuals in groups.items():
        mesh = document.meshes.of_visuals(visuals, looks)
        if mesh is not None:
            labels = sorted({v.label for v in visuals if v.label is not None})
            extras = {"layer": group.value, **({"labels": labels} if labels else {})}
            name = f"{copy.prefix}{link.name}/{group.value}"
            document.add({"name": name, "mesh": mesh, "extras": extras}, below)


# Document -------------------------------------------------------------------------------------------------------------
# Asset -> GLB.
#
# Metres. One root node turns our z up into glTF's y up; below it all frames are those of the record. `extras`:
#
# | node | `extras` |
# |---|---|
# | root | `casa_assets` (version of this table), `id`, `kind` (`asset`, `scene`), `poses`: name -> joint -> position |
# | copy of an asset in a scene | `placement`: `name`, `asset`, `category`, `layer` |
# | link | `link`, and if a joint moves it `joint`: `name`, `type` (`hinge` or `slide`), `axis` and `anchor` in the |
# | | frame of the link, `range`, `rest` (position in the file), `states` (value -> share of the range), `behind` |
# | drawn node | `layer` (see LayerName); for a collider or a region also its name and kind |
#
# A link moves by `motion(position - rest)` after the pose of its node: about the axis through the anchor (rad), or
# along the axis (m). Names are paths: `door`, or in a scene `fridge/door`; the name of its joint is
# `fridge/door_joint`.

EXTRAS_VERSION = 1
# Turns z up into y up.
Y_UP = Pose(quaternion=(0.5**0.5, -(0.5**0.5), 0.0, 0.0))


class Document:
    """A GLB while it is being built: one root node, and the nodes below it."""

    def __init__(self, name: str, kind: str, with_layers: bool) -> None:
        """Start with the root node; `kind`: `asset` or `scene`."""
        self.binary, self.with_layers = Binary(), with_layers
        self.meshes = Meshes(self.binary, Materials(self.binary))
        self.nodes: list[dict[str, Any]] = []
        self.extras: dict[str, Any] = {"casa_assets": EXTRAS_VERSION, "id": name, "kind": kind}
        self.root = self.add({"name": name, "extras": self.extras, **placed(Y_UP)})
        self.cameras: list[dict[str, Any]] = []

    def add(self, row: dict[str, Any], below: int | None = None) -> int:
        """Add a node as a child of the node `below`, and return its index."""
        self.nodes.append(row)
        index = len(self.nodes) - 1
        if below is not None:
            self.nodes[below].setdefault("children", []).append(index)
        return index

    def bytes(self) -> bytes:
        """Return the file."""
        members: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": "casa-assets"},
            "scene": 0,
            "scenes": [{"name": self.extras["id"], "nodes": [self.root]}],
            "nodes": self.nodes,
            **({"meshes": self.meshes.rows} if self.meshes.rows else {}),
            **({"cameras": self.cameras} if self.cameras else {}),
            **self.meshes.materials.document(),
        }
        return glb(members, self.binary)


def asset_glb(asset: Asset, with_layers: bool = False) -> bytes:
    """Return the GLB of an asset, its joints in the first of its named poses; the same asset gives the same bytes.

    `with_layers`: with collision shapes and regions.
    """
    document = Document(asset.id, "asset", with_layers)
    document.extras["poses"] = {key.name: values(joint_positions(key.joints)) for key in asset.keyframes}
    document.extras["category"] = asset.labels.category
    start = joint_positions(asset.keyframes[0].joints) if asset.keyframes else {}
    add_nodes(document, Copy(asset, positions=start), document.root)
    return document.bytes()


def values(positions: Mapping[str, float], prefix: str = "") -> dict[str, float]:
    """Name of a joint in the file -> position, rad or m."""
    return {prefix + name: rounded([at])[0] for name, at in positions.items()}


NEAR_M = 0.01


def scene_glb(scene: Scene, with_layers: bool = False) -> bytes:
    """Return the GLB of a scene as it begins; the same scene gives the same bytes.

    Content that the assets of several placements have in common is written once. Named poses are those of the scene
    (`start`, `closed`, `open`) and any others that an asset has (`on`), in which all other assets are closed.
    `with_layers`: with collision shapes and regions.
    """
    document = Document(scene.id, "scene", with_layers)
    document.extras["poses"] = _poses(scene)
    if scene.sky is not None:
        document.extras["sky"] = {"zenith": rounded(scene.sky.zenith), "horizon": rounded(scene.sky.horizon)}
    assets, links = scene.asset_of, dict[str, dict[str, int]]()
    places = {place.name: place for place in scene.placements}
    for place in scene.placements:
        if place.name not in links:
            _add(document, place, places, assets, links)
    for camera in scene.cameras:
        lens = {"yfov": rounded([math.radians(camera.fov_y_deg)])[0], "znear": NEAR_M}
        document.cameras.append({"name": camera.name, "type": "perspective", "perspective": lens})
        seen = {"camera": len(document.cameras) - 1, **placed(camera.pose)}
        document.add({"name": f"camera/{camera.name}", **seen}, document.root)
    return document.bytes()


def _add(
    document: Document,
    place: Placement,
    places: dict[str, Placement],
    assets: dict[str, Asset],
    links: dict[str, dict[str, int]],
) -> None:
    """Add a placement, after the placement that carries it; `links` gets the nodes of its links by name."""
    asset, below, pose = assets[place.name], document.root, place.pose
    rest = place.resting
    if rest is not None and assets[rest.placement].is_moved(rest.link):
        holder = places[rest.placement]
        if holder.name not in links:
            _add(document, holder, places, assets, links)
        carrier = holder.pose @ assets[holder.name].asset_from_link(rest.link, joint_positions(holder.joints))
        below, pose = links[holder.name][rest.link], carrier.inverse() @ place.pose
    extras = {"name": place.name, "asset": asset.id, "category": asset.labels.category, "layer": place.layer.value}
    row: dict[str, Any] = {"name": place.name, "extras": {"placement": extras}, **placed(pose)}
    node = document.add(row, below)
    shown = LayerName.CEILING if place.layer is Layer.CEILING else LayerName.VISUAL
    copy = Copy(asset, f"{place.name}/", shown, joint_positions(place.joints))
    links[place.name] = add_nodes(document, copy, node)


def _poses(scene: Scene) -> dict[str, dict[str, float]]:
    """Pose name -> joint name in the file -> position; joints that are not named are at zero."""
    found: dict[str, dict[str, float]] = {}
    assets = scene.asset_of
    extra = dict.fromkeys(key.name for asset in scene.assets for key in asset.keyframes)
    for place in scene.placements:
        asset = assets[place.name]
        own = key_positions(place, asset)
        named = {key.name: joint_positions(key.joints) for key in asset.keyframes}
        for pose in dict.fromkeys([*own, *extra]):
            at = own.get(pose) if pose in own else named.get(pose, own[CLOSED_POSE])
            found.setdefault(pose, {}).update(values(at or {}, f"{place.name}/"))
    return found
