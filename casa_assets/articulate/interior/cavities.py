"""Find the cavities behind the fronts of an object: those that its mesh has, and those that have to be built."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.interior.cavity_probe import CavityProbe, fit_cavity, make_probe
from casa_assets.articulate.plan import Articulation, Cavity, HingeEdge, InteriorKind, PartKind, PartPlan, to_vec3
from casa_assets.articulate.segment.fragments import WeldedMesh
from casa_assets.articulate.segment.orthographic import RayCrossings, sample_grid
from casa_assets.core.numeric import Floats

# A hollow shell without inner walls, or a solid block, gets a cavity as large as its front and the depth allow.
# Lines across a front, each way, and the share of its size that they leave free at the border.
CAVITY_LINES_PER_SIDE, LINE_INSET_SHARE = 9, 0.12
# Least depth behind a front for a cavity, diagonals.
MIN_CAVITY_DEPTH = 0.06
# A closed body has a wall within this share of the depth behind the front, over this share of the lines.
NEAR_WALL_SHARE, MIN_CLOSED_SHARE = 0.15, 0.6
# A wall that is met from behind may lie this deep.
REAR_WALL_SHARE = 0.4
# Distance of an opening cut into the front wall of a cavity from its other walls, diagonals.
CUT_MARGIN = 0.003
# A cavity that would be smaller along any axis is not built, metres. A choice: nothing is put into less.
MIN_BUILT_M = 0.03
# A mesh has a cavity of its own if this many of its five walls are visible.
MIN_WALLS = 3
# A drawer that reaches back by this share of the depth has a box.
MIN_BOX_DEPTH_SHARE = 0.25
# Two doors meet if their gap is at most this, diagonals, and their heights overlap by this share.
MAX_DOOR_GAP, MIN_HEIGHT_OVERLAP = 0.025, 0.9
# Thickness of the walls that are built around a cavity, metres. Ref: insulation and boards as in kitchenware/parts.
WALL_M = {
    InteriorKind.OVEN: 0.036,
    InteriorKind.MICROWAVE: 0.018,
    InteriorKind.REFRIGERATOR: 0.04,
    InteriorKind.DISHWASHER: 0.024,
    InteriorKind.CABINET: 0.016,
    InteriorKind.PLAIN: 0.012,
    InteriorKind.DRAWER: 0.008,
}
# Words of a category and the interior that they stand for.
_KINDS = (
    (("microwave",), InteriorKind.MICROWAVE),
    (("refrigerator", "fridge", "freezer", "cooler"), InteriorKind.REFRIGERATOR),
    (("dishwasher",), InteriorKind.DISHWASHER),
    (("oven", "range", "stove"), InteriorKind.OVEN),
    (("cabinet", "island", "sink_base", "drawer_stack", "sideboard", "wardrobe", "cupboard"), InteriorKind.CABINET),
)


@dataclass(frozen=True)
class FrontOpening:
    """The opening that one or two fronts close, in the frame.

    Attributes:
        parts: that close it; the cavity of a drawer is its own inside. part_ids: their places in the list of parts.
        lower, upper: corners of their panels. mouth: depth at which the body begins behind them.
    """

    parts: tuple[PartPlan, ...]
    part_ids: tuple[int, ...]
    lower: Floats
    upper: Floats
    mouth: float


def find_cavities(mesh: WeldedMesh, articulation: Articulation, category: str) -> tuple[Cavity, ...]:
    """Return the cavities behind the doors and drawers that the body carries.

    Args:
        mesh: in the frame, cut where the thing was one shell. articulation: its parts.
        category: id where it is known, empty otherwise.
    """
    if not articulation.parts:
        return ()
    probe = make_probe(mesh, articulation.parts)
    metres = articulation.frame.metres or 1.0
    interior = interior_kind_of(articulation, category)
    out = []
    for opening in _openings(probe, articulation, interior):
        is_drawer = opening.parts[0].kind is PartKind.DRAWER
        out.append((_drawer_cavity if is_drawer else _door_cavity)(probe, opening, interior, metres))
    return tuple(cavity for cavity in out if cavity is not None)


def interior_kind_of(articulation: Articulation, category: str) -> InteriorKind:
    """Return the kind of interior of an object: by its category, else by its moving parts."""
    for words, interior in _KINDS:
        if any(w in category for w in words):
            return interior
    if category:
        return InteriorKind.PLAIN
    doors = [p for p in articulation.parts if p.kind is PartKind.DOOR and not p.parent]
    knobs = sum(p.kind is PartKind.KNOB for p in articulation.parts)
    if len(doors) == 1 and doors[0].joint.edge is HingeEdge.BOTTOM and knobs >= 2:
        return InteriorKind.OVEN
    return InteriorKind.PLAIN if knobs else InteriorKind.CABINET


def _openings(probe: CavityProbe, articulation: Articulation, interior: InteriorKind) -> list[FrontOpening]:
    """Return the openings that fronts close; a pair of doors that meet in the middle closes one."""
    panels = []
    for i, part in enumerate(articulation.parts):
        if part.parent or part.kind not in (PartKind.DOOR, PartKind.DRAWER) or not len(part.faces):
            continue
        lower, upper = probe.panel_box_of(i)
        doors = [
            probe.panel_box_of(k)
            for k, p in enumerate(articulation.parts)
            if k != i and p.kind is PartKind.DOOR and not p.parent
        ]
        # A drawer behind a door.
        if part.kind is PartKind.DRAWER and any(
            float(a[0]) - MAX_DOOR_GAP <= lower[0] and float(b[0]) + MAX_DOOR_GAP >= upper[0] and float(b[1]) < lower[1]
            for a, b in doors
        ):
            continue
        panels.append((i, part, lower, upper))
    pairs: dict[int, int] = {}
    for i, a, lower, upper in panels:
        for j, b, low_b, high_b in panels:
            meet = i not in pairs.values() and _is_pair(a, b, (lower, upper), (low_b, high_b), interior, articulation)
            if meet and not probe.has_stile((i, j), (lower, upper), (low_b, high_b)):
                pairs[i] = j
    out = []
    for i, part, lower, upper in panels:
        if i in pairs.values():
            continue
        group = [(i, part, lower, upper), *(leaf for leaf in panels if leaf[0] == pairs.get(i))]
        part_ids = tuple(g[0] for g in group)
        a, b = np.min([g[2] for g in group], axis=0), np.max([g[3] for g in group], axis=0)
        out.append(FrontOpening(tuple(g[1] for g in group), part_ids, a, b, probe.mouth_depth(part_ids, a, b)))
    return out


def _is_pair(
    a: PartPlan,
    b: PartPlan,
    first: tuple[Floats, Floats],
    second: tuple[Floats, Floats],
    interior: InteriorKind,
    articulation: Articulation,
) -> bool:
    """Return whether two doors close one cavity: hinged outside, they meet in the middle."""
    if a.kind is not PartKind.DOOR or a.joint.edge is not HingeEdge.LEFT or b.joint.edge is not HingeEdge.RIGHT:
        return False
    # Of a fridge with no drawer the doors side by side are a freezer's and a fridge's.
    if interior is InteriorKind.REFRIGERATOR and not any(p.kind is PartKind.DRAWER for p in articulation.parts):
        return False
    over = min(first[1][2], second[1][2]) - max(first[0][2], second[0][2])
    tall = max(first[1][2] - first[0][2], second[1][2] - second[0][2])
    return bool(abs(second[0][0] - first[1][0]) <= MAX_DOOR_GAP and over >= MIN_HEIGHT_OVERLAP * tall)


def _lines_behind(probe: CavityProbe, opening: FrontOpening) -> RayCrossings:
    """Intersect lines through an opening with what is behind its fronts."""
    corners = opening.lower[[0, 2]], opening.upper[[0, 2]]
    return probe.cast_lines(1, sample_grid(*corners, CAVITY_LINES_PER_SIDE, LINE_INSET_SHARE), opening.part_ids)


def _door_cavity(probe: CavityProbe, opening: FrontOpening, interior: InteriorKind, metres: float) -> Cavity | None:
    """Return the cavity behind a door, or None if the depth behind it is too small."""
    lines = _lines_behind(probe, opening)
    behind = lines.select(lines.at > float(opening.lower[1]) + 0.002)
    back = probe.back_depth(behind, opening.mouth)
    depth = back - opening.mouth
    if depth < MIN_CAVITY_DEPTH:
        return None
    closing = _closing_wall_depth(behind, opening.mouth, depth)
    is_closed = closing is not None
    start = opening.mouth if closing is None else closing
    inner = behind.select(behind.at > start + 0.004)
    free = float(np.median(np.minimum(inner.first(), back)))
    walls, free_box = probe.visible_walls(opening.part_ids, opening.lower, opening.upper, start, free)
    names = tuple(p.name for p in opening.parts)
    if walls >= MIN_WALLS:
        cavity = _existing_cavity(names, interior, free_box, f"{walls} of 5 inner walls are there")
        if not is_closed:
            return cavity
        # A cavity that is closed at its front too: that alone is taken away.
        a, b = free_box[0] + CUT_MARGIN, free_box[1] - CUT_MARGIN
        cut = to_vec3([a[0], float(opening.lower[1]), a[2]]), to_vec3([b[0], start + CUT_MARGIN, b[2]])
        reason = f"{cavity.reason}, but the front is closed"
        return cavity.replace(built=True, cut=cut, furnish=False, reason=reason)
    reason = "the body is closed behind it" if is_closed else f"{walls} of 5 inner walls are there"
    confidence = 0.8 if is_closed or walls <= 1 else 0.6
    narrow = float((opening.upper - opening.lower)[[0, 2]].min())
    wall = min(WALL_M[interior] / metres, 0.1 * narrow, 0.2 * depth)
    panel_box = opening.lower, opening.upper
    mouth = max(opening.mouth, _body_start_depth(behind, opening.mouth, depth)) if is_closed else opening.mouth
    cavity = fit_cavity(probe, opening.part_ids, panel_box, mouth, back, wall, interior, is_closed)
    return _with_room(cavity.replace(parts=names, confidence=confidence, reason=reason), metres)


def _with_room(cavity: Cavity, metres: float) -> Cavity | None:
    """Return a cavity that is to be built, None where what surrounds it leaves no room."""
    room = np.subtract(cavity.upper, cavity.lower) * metres
    return cavity if float(room.min()) >= MIN_BUILT_M else None


def _closing_wall_depth(behind: RayCrossings, mouth: float, depth: float) -> float | None:
    """Return the depth of the wall that closes the body right behind a front, None if it is open.

    If a cavity has six walls, the back of its front wall is visible and may lie deeper.
    """
    rear = np.isin(behind.line, np.flatnonzero(behind.beyond(mouth, 1.0)[1]), invert=True)
    near = behind.select(
        (behind.at <= mouth + NEAR_WALL_SHARE * depth) | ((behind.at <= mouth + REAR_WALL_SHARE * depth) & rear)
    )
    last = near.last()
    seen = np.isfinite(last)
    return float(np.median(last[seen])) if float(seen.mean()) >= MIN_CLOSED_SHARE else None


def _body_start_depth(behind: RayCrossings, mouth: float, depth: float) -> float:
    """Return the depth at which a closed body begins right behind a front."""
    first = behind.select(behind.at <= mouth + NEAR_WALL_SHARE * depth).first()
    seen = first[np.isfinite(first)]
    return float(np.median(seen)) if len(seen) else mouth


def _existing_cavity(
    names: tuple[str, ...], interior: InteriorKind, corners: tuple[Floats, Floats], reason: str
) -> Cavity:
    """Return a cavity that the mesh has."""
    lower, upper = (to_vec3(c) for c in corners)
    return Cavity(
        parts=names,
        interior=interior,
        lower=lower,
        upper=upper,
        wall=0.0,
        outer=(lower, upper),
        built=False,
        confidence=0.7,
        reason=reason,
    )


def _drawer_cavity(probe: CavityProbe, opening: FrontOpening, _: InteriorKind, metres: float) -> Cavity | None:
    """Return the cavity of a drawer: the inside of its box, or one to be built behind its front."""
    lines = _lines_behind(probe, opening)
    front = probe.panel_back_depth(opening.part_ids, opening.lower, opening.upper)
    behind = lines.select(lines.at > front - 0.002)
    back = probe.back_depth(behind, front)
    depth = back - front
    if depth < MIN_CAVITY_DEPTH:
        return None
    box_reach = float(opening.upper[1]) - front
    names = tuple(p.name for p in opening.parts)
    if box_reach >= MIN_BOX_DEPTH_SHARE * depth:
        box = probe.drawer_space(opening.part_ids[0], front)
        if box is None:
            return None
        return _existing_cavity(names, InteriorKind.DRAWER, box, "it has a box")
    near = behind.select(behind.at <= opening.mouth + NEAR_WALL_SHARE * depth).first()
    is_closed = float(np.isfinite(near).mean()) >= MIN_CLOSED_SHARE
    wall = min(WALL_M[InteriorKind.DRAWER] / metres, 0.08 * float(opening.upper[2] - opening.lower[2]))
    reason = "the body is closed behind it" if is_closed else "there is no box behind it"
    panel_box = (opening.lower, np.array([opening.upper[0], front, opening.upper[2]]))
    mouth = max(opening.mouth, _body_start_depth(behind, front, depth)) if is_closed else opening.mouth
    cavity = fit_cavity(probe, opening.part_ids, panel_box, mouth, back, wall, InteriorKind.DRAWER, is_closed)
    # The box begins at its front, what it slides in where the body does.
    lower = (cavity.lower[0], front, cavity.lower[2])
    return _with_room(cavity.replace(parts=names, lower=lower, confidence=0.8, reason=reason), metres)
