"""Round things that are controls or burners: the single button on a front, burners and their caps on a top."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from casa_assets.articulate.controls.controls import Control, find_controls, has_round_outline
from casa_assets.articulate.fronts.panels import find_panels
from casa_assets.articulate.plan import JointPlan, round_mm, round_mm_vec3, to_vec3
from casa_assets.articulate.segment.fragments import FRONT, SIDES, MeasuredFragments
from casa_assets.articulate.segment.orthographic import outline_area
from casa_assets.core.numeric import Mask
from casa_assets.model.asset.asset import Asset
from casa_assets.model.asset.parts import JointKind, Mesh

# Burners --------------------------------------------------------------------------------------------------------------
# Find the burners of a hob or range: round discs on its top, each named by its place.

# Diameters of burners and rings, metres: from the cap of a simmer burner to the ring of a large zone.
MIN_DIAMETER_M, MAX_DIAMETER_M = 0.035, 0.34
# The smallest burner is at least this share of the largest.
MIN_SIZE_OF_LARGEST = 0.3
# Burners lie within this of the median level of the discs; higher ones are guards at the back.
MAX_LEVEL_DIFFERENCE_M = 0.09
# Outline of a disc: its sides differ by at most this share (that of a hexagon), its area from that of its ellipse by
# the second.
MAX_SIDE_DIFFERENCE, ROUNDNESS_TOLERANCE = 0.16, 0.09
# A burner within this share of the span from the middle of rows or columns is in the middle one.
MIDDLE_SHARE = 0.2
PLACES = frozenset(
    {"rear_left", "rear_center", "rear_right", "front_left", "front_center", "front_right", "center", "left", "right"}
)


@dataclass(frozen=True)
class Burner:
    """A burner: its place, the middle of its top and its radius; metres, asset frame."""

    loc: str
    middle: tuple[float, float, float]
    radius: float


def find_burners(asset: Asset) -> tuple[Burner, ...]:
    """Return the burners on the top of the body; empty if fewer than two are found or their places are ambiguous."""
    found: list[tuple[float, float, float, float]] = []
    discs = [d for v in asset.root.visuals for d in _discs(v.mesh)]
    for disc in sorted(discs, key=lambda d: (-round(d[3], 5), d[0], d[1])):
        # Of discs that lie above each other the widest, so that none is within another.
        if all(np.hypot(disc[0] - o[0], disc[1] - o[1]) > 0.8 * (o[3] + 0.5 * disc[3]) for o in found):
            found.append(disc)
    if not found:
        return ()
    top = float(np.median([z for _, _, z, _ in found]))
    found = [f for f in found if abs(f[2] - top) <= MAX_LEVEL_DIFFERENCE_M]
    if not found:
        return ()
    widest = max(r for _, _, _, r in found)
    found = sorted(f for f in found if f[3] >= MIN_SIZE_OF_LARGEST * widest)
    points = np.concatenate([v.mesh.vertices for v in asset.root.visuals])
    burners = []
    columns, rows = _thirds([f[0] for f in found]), _thirds([f[1] for f in found])
    for (x, y, z, r), column, row in zip(found, columns, rows, strict=True):
        words = [w for w in (("front", "", "rear")[row], ("left", "center", "right")[column]) if w]
        near = np.linalg.norm(points[:, :2] - (x, y), axis=1) <= 0.9 * r
        upper = points[near & (points[:, 2] <= top + MAX_LEVEL_DIFFERENCE_M), 2]
        level = float(upper.max()) if len(upper) else z  # of a mere ring the rim
        burners.append(Burner("_".join(words), round_mm_vec3((x, y, level)), round_mm(r)))
    names = [b.loc for b in burners]
    if len(burners) < 2 or len(set(names)) < len(names) or not set(names) <= PLACES:
        return ()
    return tuple(burners)


def burner_faces(mesh: Mesh, burner: Burner, below: float = 0.03) -> Mask:
    """Mark the (F,) faces of a mesh of the body that belong to a burner: those within its circle near its top."""
    corners = mesh.vertices[mesh.faces]
    away = np.linalg.norm(corners[..., :2] - np.array(burner.middle[:2]), axis=2)
    near = (away <= 1.06 * burner.radius).all(axis=1)
    return np.asarray(near & (np.abs(corners[..., 2] - burner.middle[2]) <= below).all(axis=1))


def _discs(mesh: Mesh) -> list[tuple[float, float, float, float]]:
    """Return the middle, top and radius of connected pieces of a mesh whose outline from above is a circle."""
    vertices = np.asarray(mesh.vertices)
    grid = np.round(vertices / 1e-5).astype(np.int64)
    _, same = np.unique(grid, axis=0, return_inverse=True)
    same = same.reshape(-1)
    faces = same[np.asarray(mesh.faces, dtype=np.int64)]
    count = int(same.max()) + 1
    ends = np.concatenate([faces[:, :2], faces[:, 1:]])
    link = coo_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
    number, label = connected_components(link, directed=False)
    of = label[same]
    order = np.argsort(of, kind="stable")
    pieces = np.split(order, np.cumsum(np.bincount(of, minlength=number))[:-1])
    out = []
    for piece in pieces:
        points = vertices[piece]
        if len(points) < 8:
            continue
        lower, upper = points.min(axis=0), points.max(axis=0)
        wide = (upper - lower)[:2]
        if (
            not MIN_DIAMETER_M <= wide.max() <= MAX_DIAMETER_M
            or wide.max() - wide.min() > MAX_SIDE_DIFFERENCE * wide.max()
            or upper[2] - lower[2] > 0.6 * wide.max()
        ):
            continue
        # The outline of a circle, or of a polygon with six corners or more.
        if abs(outline_area(points[:, :2]) / (np.pi / 4 * float(np.prod(wide))) - 1.0) > ROUNDNESS_TOLERANCE:
            continue
        middle = (lower + upper) / 2
        out.append((float(middle[0]), float(middle[1]), float(upper[2]), float(wide.max()) / 2))
    return out


def _thirds(values: Sequence[float]) -> list[int]:
    """Sort values into 0, 1 or 2: low, middle, high; all in the middle where they do not differ."""
    lower, upper = min(values), max(values)
    if upper - lower < MIN_DIAMETER_M:
        return [1] * len(values)
    share = [(v - lower) / (upper - lower) - 0.5 for v in values]
    return [1 if abs(s) < MIDDLE_SHARE else 0 if s < 0 else 2 for s in share]


# Round controls -------------------------------------------------------------------------------------------------------
# Tell round buttons from other round things: the single button on a front, and burner caps on a top.

# Width of a single button, diagonals (a ring around a button is wider than a button), its least protrusion, and its
# most by its width.
MAX_BUTTON_WIDTH, MIN_PROTRUSION, MAX_PROTRUSION_BY_WIDTH = 0.22, 0.004, 0.6

# Burner caps are surrounded by slim arms that bear pans: fewest arms, their length to width, and their distance from
# the cap by its width. The knobs of an object are alike: from so many knobs on its front on, a round control of another
# width on the top is none.
MIN_PAN_SUPPORT_ARMS, MIN_ARM_RATIO, MAX_ARM_GAP_BY_WIDTH, MIN_FRONT_KNOBS, KNOB_WIDTH_TOLERANCE = 3, 4.0, 0.5, 2, 0.25


def drop_burner_caps(over: Sequence[Control], top: Sequence[Control], front: Sequence[Control]) -> list[Control]:
    """Return the round things on the top that may be knobs without the caps of burners.

    All controls of the top and of the front are looked at.
    """
    knobs = [float(c.across.max()) for c in front if c.is_round and c.protrusion >= MIN_PROTRUSION]
    usual = float(np.median(knobs)) if len(knobs) >= MIN_FRONT_KNOBS else 0.0
    alike = [c for c in over if not usual or abs(float(c.across.max()) - usual) <= KNOB_WIDTH_TOLERANCE * usual]
    found = []
    for cap in alike:
        away = [bar.middle - cap.middle for bar in top if _is_arm(cap, bar)]
        ways = {int(np.round(np.arctan2(y, x) / (np.pi / 2))) % 4 for x, y in away}  # right, up, left, down
        if len(ways) < MIN_PAN_SUPPORT_ARMS:
            found.append(cap)
    return found


def _is_arm(cap: Control, bar: Control) -> bool:
    """Return whether something slim begins at the rim of a cap, or nearly."""
    if bar.long < MIN_ARM_RATIO:
        return False
    middle = cap.middle
    nearest = np.clip(middle, bar.lower[:2], bar.upper[:2])
    away = float(np.linalg.norm(nearest - middle)) / float(cap.across.max())
    return 0.0 < away <= 0.5 + MAX_ARM_GAP_BY_WIDTH


def find_single_button(measured: MeasuredFragments) -> Control | None:
    """Return what is round on a front, where there is one such thing and no more."""
    found = [c for c in find_controls(measured, FRONT, []) if c.is_round]
    taken = {f for c in found for f in c.fragments}
    for panel in find_panels(measured):
        across = (panel.upper - panel.lower)[:2]
        own = sorted(panel.members)
        if (
            taken.isdisjoint(own)
            and float(across.max()) <= MAX_BUTTON_WIDTH
            and has_round_outline(measured, FRONT, own, across)
        ):
            found.append(Control(own, panel.lower, panel.upper, float(panel.upper[2] - panel.lower[2]), True))
    standing = [c for c in found if MIN_PROTRUSION <= c.protrusion <= MAX_PROTRUSION_BY_WIDTH * float(c.across.max())]
    return standing[0] if len(standing) == 1 else None


def button_joint(key: Control, way: float) -> JointPlan:
    """Return the joint of a push button, with a travel of `way` diagonals at most."""
    return JointPlan(
        kind=JointKind.SLIDE,
        axis=to_vec3(SIDES[FRONT][2]),
        anchor=to_vec3((key.lower + key.upper) / 2 @ SIDES[FRONT]),
        range=(0.0, min(way, 0.5 * key.protrusion)),
        confidence=0.45,
        reason="round, and all that stands out of its front",
    )
