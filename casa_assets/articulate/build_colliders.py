"""Build the collision shapes of every link of an articulated mesh, within a budget and clear of each other."""

from __future__ import annotations

from collections.abc import Sequence, Set

import numpy as np

from casa_assets.articulate.link_shapes import (
    LinkSolid,
    box_cloud,
    clear_moving_parts,
    convex_clouds,
    fit_shape,
    hull_closes_opening,
    is_frame,
    overlap,
    snap_to_box,
    subtract_box,
)
from casa_assets.articulate.plan import Articulation, PartKind, PartPlan
from casa_assets.articulate.segment.fragments import WeldedMesh
from casa_assets.core.numeric import Floats, Ints
from casa_assets.mesh.solid.deviation import surface_samples
from casa_assets.mesh.solid.solids import hull_volume
from casa_assets.model.asset.parts import Collider, JointKind
from casa_assets.model.pose import Pose

# Parts that are opened by their edge where they have no handle.
OPENING_KINDS = frozenset({PartKind.DOOR, PartKind.DRAWER, PartKind.LID})
# Size of the strip that fingers take, across the edge and behind it; shapes end at one edge within the last.
GRIP_WIDTH_M, GRIP_THICKNESS_M, EDGE_TOLERANCE_M = 0.02, 0.03, 0.01
# Smaller strips are too small to hold.
MIN_GRIP_M3 = 1e-7
# Most collision shapes of a link (Ref: registry/limits.yaml, hull_count), and before cuts, which may split one; those
# of the body that are left for the floors of slots, which come when an asset gets its runtime names.
MAX_SHAPES, MAX_SHAPES_BEFORE_CUTS, RESERVED_SHAPES = 32, 22, 4
# Most collision shapes of a handle before those that _cover_extremes adds.
MAX_HANDLE_SHAPES = 6
# Fewest shapes that are kept of the mesh's own faces where a built interior adds shapes to a link.
MIN_OWN_SHAPES = 14
# Owners of the faces of the body (Ref: Articulation.face_owner), and of built interiors, which bring their own shapes.
BODY_OWNER, BUILT_OWNER = -1, -2
# A fragment gets no shape of its own if it reaches out of the boxes of earlier shapes by no more than this, metres, or
# that share of the diagonal of the faces that are covered.
REACH_M, REACH_SHARE = 0.004, 0.012
# Samples of the visible surface of a link.
SURFACE_SAMPLES = 30000
# Of a ring-like fragment: most shapes if it reaches farthest to a side, and fewest, one for each side of its opening.
# A fragment is tested for it if it is longer than this share of the faces that are covered.
MAX_END_SHAPES, FRAME_SIDES, LARGE_FRAME_SHARE = 12, 4, 0.4
# Most fragments of a link that get shapes, the largest first.
MAX_FRAGMENTS = 60
# Parts that are pressed or turned by fingers have one shape.
SINGLE_SHAPE_KINDS = frozenset({PartKind.KNOB, PartKind.BUTTON})
# A knob that turns round and round gets a shape narrower by this share than it is seen, so that the corners of one that
# is not quite round pass the hole that it is set in. A choice: 1 mm on a knob of 40 mm.
SPIN_PLAY_SHARE = 0.05
# Labels of visuals and colliders that differ from the name of the kind of part.
_LABELS = {PartKind.TRAY: "rack"}


def add_edge_grip(solid: LinkSolid, kind: PartKind) -> None:
    """Make the strip along the opening edge of a front without a handle its grip; in place.

    Args:
        solid: with its joint, metres, z up, the front faces -y.
    """
    if kind not in OPENING_KINDS or solid.grips or not solid.clouds or solid.axis is None or solid.anchor is None:
        return
    lower, upper = (np.array([f(c, axis=0) for c in solid.clouds]) for f in (np.min, np.max))
    edge, sign = _edge(solid, lower.min(axis=0), upper.max(axis=0))
    # Of a drawer it is the front that is taken, or a lip of it, not a side of its box.
    first = np.ones(len(lower), dtype=bool) if solid.turns else lower[:, 1] <= lower[:, 1].min() + EDGE_TOLERANCE_M
    reach = sign * (upper if sign > 0 else lower)[:, edge]
    rows = np.flatnonzero(first & (reach >= reach[first].max() - EDGE_TOLERANCE_M))
    chosen = min(rows.tolist(), key=lambda i: (-round(hull_volume(solid.clouds[i]), 9), i))
    end = sign * float(reach[chosen])
    box = np.array([lower[chosen], upper[chosen]])
    wide = min(GRIP_WIDTH_M, 0.3 * float(box[1][edge] - box[0][edge]))
    box[0 if sign > 0 else 1][edge] = end - sign * wide
    # Neither the axis of its edge nor the one that the edge runs along.
    along = int(np.argmax(np.abs(solid.axis)))
    thin = next(k for k in (1, 2, 0) if k not in (edge, along)) if solid.turns else 1
    # The side that is seen: of a lid the upper one.
    if box[1][thin] - box[0][thin] > GRIP_THICKNESS_M:
        box[1 if thin != 2 else 0][thin] = (
            box[0][thin] + GRIP_THICKNESS_M if thin != 2 else box[1][thin] - GRIP_THICKNESS_M
        )
    strip = overlap(solid.clouds[chosen], box_cloud(box[0], box[1]), MIN_GRIP_M3)
    if strip is not None:
        solid.grips = [strip]
        solid.clouds[chosen : chosen + 1] = subtract_box(solid.clouds[chosen], box) or [solid.clouds[chosen]]


def _edge(solid: LinkSolid, lower: Floats, upper: Floats) -> tuple[int, float]:
    """Return the axis and side of the edge that opens: opposite the hinge, or the upper one of what slides."""
    assert solid.axis is not None
    assert solid.anchor is not None
    if not solid.turns:
        return 2, 1.0
    away = (lower + upper) / 2 - solid.anchor
    away = away - solid.axis * float(away @ solid.axis)
    axis = int(np.argmax(np.round(np.abs(away), 6)))
    return axis, 1.0 if away[axis] > 0 else -1.0


def part_label(kind: PartKind) -> str:
    """Return the label of the visuals and colliders of a part."""
    return _LABELS.get(kind, kind.value)


def build_colliders(
    points: Floats, mesh: WeldedMesh, articulation: Articulation, substance: str, refit: Set[int] = frozenset()
) -> tuple[list[tuple[Collider, ...]], list[int | None]]:
    """Return the colliders of the body and of each part, in the frames of their links.

    Also returns, for each part, the index of the part that must be open before it can move, or None.

    Args:
        points: (P, 3) of the mesh, metres, asset frame.
        substance: of all shapes.
        refit: links, 0 for the body, whose shapes are fitted to the link as a whole and are never cut: those that
            follow its fragments, or were cut where others pass, did not fit what is seen.
    """
    metres_per_unit = articulation.frame.metres or 1.0
    owner = articulation.face_owner(len(mesh.faces))
    names = [p.name for p in articulation.parts]
    blocking_parts = [_front_before(p, articulation.parts, mesh) for p in articulation.parts]
    for added in articulation.added:
        owner[added.faces] = BUILT_OWNER
    solids = [_link_solid(points, mesh, np.flatnonzero(owner == BODY_OWNER), None)]
    for i, part in enumerate(articulation.parts):
        solid = _link_solid(points, mesh, np.flatnonzero(owner == i), part)
        door = blocking_parts[i]
        solid.carrier = names.index(part.parent) + 1 if part.parent else 0
        solid.is_whole = part.kind in SINGLE_SHAPE_KINDS
        solid.blocking_link = None if door is None else door + 1
        solids.append(solid)
    for i in sorted(refit):
        rows = np.flatnonzero(owner == (BODY_OWNER if i == 0 else i - 1))
        if len(rows):
            # Its shapes do not follow its fragments, but all its faces together.
            solids[i].clouds = convex_clouds(points, mesh.faces[rows], MAX_SHAPES_BEFORE_CUTS)
            solids[i].is_whole = True
    # Of the analysed mesh, in the asset frame.
    origin = points[0] - mesh.points[0] * metres_per_unit if len(points) else np.zeros(3)
    _set_joints(solids, articulation, origin, metres_per_unit)
    _add_interiors(solids, articulation, origin, metres_per_unit)
    for i, solid in enumerate(solids):
        solid.clouds = [snap_to_box(c) for c in solid.clouds]
        # Link 0 is the body; link i is part i - 1.
        own_faces = mesh.faces[owner == (BODY_OWNER if i == 0 else i - 1)]
        solid.skin = surface_samples(points, own_faces, SURFACE_SAMPLES) if len(own_faces) else None
    clear_moving_parts(solids)
    for solid, part in zip(solids[1:], articulation.parts, strict=True):
        add_edge_grip(solid, part.kind)
    out = []
    for i, solid in enumerate(solids):
        origin = np.zeros(3) if solid.anchor is None else solid.anchor
        kind = None if i == 0 else articulation.parts[i - 1].kind
        name = "object" if i == 0 else names[i - 1]
        out.append(_colliders(solid, origin, name, kind, substance))
    return out, blocking_parts


def _set_joints(
    solids: Sequence[LinkSolid], articulation: Articulation, origin: Floats, metres_per_unit: float
) -> None:
    """Set the joint of each link but the body, asset frame; in place."""
    for solid, part in zip(solids[1:], articulation.parts, strict=True):
        joint = part.joint
        solid.turns = joint.kind is JointKind.HINGE
        solid.axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
        solid.anchor = np.array(joint.anchor) * metres_per_unit + origin
        solid.spins = joint.endless
        if solid.spins and solid.is_whole:
            solid.clouds = [_narrowed(c, solid.anchor, solid.axis) for c in solid.clouds]
        solid.is_behind_front = part.kind is PartKind.TRAY
        solid.max_travel = float(joint.range[1]) * (1.0 if solid.turns else metres_per_unit)


def _narrowed(cloud: Floats, anchor: Floats, axis: Floats) -> Floats:
    """Return a cloud that is SPIN_PLAY_SHARE nearer to an axis, and as long along it."""
    away = cloud - anchor
    away -= np.outer(away @ axis, axis)
    return cloud - SPIN_PLAY_SHARE * away


def _largest(clouds: Sequence[Floats], max_count: int) -> list[Floats]:
    """Return the largest shapes, and those that reach farthest, because a gripper touches the outermost first."""
    ranked = sorted(range(len(clouds)), key=lambda i: (-round(hull_volume(clouds[i]), 12), i))
    if len(ranked) <= max_count:
        return [clouds[i] for i in ranked]
    lower, upper = (np.array([f(clouds[i], axis=0) for i in ranked]) for f in (np.min, np.max))
    ends = {ranked[int(k)] for k in (*np.argmin(np.round(lower, 6), axis=0), *np.argmax(np.round(upper, 6), axis=0))}
    kept = [*(i for i in ranked if i in ends), *(i for i in ranked if i not in ends)][:max_count]
    return [clouds[i] for i in ranked if i in kept]


def _add_interiors(
    solids: Sequence[LinkSolid], articulation: Articulation, origin: Floats, metres_per_unit: float
) -> None:
    """Add the shapes of built interiors to their links, and subtract the cavities from the body; in place."""
    names = [p.name for p in articulation.parts]
    # An interior that is neither cut out of the body nor furnished leaves the shapes of the body as they are.
    for cavity in (r for r in articulation.cavities if r.built and (r.cut is not None or r.furnish)):
        for hole in (cavity.cut or (cavity.lower, cavity.upper), *cavity.fronts):
            box = np.array(hole) * metres_per_unit + origin
            solids[0].clouds = [piece for c in solids[0].clouds for piece in subtract_box(c, box)]
    for added in articulation.added:
        solid = solids[names.index(added.part) + 1 if added.part else 0]
        own = _largest(solid.clouds, max(MIN_OWN_SHAPES, MAX_SHAPES_BEFORE_CUTS - len(added.clouds)))
        solid.clouds = [*own, *(c * metres_per_unit + origin for c in added.clouds)]


def _link_solid(points: Floats, mesh: WeldedMesh, rows: Ints, part: PartPlan | None) -> LinkSolid:
    """Return the shapes of one link before any cut.

    Args:
        rows: indices of its faces. part: None for the body.
    """
    rows = rows[mesh.fragment_labels[rows] >= 0]
    if part is not None and part.kind is PartKind.TRAY and len(rows):
        # One shape for each wire of a rack would exceed the budget, so the rack is covered as a whole.
        return LinkSolid(None, convex_clouds(points, mesh.faces[rows], MAX_SHAPES_BEFORE_CUTS), [])
    # A part that is gripped at any of its faces, such as a lever, has no separate handle.
    has_handle = part is not None and len(part.grip) < len(part.faces)
    in_handle = np.isin(rows, part.grip) if part is not None and has_handle else np.zeros(len(rows), dtype=bool)
    if part is not None and part.kind in SINGLE_SHAPE_KINDS and len(rows):
        return LinkSolid(None, convex_clouds(points, mesh.faces[rows], 1), [])
    handle = _cover_fragments(points, mesh, rows[in_handle], MAX_HANDLE_SHAPES)
    return LinkSolid(None, _cover_fragments(points, mesh, rows[~in_handle], MAX_SHAPES_BEFORE_CUTS), handle)


def _cover_fragments(points: Floats, mesh: WeldedMesh, rows: Ints, max_count: int) -> list[Floats]:
    """Return shapes that cover some faces, fragment by fragment, the largest first.

    Shapes of the fragments that reach farthest to a side come on top of `max_count`; `_largest` cuts the shapes of a
    link to MAX_SHAPES in the end.
    """
    if not len(rows):
        return []
    areas = np.bincount(mesh.fragment_labels[rows], mesh.areas[rows])
    ranked = np.argsort(-areas, kind="stable")[: int((areas > 0.0).sum())][:MAX_FRAGMENTS]
    extent = np.ptp(points[np.unique(mesh.faces[rows])], axis=0)
    reach = max(REACH_M, REACH_SHARE * float(np.linalg.norm(extent)))
    out: list[Floats] = []
    boxes: list[Floats] = []
    for n, fragment in enumerate(ranked.tolist()):
        faces = mesh.faces[rows[mesh.fragment_labels[rows] == fragment]]
        cloud = points[np.unique(faces)]
        if any((cloud >= b[0] - reach).all() and (cloud <= b[1] + reach).all() for b in boxes):
            continue
        budget = max_count - len(out)
        if budget <= 0:
            break
        # Leave one shape for each fragment that follows, but at most half of the budget for all of them.
        share = max(1, budget - min(len(ranked) - n - 1, budget // 2))
        is_large = float(np.ptp(points[np.unique(faces)], axis=0).max()) > LARGE_FRAME_SHARE * float(extent.max())
        if share < FRAME_SIDES and is_large and hull_closes_opening(points, faces):
            # With fewer shapes than sides its opening would be closed, so it gets one for each side, or none.
            if budget < FRAME_SIDES:
                continue
            share = FRAME_SIDES
        clouds = convex_clouds(points, faces, share)[:budget]
        out += clouds
        boxes += [np.array([c.min(axis=0), c.max(axis=0)]) for c in clouds]
    return out + _cover_extremes(points, mesh, rows, out, reach)


def _cover_extremes(points: Floats, mesh: WeldedMesh, rows: Ints, clouds: list[Floats], reach: float) -> list[Floats]:
    """Return shapes for fragments left out of `clouds` that reach farthest: a gripper touches the outermost first."""
    corners = points[mesh.faces[rows]]
    lower, upper = (np.array([f(c, axis=0) for c in clouds]) for f in (np.min, np.max))
    wanted: list[int] = []
    for axis in range(3):
        at = corners[..., axis]
        if at.min() < lower[:, axis].min() - reach:
            wanted.append(int(mesh.fragment_labels[rows[np.argmin(at.min(axis=1))]]))
        if at.max() > upper[:, axis].max() + reach:
            wanted.append(int(mesh.fragment_labels[rows[np.argmax(at.max(axis=1))]]))
    reached = [mesh.faces[rows[mesh.fragment_labels[rows] == fragment]] for fragment in sorted(set(wanted))]
    return [
        c for faces in reached for c in convex_clouds(points, faces, MAX_END_SHAPES if is_frame(points, faces) else 1)
    ]


def _front_before(part: PartPlan, parts: Sequence[PartPlan], mesh: WeldedMesh) -> int | None:
    """Return the index of the door or drawer in front of a rack, turntable or drawer, or None.

    A drawer behind the front of another one comes out once that one is open. x is right, y back, z up.
    """
    if part.kind not in (PartKind.TRAY, PartKind.DRAWER) or part.parent:
        return None
    points = mesh.points[mesh.faces[part.faces].reshape(-1)]
    lower, upper = points.min(axis=0), points.max(axis=0)
    middle = (lower + upper) / 2
    for i, front in enumerate(parts):
        if front is part or front.kind not in (PartKind.DOOR, PartKind.DRAWER) or front.parent:
            continue
        front_points = mesh.points[mesh.faces[front.faces].reshape(-1)]
        front_lower, front_upper = front_points.min(axis=0), front_points.max(axis=0)
        # A drawer reaches back as far as what is behind its front, which lies within its outline as a whole.
        is_drawer = front.kind is PartKind.DRAWER
        first, last = (lower, upper) if is_drawer else (middle, middle)
        if (
            front_lower[1] < lower[1]
            and (is_drawer or front_upper[1] < middle[1])
            and all(front_lower[k] <= first[k] and last[k] <= front_upper[k] for k in (0, 2))
        ):
            return i
    return None


def _colliders(
    solid: LinkSolid, anchor: Floats, name: str, kind: PartKind | None, substance: str
) -> tuple[Collider, ...]:
    """Return the colliders of a link in its frame; those of the handle come first, under its name.

    Args:
        anchor: origin of the frame of the link. name: of the link. kind: of the part, None for the body.
    """
    body_clouds = _largest(solid.clouds, MAX_SHAPES - (RESERVED_SHAPES if kind is None else len(solid.grips)))
    groups = (
        (solid.grips, f"{name}_handle_main", "handle"),
        (body_clouds, f"{name}_main", None if kind is None else part_label(kind)),
    )
    out: list[Collider] = []
    for clouds, prefix, collider_label in groups:
        for n, cloud in enumerate(clouds):
            shape, pose = fit_shape(cloud - anchor)
            at = Pose(position=pose.position)
            collider_name = prefix if not n else f"{prefix}_{n:02d}"
            out.append(Collider(name=collider_name, shape=shape, pose=at, substance=substance, label=collider_label))
    return tuple(out)
