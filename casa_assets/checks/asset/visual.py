"""Find degenerate triangles, wrong normals, bad texture coordinates and oversized pictures (VIS)."""

from __future__ import annotations

import numpy as np

from casa_assets.checks.asset.applicability import NO_VISUALS, merged_mesh, visuals_of
from casa_assets.checks.check import Measurement, all_at_least, all_at_most, at_most, count, largest, not_applicable
from casa_assets.core.typing import Floats
from casa_assets.geometry.mesh.inside_out import inside_out_faces
from casa_assets.geometry.mesh.measure import backward_share, face_normals
from casa_assets.geometry.mesh.topology import weld
from casa_assets.model.asset.asset import Asset, Link, Visual
from casa_assets.model.asset.material import Texture
from casa_assets.model.pose import Pose

NO_PICTURES = "it shows no picture"
MIN_VERTICES = 4  # Ref: MuJoCo refuses to compile a mesh of fewer.
NORMAL_LENGTH_TOLERANCE = 0.00674  # Ref: glTF-Validator, how far a normal's length may be from 1.
SAME_VERTEX_M = 1e-6  # what float32 storage may move a vertex by, metres


def triangles_have_area(asset: Asset) -> Measurement:
    """VIS001: number of triangles without area."""
    counts = {pointer: int((_normals_and_areas(v)[1] <= 0).sum()) for pointer, _, v in visuals_of(asset)}
    if not counts:
        return not_applicable(NO_VISUALS)
    problems = tuple((p, f"{n} triangles have no area; leave them out") for p, n in counts.items() if n)
    return Measurement(float(sum(counts.values())), problems)


def normals_face_outwards(asset: Asset, limit: float) -> Measurement:
    """VIS002: share of a mesh's area whose normals point against its front."""
    shares, problems = [], []
    for pointer, _, visual in visuals_of(asset):
        normals = visual.mesh.normals
        if normals is None:
            continue
        if np.abs(np.linalg.norm(normals, axis=1) - 1).max(initial=0.0) > NORMAL_LENGTH_TOLERANCE:
            problems.append((pointer, "normals are not of length one; normalise them"))
        share = backward_share(visual.mesh.vertices, visual.mesh.faces, normals)
        shares.append(share)
        if share > limit:
            message = f"{share:.1%} of it has normals that look inwards; compute them from the triangles"
            problems.append((pointer, message))
    return largest(shares, problems, "none of its meshes carries normals")


def closed_parts_wind_outwards(asset: Asset, limit: float) -> Measurement:
    """VIS003: share of a link's surface on closed parts that wind inwards."""
    shares = {f"links/{link.name}/visuals": _inverted_share(link) for link in asset.links if link.visuals}
    return all_at_most(shares, limit, "{:.1%} of the surface is inside out; turn those triangles", NO_VISUALS)


def triangle_count_is_bounded(asset: Asset, limit: float) -> Measurement:
    """VIS004: number of visible triangles."""
    triangles = sum(len(v.mesh.faces) for _, _, v in visuals_of(asset))
    if not triangles:
        return not_applicable(NO_VISUALS)
    return at_most(float(triangles), limit, "", f"has {triangles} triangles; simplify it further")


def textured_meshes_are_unwrapped(asset: Asset) -> Measurement:
    """VIS005: number of meshes with a picture but without usable texture coordinates."""
    textured = {m.id for m in asset.materials if m.textures}
    visuals = [(pointer, v) for pointer, _, v in visuals_of(asset) if v.material in textured]
    if not visuals:
        return not_applicable(NO_PICTURES)
    message = "shows a picture, but all its texture coordinates are missing or one point; unwrap it or drop the picture"
    return count((pointer, message) for pointer, v in visuals if not _is_unwrapped(v))


def texture_size_is_bounded(asset: Asset, limit: float) -> Measurement:
    """VIS006: longest side of a picture according to its file, pixels."""
    sides, problems = [], []
    for material in asset.materials:
        for texture in material.textures:
            size = _png_size(texture)
            sides.append(float(max(size)))
            pointer = f"materials/{material.id}/{texture.name}"
            if size != (texture.width_px, texture.height_px):
                problems.append((pointer, f"is {size[0]} x {size[1]} pixels, not as stated; read its size again"))
            if max(size) > limit:
                problems.append((pointer, f"is {size[0]} x {size[1]} pixels; scale it down"))
    return largest(sides, problems, NO_PICTURES)


def meshes_have_enough_vertices(asset: Asset) -> Measurement:
    """VIS007: least number of vertices of a mesh."""
    counts = {pointer: len(v.mesh.vertices) for pointer, _, v in visuals_of(asset)}
    message = f"has {{}} vertices, MuJoCo asks for {MIN_VERTICES}; join it to another mesh"
    return all_at_least(counts, MIN_VERTICES, message, NO_VISUALS)


def meshes_are_unique(asset: Asset) -> Measurement:
    """VIS008: number of meshes that lie exactly on another one."""
    if not any(link.visuals for link in asset.links):
        return not_applicable(NO_VISUALS)
    first: dict[bytes, str] = {}
    problems = []
    for pointer, link, visual in visuals_of(asset):
        twin = first.setdefault(_triangle_key(visual, asset.asset_from_link(link.name)), pointer)
        if twin != pointer:
            problems.append((pointer, f"is the same mesh in the same place as {twin}; leave one out"))
    return count(problems)


def _normals_and_areas(visual: Visual) -> tuple[Floats, Floats]:
    """(F, 3) unit normals of the triangles and (F,) areas in square metres."""
    return face_normals(visual.mesh.vertices, visual.mesh.faces.astype(np.int64))


def _is_unwrapped(visual: Visual) -> bool:
    uv = visual.mesh.uv
    return uv is not None and bool(np.isfinite(uv).all()) and float(np.ptp(uv, axis=0).max(initial=0.0)) > 0


def _png_size(texture: Texture) -> tuple[int, int]:
    """Width and height in pixels, from the header of the file. Ref: PNG 1.2, the first chunk is IHDR."""
    return int.from_bytes(texture.png[16:20], "big"), int.from_bytes(texture.png[20:24], "big")


def _triangle_key(visual: Visual, pose: Pose) -> bytes:
    """Key that is equal for meshes with the same triangles, however their vertices are shared or ordered."""
    cells = np.round(pose.apply(visual.mesh.vertices) / SAME_VERTEX_M).astype(np.int64)
    corners = cells[visual.mesh.faces]
    # Each triangle is turned to start at its least corner, which keeps its winding; then they are sorted.
    rank = np.lexsort((corners[..., 2], corners[..., 1], corners[..., 0]), axis=1)[:, :1]
    turned = np.take_along_axis(corners, ((rank + np.arange(3)) % 3)[..., None], axis=1).reshape(-1, 9)
    return np.unique(turned, axis=0).tobytes()


def _inverted_share(link: Link) -> float:
    """Share of the area of a link on closed components of negative volume that are not the lining of another one."""
    vertices, faces = merged_mesh(link.visuals)
    points, welded = weld(vertices)
    faces = welded[faces]
    _, areas = face_normals(points, faces)
    if areas.sum() <= 0:
        return 0.0
    return float(areas[inside_out_faces(points, faces)].sum() / areas.sum())
