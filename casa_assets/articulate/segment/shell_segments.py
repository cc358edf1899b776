"""Segment a shell that is one connected piece: find the fronts and small protrusions that are parts of it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.fronts.front_hypotheses import find_fronts
from casa_assets.articulate.fronts.relief import (
    FrontRectangle,
    rectangle_corners,
)
from casa_assets.articulate.interior.inner_parts import find_drawer_box
from casa_assets.articulate.plan import Models
from casa_assets.articulate.segment.cutting import CutPlane
from casa_assets.articulate.segment.fragments import WeldedMesh
from casa_assets.articulate.segment.orthographic import (
    BACK,
    BOTTOM,
    FRONT,
    LEFT,
    RIGHT,
    SIDES,
    TOP,
    DepthImage,
    SideRelief,
    dilate,
    measure_relief,
    render_depth,
)
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.surface import connected_groups

# A shell that may hold fused parts is a fragment with these shares of all surface, of each extent, and of what is
# visible from the front. A body whose parts are fragments of their own is visible only between them.
MIN_SHELL_AREA, MIN_SHELL_EXTENT, MIN_SHELL_VISIBLE = 0.55, 0.6, 0.5
# An object with fronts is boxy: this share of what is visible, from all sides, faces along an axis within 12 degrees.
# Ref: of fused appliances and cabinets 0.64 to 0.97; of fruit, bottles, mugs, bowls and toys 0.07 to 0.60.
MIN_BOXINESS, AXIS_ALIGNED_COS = 0.62, 0.978
# Thickness of a front whose back is not visible, and greatest thickness, in diagonals and as a share of the depth.
USUAL_THICKNESS, MAX_THICKNESS, MAX_THICKNESS_OF_DEPTH = 0.022, 0.06, 0.15
# A visible back is at least this share of the surface near a front.
MIN_BACK_SHARE = 0.15
# Surfaces behind a front that move with it keep this far within it, diagonals, and have this area, square diagonals.
BEHIND_MARGIN, MIN_AREA_BEHIND = 0.004, 0.002
# Protrusions are cut off this far before their ground, diagonals.
CUT_DISTANCE = 0.0015
# Protrusions of two sides are one thing where they share this much of the surface of the smaller.
SAME_THING_SHARE = 0.5
# Triangles of a protrusion keep within this of its outline, diagonals.
OUTLINE_TOLERANCE = 0.006


@dataclass(frozen=True)
class KnownFronts:
    """Fragments that are fronts.

    Attributes:
        chances: the probability that each is a front. boxes: the fragment behind each that is the box of a drawer.
    """

    chances: Mapping[int, float]
    boxes: Mapping[int, int]

    def chance_of(self, fragments: Iterable[int]) -> float | None:
        """Return the highest probability of some fragments, None if none of them is known."""
        return max((self.chances[f] for f in fragments if f in self.chances), default=None)


NO_FRONTS = KnownFronts({}, {})


@dataclass(frozen=True)
class FusedShell:
    """A shell with the fronts and protrusions that are to be cut out of it.

    Attributes:
        mine: (F,) faces of the shell. shown: (F,) those visible from the front. skin: (F,) those visible from other
            sides.
        front, top: views of it. fronts: each a rectangle and the depth of its back.
        chances: probability that each front is one.
        things: indices of the protrusions of the front view, and of the top view, that belong to that side.
    """

    mine: Mask
    shown: Mask
    skin: Mask
    front: SideRelief
    top: SideRelief
    fronts: tuple[tuple[FrontRectangle, float], ...]
    chances: tuple[float, ...] = ()
    things: tuple[tuple[int, ...], tuple[int, ...]] = ((), ())


@dataclass(frozen=True)
class Fragmentation:
    """A mesh in its frame, split into fragments once for all stages that need them.

    Attributes:
        mesh: a diagonal of 1. shell: the connected piece that holds fused parts, None if each part is a piece.
        labels: (F,) fragment of each face, -1 for none; those of the mesh, and new ones for what is taken from a shell.
        fronts: what is known of the fragments that are fronts of the shell.
    """

    mesh: WeldedMesh
    shell: FusedShell | None
    labels: Ints
    fronts: KnownFronts = NO_FRONTS


def fragment_mesh(mesh: WeldedMesh, label: Ints, models: Models) -> Fragmentation:
    """Split a mesh that is in its frame into fragments, along existing triangle edges.

    Args:
        label: (F,) fragment of each face, of which a shell is split further.
        models: what was learned from labelled cases.
    """
    shell = find_shell(mesh, label, models)
    if shell is None:
        return Fragmentation(mesh, shell, label)
    return Fragmentation(mesh, shell, *_split_shell(shell, mesh, label))


def _split_shell(shell: FusedShell, mesh: WeldedMesh, label: Ints) -> tuple[Ints, KnownFronts]:
    """Return the (F,) fragment labels of a mesh with the parts of its shell as separate fragments, and their fronts."""
    zone = shell_zones(shell, mesh, np.arange(len(label)))
    fresh = int(label.max()) + 1
    number = np.cumsum(np.bincount(zone[zone >= 0], minlength=1) > 0) - 1
    out = np.where(zone >= 0, fresh + number[np.maximum(zone, 0)], label)
    groups, boxes = _groups_behind(shell, mesh, zone)
    for group in groups:
        out[group] = int(out.max()) + 1
    box_of = {}
    for i, box in boxes.items():
        box_of[fresh + int(number[i])] = int(out.max()) + 1
        out[box] = int(out.max()) + 1
    present = np.unique(zone[zone >= 0])
    chances = {fresh + int(number[i]): chance for i, chance in enumerate(shell.chances) if i in present}
    return out, KnownFronts(chances, box_of)


def find_shell(mesh: WeldedMesh, label: Ints, models: Models) -> FusedShell | None:
    """Find the one fragment of a mesh that holds several fused parts; None if each part is its own fragment."""
    mine = _shell_faces(mesh, label)
    if not mine.any():
        return None
    side_images = [render_depth(mesh.points, mesh.faces, SIDES[side], 256) for side in (BACK, LEFT, RIGHT, BOTTOM)]
    front, top = measure_relief(mesh, FRONT), measure_relief(mesh, TOP)
    seen = front.image.face[front.image.face >= 0]
    if (
        not len(seen)
        or float(mine[seen].mean()) < MIN_SHELL_VISIBLE
        or boxiness(mesh, [front.image, top.image, *side_images]) < MIN_BOXINESS
    ):
        return None
    visible = np.zeros(len(label), dtype=bool)
    visible[seen] = True
    flat, depth = _face_middles(mesh, FRONT)
    found = find_fronts(mesh, front, FRONT, (models.fronts_alone, models.fronts))
    fronts = []
    for rectangle, _ in found:
        inside = mine & _in_rectangle(front, rectangle, flat)
        fronts.append((rectangle, rectangle.plane + _thickness(mesh, inside, flat[:, 2] - rectangle.plane, depth)))
    skin = np.zeros(len(label), dtype=bool)
    for image in side_images:
        skin[image.face[image.face >= 0]] = True
    things = _things_by_side(mesh, mine, front, top)
    return FusedShell(mine, visible, skin, front, top, tuple(fronts), tuple(chance for _, chance in found), things)


def _things_by_side(
    mesh: WeldedMesh, mine: Mask, front: SideRelief, top: SideRelief
) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return the indices of the protrusions of the front and of the top without those that belong to the other side.

    A knob of the front, seen from above, protrudes from a surface far below it: it belongs to the side from which it
    protrudes less.
    """
    zones = []
    for side, view in ((FRONT, front), (TOP, top)):
        zone = np.full(len(mine), -1, dtype=np.int64)
        _number_blobs(zone, mine, view, mesh, side, 0, range(len(view.blobs)))
        zones.append(zone)
    kept = [list(range(len(view.blobs))) for view in (front, top)]
    both = np.flatnonzero((zones[0] >= 0) & (zones[1] >= 0))
    area = [np.bincount(zone[zone >= 0], mesh.areas[zone >= 0]) for zone in zones]
    for i, k in sorted(set(zip(zones[0][both].tolist(), zones[1][both].tolist(), strict=True))):
        if i not in kept[0] or k not in kept[1]:
            continue
        shared = float(mesh.areas[both[(zones[0][both] == i) & (zones[1][both] == k)]].sum())
        if shared >= SAME_THING_SHARE * min(float(area[0][i]), float(area[1][k])):
            if front.blobs[i].protrusion <= top.blobs[k].protrusion:
                kept[1].remove(k)
            else:
                kept[0].remove(i)
    return tuple(kept[0]), tuple(kept[1])


def shell_cut_planes(shell: FusedShell, mesh: WeldedMesh, chosen: Sequence[int]) -> list[CutPlane]:
    """Return cut planes around and behind each chosen front, and under each chosen protrusion.

    Args:
        chosen: numbers of zones, as `zones` gives them.
    """
    nearest = float((mesh.points @ SIDES[FRONT][2]).min())
    out = []
    for rectangle, back in (shell.fronts[i] for i in chosen if i < len(shell.fronts)):
        a, b = rectangle_corners(shell.front, rectangle)
        lower, upper = np.append(a, nearest - 1.0), np.append(b, nearest + back)
        out += [CutPlane(FRONT, axis, float(end[axis]), lower, upper) for axis in (0, 1) for end in (lower, upper)]
        out.append(CutPlane(FRONT, 2, nearest + back, lower, upper))
    first = len(shell.fronts)
    for side, view in ((FRONT, shell.front), (TOP, shell.top)):
        nearest = float((mesh.points @ SIDES[side][2]).min())
        for number, blob in enumerate(view.blobs):
            if first + number in chosen:
                rim = 3 * view.image.pixel
                lower, upper = np.append(blob.lower - rim, nearest), np.append(blob.upper + rim, nearest)
                out.append(CutPlane(side, 2, nearest + _cut_depth(view, number), lower, upper))
        first += len(view.blobs)
    return out


def shell_zones(shell: FusedShell, mesh: WeldedMesh, parent: Ints) -> Ints:
    """Return the (F',) zone of each face: fronts first, then protrusions of the front, then of the top; -1 for none.

    Args:
        mesh: that of the shell, or cut. parent: (F',) face of the shell's mesh that each face is part of.
    """
    free = shell.mine[parent]
    out = np.full(len(parent), -1, dtype=np.int64)
    flat, depth = _face_middles(mesh, FRONT)
    falls = min(MAX_THICKNESS, MAX_THICKNESS_OF_DEPTH * depth)
    for i, (rectangle, back) in enumerate(shell.fronts):
        inside = free & _in_rectangle(shell.front, rectangle, flat)
        # A bulging front falls off towards its edges.
        out[inside & ((flat[:, 2] <= back) | (shell.shown[parent] & (flat[:, 2] <= rectangle.plane + falls)))] = i
    first = len(shell.fronts)
    front, top = shell.things
    plain = out < 0
    _number_blobs(out, free, shell.front, mesh, FRONT, first, front)
    _number_blobs(out, free & plain & (out < 0), shell.top, mesh, TOP, first + len(shell.front.blobs), top)
    return out


def _groups_behind(shell: FusedShell, mesh: WeldedMesh, zone: Ints) -> tuple[list[Ints], dict[int, Ints]]:
    """Return groups of faces behind fronts, each connected: walls and shelves; and the box behind a front, by front."""
    flat, _ = _face_middles(mesh, FRONT)
    groups: list[Ints] = []
    boxes: dict[int, Ints] = {}
    for i, (rectangle, _) in enumerate(shell.fronts):
        lower, upper = rectangle_corners(shell.front, rectangle)
        hidden = shell.mine & ~shell.skin & (zone < 0)
        outside, inside = (
            ((flat[:, :2] >= lower + margin) & (flat[:, :2] <= upper - margin)).all(axis=1)
            for margin in (-BEHIND_MARGIN, BEHIND_MARGIN)
        )
        box = find_drawer_box(mesh, flat, np.flatnonzero(hidden & outside), lower, upper)
        if len(box):
            boxes[i] = box
        else:
            rows = np.flatnonzero(hidden & inside)
            groups += [g for g in _connected_groups(mesh, rows) if float(mesh.areas[g].sum()) >= MIN_AREA_BEHIND]
    return groups, boxes


def _face_middles(mesh: WeldedMesh, side: int) -> tuple[Floats, float]:
    """Return the (F, 3) middles of faces as right, up and depth from the nearest point; and the whole depth."""
    flat = mesh.points[mesh.faces].mean(axis=1) @ SIDES[side].T
    depth = mesh.points @ SIDES[side][2]
    flat[:, 2] -= float(depth.min())
    return flat, float(np.ptp(depth))


def _in_rectangle(front: SideRelief, rectangle: FrontRectangle, flat: Floats) -> Mask:
    """Mark the (F,) faces whose middle is in a rectangle, at any depth."""
    row, column = front.image.rows_columns(flat[:, :2])
    found: Mask = (row >= rectangle.rows[0]) & (row < rectangle.rows[1])
    return found & (column >= rectangle.columns[0]) & (column < rectangle.columns[1])


def _shell_faces(mesh: WeldedMesh, label: Ints) -> Mask:
    """Mark the (F,) faces of the piece that makes up most of the object; no faces if there is no such piece."""
    alive = label >= 0
    none: Mask = np.zeros(len(label), dtype=bool)
    if not alive.any():
        return none
    area = np.bincount(label[alive], mesh.areas[alive])
    largest = int(np.argmax(area))
    mine: Mask = label == largest
    points = mesh.points[mesh.faces[mine]].reshape(-1, 3)
    whole = np.ptp(mesh.points, axis=0)
    large = bool((np.ptp(points, axis=0) >= MIN_SHELL_EXTENT * whole).all())
    return mine if large and area[largest] >= MIN_SHELL_AREA * area.sum() else none


def _thickness(mesh: WeldedMesh, inside: Mask, behind: Floats, depth: float) -> float:
    """Return the thickness of a front: up to its back where that is visible, else a usual value; diagonals."""
    max_thickness = min(MAX_THICKNESS, MAX_THICKNESS_OF_DEPTH * depth)
    facing = mesh.normals @ SIDES[FRONT][2] > 0.8
    rows = np.flatnonzero(inside & facing & (behind > 0.004) & (behind < max_thickness))
    min_area = MIN_BACK_SHARE * float(mesh.areas[inside & (behind < max_thickness)].sum())
    if not len(rows) or float(mesh.areas[rows].sum()) < min_area:
        return min(USUAL_THICKNESS, max_thickness)
    order = rows[np.argsort(behind[rows], kind="stable")]
    total_area = np.cumsum(mesh.areas[order])
    return float(behind[order[np.searchsorted(total_area, 0.9 * total_area[-1])]]) + 0.002


def boxiness(mesh: WeldedMesh, views: Sequence[DepthImage]) -> float:
    """Return the share of the visible area that faces along an axis, over all given views."""
    along = np.abs(mesh.normals).max(axis=1) > AXIS_ALIGNED_COS
    area = [(float((v.face >= 0).sum()), float(along[v.face[v.face >= 0]].sum()), v.pixel**2) for v in views]
    return sum(a * p for _, a, p in area) / max(sum(n * p for n, _, p in area), 1e-12)


def _connected_groups(mesh: WeldedMesh, rows: Ints) -> list[Ints]:
    """Group faces that share points; each group is ascending, and tiny groups are dropped."""
    if not len(rows):
        return []
    used, local = np.unique(mesh.faces[rows], return_inverse=True)
    local = local.reshape(-1, 3)
    ends = np.concatenate([local[:, [0, 1]], local[:, [1, 2]]])
    of_face = connected_groups(len(used), *ends.T)[local[:, 0]]
    return [rows[of_face == k] for k in range(int(of_face.max()) + 1) if (of_face == k).sum() >= 12]


def _cut_depth(view: SideRelief, number: int) -> float:
    """Return the depth at which a protrusion is cut off: a little before the ground that it hides."""
    ground = float(np.median(view.base[view.blob == number]))
    return ground - min(CUT_DISTANCE, 0.3 * view.blobs[number].protrusion)


def _number_blobs(
    out: Ints, free: Mask, view: SideRelief, mesh: WeldedMesh, side: int, first: int, chosen: Sequence[int]
) -> None:
    """Number the faces of each protrusion in `out`, from `first` on.

    Long triangles that reach from it far over the ground get -1, since they belong to neither: they would make both
    larger than they are.
    """
    if not chosen:
        return
    corners_ = mesh.points[mesh.faces] @ SIDES[side].T
    corners_[:, :, 2] -= float((mesh.points @ SIDES[side][2]).min())
    middle = corners_.mean(axis=1)
    row, column = view.image.rows_columns(middle[:, :2])
    nearest = corners_[:, :, 2].min(axis=1)
    for number in chosen:
        blob = view.blobs[number]
        rows = slice(max(0, blob.rows[0] - 2), blob.rows[1] + 2)
        columns = slice(max(0, blob.columns[0] - 2), blob.columns[1] + 2)
        mask = np.zeros(view.blob.shape, dtype=bool)
        mask[rows, columns] = dilate(view.blob[rows, columns] == number, 1)
        foot = _cut_depth(view, number)
        rim = max(OUTLINE_TOLERANCE, 3 * view.image.pixel)
        within = ((corners_[:, :, :2] >= blob.lower - rim) & (corners_[:, :, :2] <= blob.upper + rim)).all(axis=(1, 2))
        mine = free & mask[row, column] & (middle[:, 2] < foot)
        out[mine & within] = first + number
        near = ((middle[:, :2] >= blob.lower - rim) & (middle[:, :2] <= blob.upper + rim)).all(axis=1)
        out[free & near & ~(mine & within) & (nearest < foot - 0.4 * blob.protrusion)] = -1
