"""Sound assets spoilt in one way each, as meshes of strangers are: what a filter has to find."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image

from casa_assets.ingest.texture import png_bytes
from casa_assets.mesh.solid.solids import convex_hull
from casa_assets.mesh.surface import face_normals
from casa_assets.model.asset.asset import Asset, Visual
from casa_assets.model.asset.material import Material, Texture
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.registry.category import Category, MatterFill, RestingPose

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Way:
    """One way of spoiling.

    Attributes:
        name: in words. code: of the filter that has to speak.
        spoil: the spoilt asset, None where an asset cannot be spoilt so.
    """

    name: str
    code: str
    spoil: Callable[[Asset, Category], Asset | None]


def without_bottom(asset: Asset, category: Category) -> Asset | None:
    """Less all triangles that face down in the lowest twentieth."""
    if category.build not in (MatterFill.SOLID, MatterFill.FILLED) or category.upright is not RestingPose.STANDS:
        return None
    low, high = asset.bounds[:, 2]

    def stays(mesh: Mesh) -> npt.NDArray[np.bool_]:
        normals, _ = face_normals(mesh.vertices, mesh.faces.astype(np.int64))
        deep = mesh.vertices[mesh.faces][:, :, 2].mean(axis=1) < low + 0.05 * (high - low)
        kept: npt.NDArray[np.bool_] = ~(deep & (normals[:, 2] < -0.5))
        return kept

    return _faces(asset, stays)


def turned(asset: Asset, category: Category) -> Asset | None:
    """Three in ten triangles wound the other way."""

    def one(mesh: Mesh) -> Mesh:
        faces = mesh.faces.copy()
        rows = np.arange(len(faces)) * 7 % 10 < 3
        faces[rows] = faces[rows, ::-1]
        return mesh.replace(faces=faces)

    return _meshes(asset, one)


def doubled(asset: Asset, category: Category) -> Asset | None:
    """Two of it in one file, a fifth of its width apart."""
    shift = np.array([1.2 * float(np.ptp(asset.bounds[:, 0])), 0.0, 0.0])
    extra = tuple(
        v.replace(name=f"{v.name}_again", mesh=v.mesh.with_vertices(v.mesh.vertices + shift, v.mesh.normals))
        for v in asset.root.visuals
    )
    return _link(asset, (*asset.root.visuals, *extra))


def grounded(asset: Asset, category: Category) -> Asset | None:
    """On a slab three times as wide as it is."""
    if category.upright is not RestingPose.STANDS or category.fixed:
        return None
    wide = 3 * float(np.ptp(asset.bounds, axis=0)[:2].max())
    box = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-1.0, 0.0)])
    points, faces = convex_hull(box * [wide, wide, 0.02 * float(np.ptp(asset.bounds[:, 2]))])
    slab = Visual(name="slab", mesh=Mesh(vertices=points, faces=faces), material=asset.root.visuals[0].material)
    return _link(asset, (*asset.root.visuals, slab))


def of_cards(asset: Asset, category: Category) -> Asset | None:
    """Two crossed sheets of its height and width in its place."""
    x, y, z = (float(v) for v in np.ptp(asset.bounds, axis=0))
    faces = [(0, 1, 2), (0, 2, 3), (2, 1, 0), (3, 2, 0)]
    sheets = (
        [[-x / 2, 0, 0], [x / 2, 0, 0], [x / 2, 0, z], [-x / 2, 0, z]],
        [[0, -y / 2, 0], [0, y / 2, 0], [0, y / 2, z], [0, -y / 2, z]],
    )
    look = asset.root.visuals[0].material
    cards = (Visual(name=f"card_{i}", mesh=Mesh(vertices=s, faces=faces), material=look) for i, s in enumerate(sheets))
    return _link(asset, tuple(cards))


def filled(asset: Asset, category: Category) -> Asset | None:
    """A vessel as its own hull."""
    if category.build is not MatterFill.VESSEL:
        return None
    points, faces = convex_hull(np.concatenate([v.mesh.vertices for v in asset.root.visuals]))
    first = asset.root.visuals[0]
    return _link(asset, (first.replace(mesh=Mesh(vertices=points, faces=faces)),))


def stretched(asset: Asset, category: Category) -> Asset | None:
    """Two and a half times as tall for its width."""
    return _meshes(asset, lambda m: m.with_vertices(m.vertices * [1.0, 1.0, 2.5], m.normals))


def blackened(asset: Asset, category: Category) -> Asset | None:
    """All materials black, as exporters leave them."""
    return _looks(
        asset,
        lambda m: Material(id=m.id, base_color=(0.0, 0.0, 0.0, 1.0), roughness=m.roughness, substance=m.substance),
    )


def greyed(asset: Asset, category: Category) -> Asset | None:
    """All materials a default grey, as exporters leave them."""
    return _looks(asset, lambda m: Material(id=m.id, substance=m.substance))


def shrunk(asset: Asset, category: Category) -> Asset | None:
    """Pictures of 12 pixels."""
    return _pictures(asset, lambda p: p.resize((12, 12), Image.Resampling.BOX))


def blurred(asset: Asset, category: Category) -> Asset | None:
    """Pictures that were 12 pixels once and have their old size again."""
    return _pictures(asset, lambda p: p.resize((12, 12), Image.Resampling.BOX).resize(p.size, Image.Resampling.BICUBIC))


def light_headed(asset: Asset, category: Category) -> Asset | None:
    """A tenth of its inertia."""
    inertial = asset.root.inertial
    xx, yy, zz, xy, xz, yz = (v / 10 for v in inertial.inertia)
    link = asset.root.replace(inertial=inertial.replace(inertia=(xx, yy, zz, xy, xz, yz)))
    return asset.replace(links=(link,))


WAYS = (
    Way("open bottom", "FLT002", without_bottom),
    Way("mixed winding", "FLT003", turned),
    Way("flat cards", "FLT004", of_cards),
    Way("two objects in one file", "FLT005", doubled),
    Way("ground baked in", "FLT006", grounded),
    Way("2.5 times too tall", "FLT008", stretched),
    Way("vessel filled up", "FLT009", filled),
    Way("black materials", "FLT010", blackened),
    Way("grey default materials", "FLT011", greyed),
    Way("pictures of 12 pixels", "FLT012", shrunk),
    Way("blurred pictures", "FLT012", blurred),
    Way("inertia ten times too small", "FLT014", light_headed),
)


def _link(asset: Asset, visuals: tuple[Visual, ...]) -> Asset:
    return asset.replace(links=(asset.root.replace(visuals=visuals),))


def _meshes(asset: Asset, change: Callable[[Mesh], Mesh]) -> Asset:
    return _link(asset, tuple(v.replace(mesh=change(v.mesh)) for v in asset.root.visuals))


def _faces(asset: Asset, stays: Callable[[Mesh], npt.NDArray[np.bool_]]) -> Asset | None:
    kept = [(v, stays(v.mesh)) for v in asset.root.visuals]
    if all(rows.all() for _, rows in kept):
        return None
    left = tuple(v.replace(mesh=v.mesh.replace(faces=v.mesh.faces[rows])) for v, rows in kept if rows.any())
    return _link(asset, left)


def _looks(asset: Asset, change: Callable[[Material], Material]) -> Asset:
    return asset.replace(materials=tuple(change(m) for m in asset.materials))


def _pictures(asset: Asset, change: Callable[[Image.Image], Image.Image]) -> Asset | None:
    if not any(m.base_color_texture is not None and m.base_color_texture.name != "painted" for m in asset.materials):
        return None

    def one(look: Material) -> Material:
        image = look.base_color_texture
        if image is None:
            return look
        with Image.open(io.BytesIO(image.png)) as opened:
            small = change(opened.convert("RGB"))
        skin = Texture(name=image.name, png=png_bytes(small), width_px=small.width, height_px=small.height)
        return look.replace(base_color_texture=skin)

    return _looks(asset, one)
