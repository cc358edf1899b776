"""A trimesh mesh or scene -> RawModel, or a Bundle of it that the stages take like one read from files."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping
from dataclasses import fields

import numpy as np
from PIL import Image

from casa_assets.errors import Rejected
from casa_assets.geometry.mesh.trimesh_exchange import (
    MeshOrScene,
    PlacedMesh,
    TrimeshMaterial,
    count_other_geometries,
    metres_per_unit,
    placed_meshes,
    up_axis,
)
from casa_assets.ingest import rejection_codes as codes
from casa_assets.ingest.load.formats import Format
from casa_assets.ingest.load.materials import (
    Images,
    ImageUse,
    linear_from_srgb,
    roughness_of_shininess,
    srgb_bytes_from_linear,
)
from casa_assets.ingest.load.notes import Notes
from casa_assets.ingest.load.raw_parts import ReadPart, check_face_count, raw_model
from casa_assets.ingest.load.text import UniqueNames
from casa_assets.model.asset.material import ColorSpace, Material, Texture
from casa_assets.model.source import Bundle, RawModel, Up

_BLACK = 0.02
WHITE = (1.0, 1.0, 1.0, 1.0)
# For meshes that the caller has made himself and holds in memory already.
NO_LIMITS: Mapping[str, float] = {
    "input_faces": math.inf,
    "input_texture_px": math.inf,
    "input_texture_pixels": math.inf,
}


def raw_from_trimesh(
    thing: MeshOrScene, limits: Mapping[str, float] = NO_LIMITS, name: str = "mesh", up: Up | None = None
) -> RawModel:
    """RawModel of a mesh or scene, node transforms applied; the same content gives the same model.

    Args:
        thing: its units are those that trimesh states; if it states none, they are inferred later from size and kind.
            PBR and simple materials, vertex and face colours (display values), texture coordinates and pictures are
            taken over.
        limits: input_faces, input_texture_px, input_texture_pixels; none by default.
        name: for messages.
        up: the axis that points up; None: the `up_axis` of the metadata, or y if it came from a glTF file.
    Raises:
        Rejected: NO_GEOMETRY, NO_FACES, NON_FINITE, TOO_LARGE, OUT_OF_BOUNDS, or MIXED_UNITS.
    """
    notes = Notes()
    model = read_placed(thing, limits, notes, name, Format.TRIMESH, up)
    return model.replace(notes=notes.issues)


def bundle_from_trimesh(
    thing: MeshOrScene, limits: Mapping[str, float] = NO_LIMITS, name: str = "mesh", up: Up | None = None
) -> Bundle:
    """A mesh or scene as a Bundle without files: `load` gives back its model, `sha256` is the digest of its content.

    The digest covers arrays, materials, pictures, unit and axis, and none of trimesh's own state.

    Raises:
        Rejected: as raw_from_trimesh.
    """
    return Bundle(main=f"{name}.trimesh", files={}, model=raw_from_trimesh(thing, limits, name, up))


def read_placed(
    thing: MeshOrScene, limits: Mapping[str, float], notes: Notes, name: str, file_format: Format, up: Up | None = None
) -> RawModel:
    """RawModel of a mesh or scene; remarks go into `notes`. Raises Rejected as raw_from_trimesh."""
    if count := count_other_geometries(thing):
        notes.add(codes.FEATURE_IGNORED, "geometry", f"{count} geometries are paths or point clouds; left out")
    placed: list[PlacedMesh] = []
    faces = 0
    try:
        for placed_mesh in placed_meshes(thing):
            faces += len(placed_mesh.faces)
            check_face_count(faces, limits, name)
            placed.append(placed_mesh)
    except ValueError as error:
        raise Rejected(codes.OUT_OF_BOUNDS, f"{name}: {error}") from error
    try:
        metres = metres_per_unit(thing)
    except ValueError as error:
        raise Rejected(codes.MIXED_UNITS, f"{name}: {error}") from error
    stated = up_axis(thing)
    materials = _Materials(Images(limits, notes), notes)
    parts = [_read_part(p, materials) for p in placed]
    return raw_model(parts, notes, name, file_format, metres, up or (Up(stated) if stated else None))


def _read_part(placed: PlacedMesh, materials: _Materials) -> ReadPart:
    colors = placed.colors
    if colors is not None and placed.is_linear:
        colors = np.column_stack((srgb_bytes_from_linear(colors[:, :3] / 255.0), colors[:, 3]))
    return ReadPart(
        name=placed.name,
        vertices=placed.vertices,
        faces=placed.faces,
        material=materials.material(placed.finish, placed.colors is not None),
        uv=placed.uv,
        normals=placed.normals,
        colors=colors,
    )


class _Materials:
    """Turns trimesh's materials into ours, each once."""

    def __init__(self, images: Images, notes: Notes) -> None:
        self._images, self._notes = images, notes
        self._names = UniqueNames()
        self._made: dict[tuple[object, ...], Material] = {}
        self._encoded: dict[tuple[int, ImageUse], Texture | None] = {}

    def material(self, source: TrimeshMaterial | None, is_colored: bool) -> Material:
        """Ours; grey where nothing says how it looks, white where vertex colours do."""
        key: tuple[object, ...] = (is_colored,)
        if source is not None:
            images = tuple((slot, id(image)) for slot, image in sorted(source.images.items()))
            key = tuple(images if f.name == "images" else getattr(source, f.name) for f in fields(source))
        if key not in self._made:
            self._made[key] = self._make(source, is_colored)
        return self._made[key]

    def _make(self, source: TrimeshMaterial | None, is_colored: bool) -> Material:
        if source is None:
            base = WHITE if is_colored else (0.8, 0.8, 0.8, 1.0)
            return Material(id=self._names.unique("material", "material"), base_color=base)
        name = source.name or "material"
        picture, color = source.images.get("base"), source.color
        if max(color[:3]) <= _BLACK < max(source.emissive) and (picture is None or "emissive" in source.images):
            self._notes.add(codes.EMISSIVE_AS_BASE, name, "black surface that glows: its glow is its colour")
            picture, color = source.images.get("emissive"), (*source.emissive, color[3])
        alpha, opacity = self._alpha(source, name)
        base_picture = self._texture(picture, f"{name}_color", ImageUse(ColorSpace.SRGB, alpha))
        rgb = color[:3] if source.is_linear else tuple(linear_from_srgb(c) for c in color[:3])
        if not source.is_linear and base_picture is not None:
            rgb = (1.0, 1.0, 1.0)  # as for OBJ: beside a picture the diffuse colour is a leftover as often as a tint
        return Material(
            id=self._names.unique(name, "material"),
            base_color=(*rgb, opacity),
            metallic=_metallic(source),
            roughness=_roughness(source),
            base_color_texture=base_picture,
            metallic_roughness_texture=self._texture(
                source.images.get("rough"), f"{name}_rough", ImageUse(ColorSpace.RAW, "drop")
            ),
            normal_texture=self._texture(
                source.images.get("normal"), f"{name}_normal", ImageUse(ColorSpace.RAW, "drop")
            ),
        )

    def _alpha(self, source: TrimeshMaterial, name: str) -> tuple[str | float, float]:
        """Treatment of the picture's alpha (see ImageUse), and the opacity of the material."""
        opacity = source.color[3]
        if source.alpha_mode == "OPAQUE":
            return "drop", 1.0
        if opacity <= 0.0:
            self._notes.add(codes.FULLY_TRANSPARENT, name, "alpha 0 would hide it; made opaque")
            return "drop", 1.0
        return (min(1.0, source.alpha_cutoff / opacity), 1.0) if source.alpha_mode == "MASK" else ("keep", opacity)

    def _texture(self, image: Image.Image | None, name: str, use: ImageUse) -> Texture | None:
        if image is None:
            return None
        key = (id(image), use)
        if key not in self._encoded:
            stream = io.BytesIO()
            image.save(stream, "PNG", compress_level=1)
            data = stream.getvalue()
            self._encoded[key] = self._images.texture(f"{name}/{len(self._encoded)}", data, name, use)
        return self._encoded[key]


def _metallic(source: TrimeshMaterial) -> float:
    """Stated, or what the kind of material means where it says nothing (glTF: 1)."""
    if source.metallic is None:
        return 1.0 if source.is_linear and not _is_bare(source) else 0.0
    return min(1.0, max(0.0, float(source.metallic)))


def _roughness(source: TrimeshMaterial) -> float:
    if not source.is_linear:
        return roughness_of_shininess(source.shininess)
    if source.roughness is None:
        return 0.9 if _is_bare(source) else 1.0
    return min(1.0, max(0.0, float(source.roughness)))


def _is_bare(source: TrimeshMaterial) -> bool:
    """True where a PBR material states nothing at all of how it shines; it is then matt, as for glTF."""
    stated = source.metallic, source.roughness
    return stated == (None, None) and not {"base", "rough"} & source.images.keys() and source.color == WHITE
