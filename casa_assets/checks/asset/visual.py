"""Find degenerate triangles, wrong normals, bad texture coordinates and oversized pictures (VIS)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from casa_assets.checks.asset.built import UNSEEN
from casa_assets.checks.check import Measurement, largest, least, not_applicable, required_limit
from casa_assets.core.typing import Floats, Ints, Mask
from casa_assets.geometry.mesh.measure import face_normals
from casa_assets.geometry.mesh.topology import edge_counts, face_components, weld
from casa_assets.model.asset.asset import Asset, Link, Visual
from casa_assets.model.asset.material import Texture
from casa_assets.model.pose import Pose

NO_PICTURES = "it shows no picture"
LEAST_VERTICES = 4  # Ref: MuJoCo refuses to compile a mesh of fewer.
UNIT_SLACK = 0.00674  # Ref: glTF-Validator, how far a normal's length may be from 1.
SAME_M = 1e-6  # what float32 storage may move a vertex by


def triangles_have_area(asset: Asset, limit: float | None) -> Measurement:
    """VIS001: number of triangles without area."""
    counts = {p: int((_sides(v)[1] <= 0).sum()) for p, v in _visuals(asset)}
    if not counts:
        return not_applicable(UNSEEN)
    problems = tuple((p, f"{n} triangles have no area; leave them out") for p, n in counts.items() if n)
    return Measurement(float(sum(counts.values())), problems)


def normals_face_outwards(asset: Asset, limit: float | None) -> Measurement:
    """VIS002: share of a mesh's area whose normals point against its front."""
    shares, problems = [], []
    for pointer, visual in _visuals(asset):
        normals = visual.mesh.normals
        if normals is None:
            continue
        if np.abs(np.linalg.norm(normals, axis=1) - 1).max(initial=0.0) > UNIT_SLACK:
            problems.append((pointer, "normals are not of length one; normalise them"))
        fronts, areas = _sides(visual)
        behind = np.einsum("fkj,fj->fk", normals[visual.mesh.faces], fronts) < 0
        share = float((behind.mean(axis=1) * areas).sum() / max(float(areas.sum()), 1e-300))
        shares.append(share)
        if share > required_limit(limit):
            problems.append(
                (pointer, f"{share:.1%} of it has normals that look inwards; compute them from the triangles")
            )
    return largest(shares, tuple(problems), "none of its meshes carries normals")


def closed_parts_wind_outwards(asset: Asset, limit: float | None) -> Measurement:
    """VIS003: share of a link's surface on closed parts that wind inwards."""
    shares, problems = [], []
    for link in asset.links:
        if not link.visuals:
            continue
        share = _inverted_share(link)
        shares.append(share)
        if share > required_limit(limit):
            message = f"{share:.1%} of the surface is inside out; turn those triangles"
            problems.append((f"links/{link.name}/visuals", message))
    return largest(shares, tuple(problems), UNSEEN)


def triangle_count_is_bounded(asset: Asset, limit: float | None) -> Measurement:
    """VIS004: number of visible triangles."""
    count = sum(len(v.mesh.faces) for _, v in _visuals(asset))
    if not count:
        return not_applicable(UNSEEN)
    problems = (("", f"has {count} triangles; simplify it further"),) if count > required_limit(limit) else ()
    return Measurement(float(count), problems)


def textured_meshes_are_unwrapped(asset: Asset, limit: float | None) -> Measurement:
    """VIS005: number of meshes with a picture but without usable texture coordinates."""
    textured = {m.id for m in asset.materials if m.textures}
    shown = [(p, v) for p, v in _visuals(asset) if v.material in textured]
    if not shown:
        return not_applicable(NO_PICTURES)
    bare = [p for p, v in shown if not _is_unwrapped(v)]
    message = "shows a picture, but all its texture coordinates are missing or one point; unwrap it or drop the picture"
    return Measurement(float(len(bare)), tuple((p, message) for p in bare))


def texture_size_is_bounded(asset: Asset, limit: float | None) -> Measurement:
    """VIS006: longest side of a picture according to its file, pixels."""
    sides, problems = [], []
    for material in asset.materials:
        for texture in material.textures:
            size = _png_size(texture)
            sides.append(float(max(size)))
            pointer = f"materials/{material.id}/{texture.name}"
            if size != (texture.width_px, texture.height_px):
                problems.append((pointer, f"is {size[0]} x {size[1]} pixels, not as stated; read its size again"))
            if max(size) > required_limit(limit):
                problems.append((pointer, f"is {size[0]} x {size[1]} pixels; scale it down"))
    return largest(sides, tuple(problems), NO_PICTURES)


def meshes_have_enough_vertices(asset: Asset, limit: float | None) -> Measurement:
    """VIS007: least number of vertices of a mesh."""
    counts = {p: len(v.mesh.vertices) for p, v in _visuals(asset)}
    message = "has {} vertices, MuJoCo asks for 4; join it to another mesh"
    problems = tuple((p, message.format(n)) for p, n in counts.items() if n < LEAST_VERTICES)
    return least(map(float, counts.values()), problems, UNSEEN)


def meshes_are_unique(asset: Asset, limit: float | None) -> Measurement:
    """VIS008: number of meshes that lie exactly on another one."""
    if not any(link.visuals for link in asset.links):
        return not_applicable(UNSEEN)
    first: dict[bytes, str] = {}
    problems = []
    for link in asset.links:
        pose = asset.asset_from_link(link.name)
        for visual in link.visuals:
            pointer = f"links/{link.name}/visuals/{visual.name}"
            twin = first.setdefault(_triangles(visual, pose), pointer)
            if twin != pointer:
                problems.append((pointer, f"is the same mesh in the same place as {twin}; leave one out"))
    return Measurement(float(len(problems)), tuple(problems))


def _visuals(asset: Asset) -> Iterator[tuple[str, Visual]]:
    """(pointer, visual) of all that is seen."""
    for link in asset.links:
        for visual in link.visuals:
            yield f"links/{link.name}/visuals/{visual.name}", visual


def _sides(visual: Visual) -> tuple[Floats, Floats]:
    """(F, 3) unit vectors out of the front of each triangle and (F,) areas in square metres."""
    return face_normals(visual.mesh.vertices, visual.mesh.faces.astype(np.int64))


def _is_unwrapped(visual: Visual) -> bool:
    uv = visual.mesh.uv
    return uv is not None and bool(np.isfinite(uv).all()) and float(np.ptp(uv, axis=0).max(initial=0.0)) > 0


def _png_size(texture: Texture) -> tuple[int, int]:
    """Width and height in pixels, from the header of the file. Ref: PNG 1.2, the first chunk is IHDR."""
    return int.from_bytes(texture.png[16:20], "big"), int.from_bytes(texture.png[20:24], "big")


def _triangles(visual: Visual, pose: Pose) -> bytes:
    """Key that is equal for meshes with the same triangles, however their vertices are shared or ordered."""
    cells = np.round(pose.apply(visual.mesh.vertices) / SAME_M).astype(np.int64)
    corners = cells[visual.mesh.faces]
    # Each triangle starts at its least corner, which keeps its winding; then they are sorted.
    rank = np.lexsort((corners[..., 2], corners[..., 1], corners[..., 0]), axis=1)[:, :1]
    turned = np.take_along_axis(corners, ((rank + np.arange(3)) % 3)[..., None], axis=1).reshape(-1, 9)
    return np.unique(turned, axis=0).tobytes()


def _inverted_share(link: Link) -> float:
    """Share of the area of a link that lies on closed pieces of negative volume which are no lining."""
    starts = np.cumsum([0, *(len(v.mesh.vertices) for v in link.visuals)])
    faces = np.concatenate([v.mesh.faces + s for v, s in zip(link.visuals, starts, strict=False)]).astype(np.int64)
    points, place = weld(np.concatenate([v.mesh.vertices for v in link.visuals]))
    ids = place[faces]
    label = face_components(ids, len(points))
    _, areas = face_normals(points, ids)
    if areas.sum() <= 0:
        return 0.0
    low, high, volume = _pieces(points, ids, label)
    least = -1e-9 * (high - low).max(axis=1) ** 3  # a closed piece may be flat: then it has no inside
    inverted = np.flatnonzero(_closed(ids, label, len(points)) & (volume < least))
    bad = [k for k in inverted if not _lines_another(low, high, int(k))]
    return float(areas[np.isin(label, bad)].sum() / areas.sum())


def _pieces(points: Floats, ids: Ints, label: Ints) -> tuple[Floats, Floats, Floats]:
    """(C, 3) lower and (C, 3) upper corner and (C,) signed volume of each piece; the last holds for closed ones."""
    count = int(label.max()) + 1
    corners = points[ids] - points.mean(axis=0)
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    np.minimum.at(low, label, corners.min(axis=1))
    np.maximum.at(high, label, corners.max(axis=1))
    cones = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    volume = np.bincount(label, weights=cones, minlength=count).astype(np.float64)
    return low, high, volume


def _closed(ids: Ints, label: Ints, count: int) -> Mask:
    """(C,) whether each edge of a piece is used by two faces, once each way."""
    of_point = np.zeros(count, dtype=np.int64)
    of_point[ids] = label[:, None]
    ends, uses, balance = edge_counts(ids)
    closed = np.ones(int(label.max()) + 1, dtype=bool)
    closed[of_point[ends[(uses != 2) | (balance != 0), 0]]] = False
    return closed


def _lines_another(low: Floats, high: Floats, piece: int) -> bool:
    """True if a piece lies within the bounds of a larger one: the inner wall of a hollow thing winds inwards."""
    within = (low <= low[piece]).all(axis=1) & (high >= high[piece]).all(axis=1)
    larger = (high - low).prod(axis=1) > (high - low)[piece].prod()
    return bool((within & larger).any())
