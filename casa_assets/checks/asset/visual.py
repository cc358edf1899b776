"""Find degenerate triangles, wrong normals, coplanar faces, bad texture coordinates and oversized pictures (VIS)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from casa_assets.checks import check
from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.planar import counter_clockwise, signed_area
from casa_assets.mesh.surface import backward_share, face_normals, inside_out_faces, weld
from casa_assets.model.asset.asset import Asset, Link, Visual
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2

# Share of a mesh's area that has to be right: seams of a body that is turned or swept leave slivers.
RIGHT_AREA_SHARE = 0.99
MIN_AREA_M2 = 1e-9
# No triangle larger than a square millimetre, not even of the others, shows its picture at half the size or at one and
# a half. Our choice.
TORN_STRETCH, TORN_AREA_M2 = 0.5, 1e-6
# Nearer than this a depth buffer does not separate two faces of a kitchen. Faces that are set back by 0.2 mm pass.
MIN_SEPARATION_M = 0.000199
SAME_DIRECTION = 0.01  # largest distance between the unit normals of coplanar faces
MIN_FACE_M2 = 2e-7
# Faces are binned by normal and by offset. A bin is four times as wide as what may differ, and each is laid out twice,
# shifted: two faces on either side of the edge of one bin then share another. The shifts are chosen so that no common
# direction or length lies on an edge.
BIN_WIDTH, BIN_SHIFTS = 4, (0.137, 0.637)
NO_PICTURES = "it shows no picture"
MIN_VERTICES = 4  # Ref: MuJoCo refuses to compile a mesh of fewer.
NORMAL_LENGTH_TOLERANCE = 0.00674  # Ref: glTF-Validator, how far a normal's length may be from 1.
SAME_VERTEX_M = 1e-6  # what float32 storage may move a vertex by, metres


def texture_scale_is_true(asset: Asset, limit: float) -> check.Measurement:
    """VIS009: worst deviation of the texture's scale from 1, over 99 % of a mesh's area."""
    tiles = {m.id: m.tile_m for m in asset.materials}
    stretches, problems = [], []
    for pointer, _, visual in check.visuals_of(asset):
        tile = tiles[visual.material]
        if tile is None:
            continue
        if visual.mesh.uv is None:
            problems.append((pointer, "shows a picture that repeats but has no texture coordinates"))
            continue
        stretch = _stretch(visual, tile)
        stretches.append(stretch)
        if stretch > limit:
            message = f"stretches its picture by {stretch:.1%}; texture coordinates are metres over tile"
            problems.append((pointer, message))
    if problems and not stretches:
        return check.Measurement(problems=tuple(problems))
    return check.largest(stretches, problems, "nothing of it shows a picture that repeats")


def _stretch(visual: Visual, tile: Vec2) -> float:
    """Largest |singular value - 1| of the map from surface to picture in metres, leaving out 1 % of the area."""
    mesh = visual.mesh
    assert mesh.uv is not None
    corners = mesh.vertices[mesh.faces]
    flat = mesh.uv[mesh.faces] * np.array(tile)
    edge_a, edge_b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(edge_a, edge_b)
    area = np.linalg.norm(normal, axis=1) / 2
    keep = area > MIN_AREA_M2
    if not keep.any():
        return 0.0
    edge_a, edge_b, area, normal = edge_a[keep], edge_b[keep], area[keep], normal[keep]
    length = np.linalg.norm(edge_a, axis=1)
    x = edge_a / length[:, None]
    y = np.cross(normal / (2 * area)[:, None], x)
    # Columns: the two edges in the plane of the face, and in the picture.
    along, aside = np.einsum("ij,ij->i", edge_b, x), np.einsum("ij,ij->i", edge_b, y)
    face = np.stack([np.stack([length, along], 1), np.stack([0 * length, aside], 1)], 1)
    shown = np.stack([(flat[:, 1] - flat[:, 0])[keep], (flat[:, 2] - flat[:, 0])[keep]], axis=2)
    scales = np.linalg.svd(shown @ np.linalg.inv(face), compute_uv=False)
    off = np.abs(scales - 1).max(axis=1)
    torn = float(off[area > TORN_AREA_M2].max(initial=0.0))
    if torn > TORN_STRETCH:
        return torn
    order = np.argsort(off)
    # A triangle counts where it begins within the share, so that of a few large ones all do.
    counted = np.cumsum(area[order]) - area[order] < RIGHT_AREA_SHARE * area.sum()
    return float(off[order][counted].max(initial=0.0))


def coplanar_faces_do_not_overlap(asset: Asset, limit: float) -> check.Measurement:
    """VIS010: m^2 of the largest coplanar overlap of two meshes with different looks."""
    if not check.is_from_family(asset):
        return check.not_applicable(check.NOT_BUILT)
    if not any(link.visuals for link in asset.links):
        return check.not_applicable(check.NO_VISUALS)
    faces = _faces(asset)
    overlaps: dict[tuple[int, int], float] = {}
    for a, b in _candidate_pairs(faces):
        area = _overlap_area(faces.corners[a], faces.corners[b], faces.normals[a])
        if area > 0:
            i, j = sorted((int(faces.visual[a]), int(faces.visual[b])))
            overlaps[i, j] = overlaps.get((i, j), 0.0) + area
    rows = []
    for (i, j), area in sorted(overlaps.items()):
        message = f"shares {area * 1e6:.1f} mm^2 of surface with {faces.pointers[j]}; set one of them back"
        rows.append((faces.pointers[i], area, message))
    return check.worst_above(rows, limit)


@dataclass(frozen=True)
class _Faces:
    """All triangles in the asset frame: (F, 3, 3) corners in metres, (F, 3) normals, (F,) numbers of visual and look.

    Faces of one look may coincide; a visual with a picture has a separate look. `pointers`: of each visual.
    """

    corners: Floats
    normals: Floats
    visual: Ints
    look: Ints
    pointers: list[str]


def _faces(asset: Asset) -> _Faces:
    textured = {m.id for m in asset.materials if m.textures}
    triangles, looks = [], []
    pointers: list[str] = []
    for pointer, link, visual in check.visuals_of(asset):
        points = asset.asset_from_link(link.name).apply(visual.mesh.vertices)
        triangles.append(points[visual.mesh.faces])
        pointers.append(pointer)
        looks.append(f"{visual.material}/{visual.name}" if visual.material in textured else visual.material)
    corners = np.concatenate(triangles)
    owner = np.repeat(np.arange(len(triangles)), [len(t) for t in triangles])
    points = corners.reshape(-1, 3)
    normals, area = face_normals(points, np.arange(len(points)).reshape(-1, 3))
    keep = area > MIN_FACE_M2
    look = np.unique(looks, return_inverse=True)[1].astype(np.int64)[owner]
    return _Faces(corners[keep], normals[keep], owner[keep], look[keep], pointers)


def _candidate_pairs(faces: _Faces) -> list[tuple[int, int]]:
    """Faces of different looks that lie in one plane, look the same way and whose boxes overlap, each pair once."""
    offset = np.einsum("ij,ij->i", faces.normals, faces.corners[:, 0])
    pairs: set[tuple[int, int]] = set()
    for direction_shift in BIN_SHIFTS:
        direction = np.floor(faces.normals / (BIN_WIDTH * SAME_DIRECTION) + direction_shift)
        for offset_shift in BIN_SHIFTS:
            place = np.floor(offset / (BIN_WIDTH * MIN_SEPARATION_M) + offset_shift)
            for group in _mixed_groups(np.column_stack([direction, place]), faces.look):
                pairs.update(_close_pairs(faces, group))
    return sorted(pairs)


def _mixed_groups(keys: Floats, look: Ints) -> list[Ints]:
    """Numbers of faces by equal keys, of the groups with more than one look."""
    order = np.lexsort(keys.T[::-1])
    starts = np.flatnonzero(np.concatenate([[True], (np.diff(keys[order], axis=0) != 0).any(axis=1)]))
    several = np.minimum.reduceat(look[order], starts) != np.maximum.reduceat(look[order], starts)
    ends = np.append(starts[1:], len(order))
    return [np.sort(order[starts[g] : ends[g]]) for g in np.flatnonzero(several)]


def _close_pairs(faces: _Faces, group: Ints) -> Iterator[tuple[int, int]]:
    """Pairs within a group; faces are sorted by their least x, so that only those that follow closely are tried."""
    corners, normals, look = faces.corners[group], faces.normals[group], faces.look[group]
    lower, upper = corners.min(axis=1), corners.max(axis=1) + MIN_SEPARATION_M
    order = np.argsort(lower[:, 0], kind="stable")
    for n, i in enumerate(order):
        rest = order[n + 1 :]
        rest = rest[: int(np.searchsorted(lower[rest, 0], upper[i, 0]))]
        rest = rest[look[rest] != look[i]]
        rest = rest[((lower[rest] <= upper[i]) & (upper[rest] >= lower[i])).all(axis=1)]
        separation = np.abs((corners[rest].mean(axis=1) - corners[i].mean(axis=0)) @ normals[i])
        parallel = np.linalg.norm(normals[rest] - normals[i], axis=1) < SAME_DIRECTION
        for j in rest[(separation < MIN_SEPARATION_M) & parallel]:
            yield (int(min(group[i], group[j])), int(max(group[i], group[j])))


def _overlap_area(first: Floats, second: Floats, normal: Floats) -> float:
    """Area in which two (3, 3) triangles of one plane overlap, m^2. Ref: Sutherland and Hodgman 1974."""
    dropped = int(np.argmax(np.abs(normal)))
    axes = [k for k in range(3) if k != dropped]
    a, b = (counter_clockwise(triangle) for triangle in (first[:, axes], second[:, axes]))
    polygon = list(a)
    for k in range(3):
        start, end = b[k], b[(k + 1) % 3]
        edge = end - start
        clipped = []
        for p, q in zip(polygon, [*polygon[1:], polygon[0]], strict=True):
            inside_p = edge[0] * (p[1] - start[1]) - edge[1] * (p[0] - start[0])
            inside_q = edge[0] * (q[1] - start[1]) - edge[1] * (q[0] - start[0])
            if inside_p >= 0:
                clipped.append(p)
            if (inside_p >= 0) != (inside_q >= 0):
                clipped.append(p + (q - p) * (inside_p / (inside_p - inside_q)))
        polygon = clipped
        if not polygon:
            return 0.0
    return abs(signed_area(np.array(polygon))) / abs(float(normal[dropped])) if len(polygon) > 2 else 0.0


def triangles_have_area(asset: Asset) -> check.Measurement:
    """VIS001: number of triangles without area."""
    meshes = {pointer: visual.mesh for pointer, _, visual in check.visuals_of(asset)}
    areas = {pointer: face_normals(m.vertices, m.faces.astype(np.int64))[1] for pointer, m in meshes.items()}
    counts = {pointer: int((area <= 0).sum()) for pointer, area in areas.items()}
    if not counts:
        return check.not_applicable(check.NO_VISUALS)
    problems = tuple((p, f"{n} triangles have no area; leave them out") for p, n in counts.items() if n)
    return check.Measurement(float(sum(counts.values())), problems)


def normals_face_outwards(asset: Asset, limit: float) -> check.Measurement:
    """VIS002: share of a mesh's area whose normals point against its front."""
    shares, problems = [], []
    for pointer, _, visual in check.visuals_of(asset):
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
    return check.largest(shares, problems, "none of its meshes carries normals")


def closed_parts_wind_outwards(asset: Asset, limit: float) -> check.Measurement:
    """VIS003: share of a link's surface on closed parts that wind inwards."""
    shares = {f"links/{link.name}/visuals": _inverted_share(link) for link in asset.links if link.visuals}
    message = "{:.1%} of the surface is inside out; turn those triangles"
    return check.all_at_most(shares, limit, message, check.NO_VISUALS)


def triangle_count_is_bounded(asset: Asset, limit: float) -> check.Measurement:
    """VIS004: number of visible triangles."""
    triangles = sum(len(v.mesh.faces) for _, _, v in check.visuals_of(asset))
    if not triangles:
        return check.not_applicable(check.NO_VISUALS)
    return check.at_most(float(triangles), limit, "", f"has {triangles} triangles; simplify it further")


def textured_meshes_are_unwrapped(asset: Asset) -> check.Measurement:
    """VIS005: number of meshes with a picture but without usable texture coordinates."""
    textured = {m.id for m in asset.materials if m.textures}
    visuals = [(pointer, v) for pointer, _, v in check.visuals_of(asset) if v.material in textured]
    if not visuals:
        return check.not_applicable(NO_PICTURES)
    message = "shows a picture, but all its texture coordinates are missing or one point; unwrap it or drop the picture"
    problems = []
    for pointer, visual in visuals:
        uv = visual.mesh.uv
        if uv is None or not np.isfinite(uv).all() or not float(np.ptp(uv, axis=0).max(initial=0.0)) > 0:
            problems.append((pointer, message))
    return check.count(problems)


def texture_size_is_bounded(asset: Asset, limit: float) -> check.Measurement:
    """VIS006: longest side of a picture according to its file, pixels."""
    sides, problems = [], []
    for material in asset.materials:
        for texture in material.textures:
            # From the header of the file. Ref: PNG 1.2, the first chunk is IHDR.
            size = (int.from_bytes(texture.png[16:20], "big"), int.from_bytes(texture.png[20:24], "big"))
            sides.append(float(max(size)))
            pointer = f"materials/{material.id}/{texture.name}"
            if size != (texture.width_px, texture.height_px):
                problems.append((pointer, f"is {size[0]} x {size[1]} pixels, not as stated; read its size again"))
            if max(size) > limit:
                problems.append((pointer, f"is {size[0]} x {size[1]} pixels; scale it down"))
    return check.largest(sides, problems, NO_PICTURES)


def meshes_have_enough_vertices(asset: Asset) -> check.Measurement:
    """VIS007: least number of vertices of a mesh."""
    counts = {pointer: len(v.mesh.vertices) for pointer, _, v in check.visuals_of(asset)}
    message = f"has {{}} vertices, MuJoCo asks for {MIN_VERTICES}; join it to another mesh"
    return check.all_at_least(counts, MIN_VERTICES, message, check.NO_VISUALS)


def meshes_are_unique(asset: Asset) -> check.Measurement:
    """VIS008: number of meshes that lie exactly on another one."""
    if not any(link.visuals for link in asset.links):
        return check.not_applicable(check.NO_VISUALS)
    first: dict[bytes, str] = {}
    problems = []
    for pointer, link, visual in check.visuals_of(asset):
        twin = first.setdefault(_triangle_key(visual, asset.asset_from_link(link.name)), pointer)
        if twin != pointer:
            problems.append((pointer, f"is the same mesh in the same place as {twin}; leave one out"))
    return check.count(problems)


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
    vertices, faces = check.merged_mesh(link.visuals)
    points, welded = weld(vertices)
    faces = welded[faces]
    _, areas = face_normals(points, faces)
    if areas.sum() <= 0:
        return 0.0
    return float(areas[inside_out_faces(points, faces)].sum() / areas.sum())
