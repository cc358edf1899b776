"""Bring faces and pictures to a bounded size, and make materials portable; sheets are given backs."""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt
from opengl_decimate import CollapseSequence, SimplifyOptions, collapse_sequence
from PIL import Image

from casa_assets.core.numeric import Floats, Ints, Mask, linear_from_srgb_array
from casa_assets.ingest.draft import Draft, warning
from casa_assets.mesh.solid.deviation import Visibility, measure_visibility
from casa_assets.mesh.surface import (
    connected_groups,
    directed_edges,
    edge_counts,
    face_components,
    merge_rows,
    picked,
    with_normals,
)
from casa_assets.model.asset.material import Material, Substance, Texture
from casa_assets.model.asset.parts import Mesh
from casa_assets.model.registry.category import Category, MatterFill
from casa_assets.model.source import RawPart

# Largest error of the simplified surface, as a part of the mesh's extent.
TARGET_ERROR = 0.01
# The same while every seam of the texture keeps its line. Where that would cost more, as it does with a texture of many
# small pieces, points may also leave a seam; each side still keeps its own texture coordinates.
SEAM_ERROR = 0.005
# Share of the visible samples of a component that show its back, from which on it is a sheet; a choice.
MIN_BACK_SHARE = 0.05
# Pixels along the legs of a triangle's patch in a painted texture; the last one is margin. A choice.
PATCH_PX = 6
# Alpha up to which a surface is invisible; a choice.
INVISIBLE = 0.02


def simplify(draft: Draft, limit: int) -> Draft:
    """Bring faces down to about `limit`, each part by its share; points and texture coordinates are those of parts."""
    before = sum(len(p.mesh.faces) for p in draft.parts)
    if before <= limit:
        return draft
    parts = tuple(
        p.replace(mesh=simplified(p.mesh, max(12, int(len(p.mesh.faces) * limit / before)))) for p in draft.parts
    )
    after = sum(len(p.mesh.faces) for p in parts)
    note = warning("MSH015", "faces", f"simplified from {before} to {after} faces")
    return draft.replace(parts=parts, notes=draft.noted(note))


def simplified(mesh: Mesh, target: int) -> Mesh:
    """The mesh with about `target` faces (more where the error bound forbids it), over points that it has."""
    vertices, attributes, corners = _distinct(mesh)
    front, back = _sides(merge_rows(attributes["POSITION"])[1][corners])
    if not len(front):
        return mesh
    share = len(front) / (len(front) + np.count_nonzero(back >= 0))
    sequence, steps = _collapses(attributes, corners[front], max(1, int(target * share)))
    left = (sequence.removed_at < 0) | (sequence.removed_at >= steps)
    places, values = _ends(sequence, steps, corners[front], left)
    twin = back[left] >= 0
    point = sequence.vertex_point.astype(np.int64)
    behind = _vertices_behind(corners, point, front[back >= 0], back[back >= 0])
    places = np.concatenate([places, behind[places[twin]][:, ::-1]])
    values = np.concatenate([values, behind[values[twin]][:, ::-1]])
    return _mesh_of(mesh, vertices[places], vertices[values])


def _collapses(attributes: dict[str, Floats], corners: Ints, count: int) -> tuple[CollapseSequence, int]:
    """Collapses of edges to one of their ends, and how many of them leave `count` faces or what the bound allows."""
    ways = ((True, SEAM_ERROR), (False, TARGET_ERROR))
    for lock_seams, bound in ways if "TEXCOORD_0" in attributes else ways[1:]:
        options = SimplifyOptions(target_ratio=1.0, placement="endpoint", lock_seams=lock_seams)
        sequence = collapse_sequence(attributes, corners.ravel(), options)
        steps = sequence.steps_for(target_count=count, target_error=bound)
        if sequence.triangles_after(steps) <= count:
            break
    return sequence, steps


def _ends(sequence: CollapseSequence, steps: int, corners: Ints, left: Mask) -> tuple[Ints, Ints]:
    """Vertices that give corners their place, and those that give them everything else.

    The library gives a corner the vertex with the most similar texture coordinates at the place. Where pieces of the
    texture lie close to each other, that may be one of another piece, and the face would show all that lies in between.
    So of the vertices that a corner can be moved to along edges that have collapsed, without crossing a seam, it gets
    the one nearest to its new place.

    `corners`: (F, 3) vertices of the faces at the beginning. `left`: (F,) faces left. Returns (G, 3) of those, twice.
    """
    _, roots, faces, moved = sequence.state(steps)
    places = moved.astype(np.int64)
    if "TEXCOORD_0" not in sequence.attributes:
        return places, places
    at, point = sequence.attributes["POSITION"], sequence.vertex_point
    _, side = merge_rows(np.column_stack([point, sequence.attributes["TEXCOORD_0"]]))
    cluster = roots[point]
    edges = directed_edges(corners)
    edges = side[edges[cluster[edges[:, 0]] == cluster[edges[:, 1]]]]
    reach = connected_groups(int(side.max()) + 1, edges[:, 0], edges[:, 1])[side]
    end = np.zeros((len(roots), 3))
    end[faces] = at[places]
    order = np.lexsort((((at - end[cluster]) ** 2).sum(axis=1), reach))
    nearest = order[np.flatnonzero(np.diff(reach[order], prepend=-1))][reach[corners[left]]]
    values = np.where(side[places] == side[nearest], places, nearest)
    return np.where(point[values] == point[places], values, places), values


def _mesh_of(mesh: Mesh, places: Ints, values: Ints) -> Mesh:
    """Faces of the given (F, 3) vertices, one of which gives the place of a corner and one everything else."""
    pairs, index = np.unique(np.stack([values.ravel(), places.ravel()], axis=1), axis=0, return_inverse=True)
    return picked(mesh, pairs[:, 0], index.reshape(-1, 3)).replace(vertices=mesh.vertices[pairs[:, 1]])


def _distinct(mesh: Mesh) -> tuple[Ints, dict[str, Floats], Ints]:
    """Vertices without those equal to an earlier one.

    Returns:
        (N,) vertices; their attributes as glTF names them, lengths as parts of the extent; (F, 3) corners over these.
    """
    used = mesh.vertices[mesh.faces]
    low = used.min(axis=(0, 1))
    extent = max(float((used.max(axis=(0, 1)) - low).max()), 1e-30)
    places = np.round((mesh.vertices - low) / extent, 7)
    carried = {"TEXCOORD_0": mesh.uv, "NORMAL": mesh.normals, "COLOR_0": mesh.colors}
    values = {name: np.round(array.astype(np.float64), 6) for name, array in carried.items() if array is not None}
    first, place = merge_rows(np.column_stack([places, *values.values()]))
    attributes = {"POSITION": places[first]} | {name: array[first] for name, array in values.items()}
    return first, attributes, place[mesh.faces.astype(np.int64)]


def _sides(ids: Ints) -> tuple[Ints, Ints]:
    """(N,) faces with three different points, each once, and the face behind each that looks the other way, or -1.

    A sheet with faces in both directions has four faces at each edge, over which nothing could collapse.
    """
    ordered = np.sort(ids, axis=1)
    rows = np.flatnonzero((ordered[:, 1:] != ordered[:, :-1]).all(axis=1))
    first, place = merge_rows(ordered[rows].astype(np.float64))
    after_lowest = (ids[rows].argmin(axis=1) + 1) % 3
    forward = np.take_along_axis(ids[rows], after_lowest[:, None], axis=1)[:, 0] == ordered[rows, 1]
    back = np.full(len(first), -1, dtype=np.int64)
    reverse = np.flatnonzero(forward != forward[first][place])[::-1]  # of several the first is written last
    back[place[reverse]] = rows[reverse]
    return rows[first], back


def _vertices_behind(corners: Ints, point: Ints, front: Ints, back: Ints) -> Ints:
    """(N,) for each vertex, the vertex of a face behind at its place; the vertex itself if there is no such face."""
    found = np.arange(len(point))
    ahead, behind = (
        np.take_along_axis(corners[rows], np.argsort(point[corners[rows]], axis=1), axis=1) for rows in (front, back)
    )
    found[ahead.ravel()[::-1]] = behind.ravel()[::-1]
    return found


def add_back_faces(draft: Draft, category: Category, missing_share: float) -> Draft:
    """Add reversed copies of the faces of open components whose backs are visible, after all stages that measure.

    Something solid that lacks a side, from which more than `missing_share` of its outline shows backs, is left as it
    is, since nobody looks into an apple.
    """
    points, ids = draft.surface.points, draft.surface.welded_faces
    visibility = measure_visibility(points, ids)
    if category.build in (MatterFill.SOLID, MatterFill.FILLED) and float(visibility.behind.max()) > missing_share:
        return draft
    needs_backs = _sheets(ids, len(points), visibility)
    if not needs_backs.any():
        return draft
    parts, start = [], 0
    for part in draft.parts:
        rows = needs_backs[start : start + len(part.mesh.faces)]
        parts.append(part.replace(mesh=_with_backs(part.mesh, rows)) if rows.any() else part)
        start += len(rows)
    message = f"{needs_backs.mean():.0%} of the faces belong to sheets that are seen from both sides"
    note = warning("MSH060", "faces", f"{message}; they have two sides now")
    return draft.replace(parts=tuple(parts), notes=draft.noted(note))


def _sheets(ids: Ints, count: int, visibility: Visibility) -> Mask:
    """(F,) faces of open components that show their backs."""
    component = face_components(ids, count)
    ends, uses, _ = edge_counts(ids)
    component_of_point = np.zeros(count, dtype=np.int64)
    component_of_point[ids] = component[:, None]
    is_open = np.zeros(int(component.max()) + 1, dtype=bool)
    is_open[component_of_point[ends[uses == 1, 0]]] = True
    component_of_sample, total = component[visibility.face], len(is_open)
    seen_count = np.bincount(component_of_sample[visibility.front | visibility.back], minlength=total)
    back_count = np.bincount(component_of_sample[visibility.back], minlength=total)
    return np.asarray((is_open & (back_count > MIN_BACK_SHARE * np.maximum(seen_count, 1)))[component])


def _with_backs(mesh: Mesh, rows: Mask) -> Mesh:
    """The mesh with reversed copies of some of its faces added; the copies use separate vertices."""
    complete = mesh if mesh.normals is not None else with_normals(mesh)
    assert complete.normals is not None
    used, local = np.unique(complete.faces[rows], return_inverse=True)
    back_faces = local.reshape(-1, 3)[:, ::-1] + len(complete.vertices)
    rows_of_all = np.concatenate([np.arange(len(complete.vertices)), used])
    out = picked(complete, rows_of_all, np.concatenate([complete.faces, back_faces]))
    return out.replace(normals=np.concatenate([complete.normals, -complete.normals[used]]), colors=None)


def texture(draft: Draft, largest_px: int, substance: Substance) -> Draft:
    """Make materials portable, pictures no larger than `largest_px`, and parts of one look one; substance's shine."""
    notes = []
    parts = []
    for part in draft.parts:
        mesh, material = part.mesh, part.material
        if mesh.colors is not None and int(mesh.colors[:, 3].max(initial=0)) <= INVISIBLE * 255:
            mesh = mesh.replace(colors=np.column_stack([mesh.colors[:, :3], np.full(len(mesh.colors), 255)]))
            notes.append(warning("MSH018", part.name, "fully transparent vertex colours were made opaque"))
        if mesh.colors is not None and material.base_color_texture is None:
            colors = mesh.colors
            if int(np.ptp(colors.astype(np.int64), axis=0).max()) > 2:
                mesh, material = painted(mesh, material)
                notes.append(warning("MSH016", part.name, "vertex colours were painted into a texture"))
            else:
                *rgb, alpha = colors[0].astype(np.float64) / 255
                linear = linear_from_srgb_array(np.array(rgb))
                r, g, b = (float(x * y) for x, y in zip(material.base_color[:3], linear, strict=True))
                material = material.replace(base_color=(r, g, b, float(material.base_color[3] * alpha)))
        if mesh.uv is None and material.textures:
            material = material.replace(base_color_texture=None, metallic_roughness_texture=None, normal_texture=None)
            message = "a texture without uv coordinates cannot be shown and was left out"
            notes.append(warning("MSH017", part.name, message))
        if material.base_color[3] <= INVISIBLE:
            material = material.replace(base_color=(*material.base_color[:3], 1.0))
            notes.append(warning("MSH018", part.name, "a fully transparent material was made opaque"))
        has_default_shine = material.metallic == 1.0 and material.roughness == 1.0
        if has_default_shine and material.metallic_roughness_texture is None:
            # Exporters leave glTF's defaults, fully metallic and fully rough, for materials that are neither.
            material = material.replace(metallic=substance.metallic, roughness=substance.roughness)
        material = _with_bounded_textures(material, largest_px)
        mesh = mesh.replace(uv=mesh.uv if material.textures else None, colors=None)
        parts.append(part.replace(mesh=mesh, material=material))
    return draft.replace(parts=_merged(parts), notes=draft.noted(*notes))


def painted(mesh: Mesh, material: Material) -> tuple[Mesh, Material]:
    """Vertex colours as a texture: two triangles share a square patch; each face gets three separate vertices."""
    assert mesh.colors is not None
    count = len(mesh.faces)
    columns = max(1, int(np.ceil(np.sqrt((count + 1) // 2))))
    rows = -(-((count + 1) // 2) // columns)
    side = PATCH_PX + 2
    width, height = columns * side, rows * side
    face_index = np.arange(count)
    column, row = (face_index // 2) % columns, (face_index // 2) // columns
    lower, upper = 1.0, PATCH_PX + 0.0
    corners_px = np.array(
        [
            [[lower, lower], [upper - 1, lower], [lower, upper - 1]],
            [[upper, upper], [lower + 1, upper], [upper, lower + 1]],
        ]
    )
    corner_px = corners_px[face_index % 2] + np.stack([column, row], axis=1)[:, None] * side
    colors = mesh.colors[mesh.faces].astype(np.float64)
    pixels = np.zeros((rows * columns, side, side, 4))
    pixels[..., 3] = 255  # unused pixels must not make the picture transparent
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="xy"), axis=-1).astype(np.float64)
    for half in (0, 1):
        faces_of_half = face_index[face_index % 2 == half]
        weights = _barycentric(grid, corners_px[half])
        is_inside = grid.sum(axis=-1) < side if half == 0 else grid.sum(axis=-1) >= side
        filled = np.einsum("ijk,nkc->nijc", weights, colors[faces_of_half])
        pixels[faces_of_half // 2] = np.where(is_inside[None, :, :, None], filled, pixels[faces_of_half // 2])
    canvas = pixels.reshape(rows, columns, side, side, 4).transpose(0, 2, 1, 3, 4).reshape(height, width, 4)
    image = np.clip(np.rint(canvas), 0, 255).astype(np.uint8)
    uv = np.stack([(corner_px[..., 0] + 0.5) / width, 1 - (corner_px[..., 1] + 0.5) / height], axis=-1)
    corner_vertices = mesh.faces.ravel()
    out = picked(mesh, corner_vertices, np.arange(3 * count).reshape(-1, 3)).replace(uv=uv.reshape(-1, 2), colors=None)
    png = png_bytes(Image.fromarray(image if (image[..., 3] < 255).any() else image[..., :3]))
    texture_of_colors = Texture(name="painted", png=png, width_px=width, height_px=height)
    return out, material.replace(base_color_texture=texture_of_colors)


def _barycentric(grid: npt.NDArray[np.float64], legs: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """(H, W, 3) weights of the corners at each pixel, clipped into the triangle so that the margin repeats its edge."""
    a, b, c = legs
    basis = np.linalg.inv(np.stack([b - a, c - a], axis=1))
    uv = (grid - a) @ basis.T
    weights = np.clip(np.concatenate([1 - uv.sum(axis=-1, keepdims=True), uv], axis=-1), 0, None)
    normed: npt.NDArray[np.float64] = weights / weights.sum(axis=-1, keepdims=True)
    return normed


def png_bytes(image: Image.Image) -> bytes:
    """PNG with fixed options and no metadata: the same pixels are the same bytes."""
    out = io.BytesIO()
    image.save(out, format="PNG", optimize=False, compress_level=6)
    return out.getvalue()


def _with_bounded_textures(material: Material, largest_px: int) -> Material:
    slots = ("base_color_texture", "metallic_roughness_texture", "normal_texture")
    pictures = {slot: getattr(material, slot) for slot in slots}
    large = {s: p for s, p in pictures.items() if p is not None and max(p.width_px, p.height_px) > largest_px}
    return material.replace(**{slot: _shrunk(picture, largest_px) for slot, picture in large.items()})


def _shrunk(image: Texture, largest_px: int) -> Texture:
    ratio = largest_px / max(image.width_px, image.height_px)
    size = (max(1, round(image.width_px * ratio)), max(1, round(image.height_px * ratio)))
    with Image.open(io.BytesIO(image.png)) as pixels:
        small = pixels.resize(size, Image.Resampling.LANCZOS)
    return image.replace(png=png_bytes(small), width_px=size[0], height_px=size[1])


def _merged(parts: list[RawPart]) -> tuple[RawPart, ...]:
    """Parts whose materials look the same become one mesh, in order of first use."""
    groups: dict[tuple[str, bool, bool], list[RawPart]] = {}
    for part in parts:
        appearance = part.material.replace(id="same").digest
        groups.setdefault((appearance, part.mesh.uv is not None, part.mesh.normals is not None), []).append(part)
    out = []
    for group in groups.values():
        if len(group) == 1:
            out.append(group[0])
            continue
        starts = np.cumsum([0] + [len(p.mesh.vertices) for p in group[:-1]])
        uvs = [p.mesh.uv for p in group if p.mesh.uv is not None]
        normals = [p.mesh.normals for p in group if p.mesh.normals is not None]
        mesh = Mesh(
            vertices=np.concatenate([p.mesh.vertices for p in group]),
            faces=np.concatenate([p.mesh.faces + s for p, s in zip(group, starts, strict=True)]),
            uv=np.concatenate(uvs) if uvs else None,
            normals=np.concatenate(normals) if normals else None,
        )
        out.append(group[0].replace(mesh=mesh))
    return tuple(out)
