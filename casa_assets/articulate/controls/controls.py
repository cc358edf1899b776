"""Find controls among the fragments: compact things that protrude from a side, such as knobs, buttons and pulls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.plan import PartKind
from casa_assets.articulate.segment.fragments import MeasuredFragments, corners_from_side
from casa_assets.articulate.segment.orthographic import SIDES, DepthImage, outline_area
from casa_assets.core.numeric import Floats, Ints, Mask
from casa_assets.mesh.surface import connected_groups

# Sizes in diagonals of the object. Ref: the articulation bench (docs/numbers.md), which also scores this: its 132 knobs
# and buttons are between 0.010 and 0.121 wide and long, but for one dial that is 0.258 long.
MIN_CONTROL_SIZE, MAX_CONTROL_SIZE = 0.006, 0.14
# A disc fills pi/4 of its square; a hull whose area differs by at most this share is round: that of an octagon that
# stands on a corner differs by 0.0997.
ROUNDNESS_TOLERANCE = 0.1
# A disc of cubes differs from a circle by so much more, by the edge of a cube over the width between outermost ones.
CUBE_ROUNDNESS_TOLERANCE = 0.5
MAX_KEY_RATIO = 5.0
# Least share of the surroundings of a control that is surface: a cap on an edge is surrounded by background.
MIN_GROUND_SHARE = 0.6
# Free space that fingers need around a control, by its width, and the share of it that may be blocked.
FINGER_ROOM_BY_WIDTH, MAX_BLOCKED_SHARE = 0.3, 0.08
# Length to width of a push pin. Ref: knobs of appliances reach 1.1, push pins start at 1.4.
MIN_PIN_RATIO = 1.3
# Protrusion to width from which a stick is too slender to be pushed.
MIN_STICK_RATIO = 4.0
# Something that is not round and has this many alike things apart from each other on it, each at most this share of it,
# is a plate with keys and no key itself.
MIN_KEYS_ON_PLATE, MAX_KEY_OF_PLATE = 4, 0.2
# A scale or a bezel around a control that stands out does not move with it: it protrudes by no more than this, in
# diagonals, and reaches beyond the outline of the control by at least this share of its width.
MAX_BEZEL_PROTRUSION, BEZEL_MARGIN = 0.002, 0.05
# A flat sheet is at most this thick, diagonals.
MAX_SHEET_THICKNESS = 0.0005
# A cap faces within 45 degrees of its side, its faces agree within 2 degrees, and it is this share of the visible area.
CAP_FACING_COS, CAP_FLAT_COS, MIN_CAP_SHARE = 0.707, 0.9994, 0.4
# A cap faces within 20 degrees of its ground: cones and bumpy shells have caps that do not.
CAP_PARALLEL_COS = 0.94
# Controls in a row of similar ones are classified alike, since on scans and voxelised shells not all knobs of a row
# look round, and some keys do. Fewest in a row, how much sizes differ, and the share of round ones in a row of knobs.
MIN_ROW_LENGTH, ROW_SIZE_TOLERANCE, MIN_ROUND_SHARE_OF_ROW = 3, 0.25, 0.4
# Controls are alike where their widths, heights and protrusions differ by at most this share of the larger width.
ALIKE_TOLERANCE = 0.15
# Alike controls belong together up to this distance between their middles, in widths: burner knobs left and right of
# a display stand in one row. Off the row, keys of one pad are nearer to each other.
MAX_ROW_PITCH, MAX_PAD_PITCH = 16.0, 4.0
# Middles within this share of the size of a control are in one row, or one column.
SAME_LINE_SHARE = 0.4


@dataclass
class Control:
    """A small object on a side.

    Attributes:
        fragments: those that it consists of. lower, upper: (3,) corners in (u, v, w).
        protrusion: how far it protrudes from its surroundings. is_round: its outline is a circle.
    """

    fragments: list[int]
    lower: Floats
    upper: Floats
    protrusion: float
    is_round: bool

    @property
    def across(self) -> Floats:
        """Return the (2,) width and height."""
        return (self.upper - self.lower)[:2]

    @property
    def middle(self) -> Floats:
        """Return the (2,) middle of its rectangle."""
        return (self.upper + self.lower)[:2] / 2

    @property
    def is_pin(self) -> bool:
        """Return whether it is one fragment, longer than wide: something pushed, not turned."""
        length = float((self.upper - self.lower)[2])
        return len(self.fragments) == 1 and length > MIN_PIN_RATIO * float(self.across.max())

    @property
    def long(self) -> float:
        """Return the ratio of the longer to the shorter side."""
        return float(self.across.max() / max(float(self.across.min()), 1e-9))


def find_controls(measured: MeasuredFragments, side: int, taken: Sequence[int]) -> list[Control]:
    """Return compact things on a side, without fragments in `taken`; top down and left to right."""
    lower, upper = corners_from_side(measured, side)
    size = upper - lower
    longest = size[:, :2].max(axis=1)
    footprint = size[:, 0] * size[:, 1]
    free = np.ones(measured.count, dtype=bool)
    free[list(taken)] = False
    fits = (longest <= MAX_CONTROL_SIZE) & (longest >= MIN_CONTROL_SIZE / 3) & (size[:, 2] <= 0.2) & free
    visible = measured.visible_area[:, side] > 0
    rows = np.flatnonzero(fits & (visible | (footprint > 0)))
    found = []
    groups = _nested(lower, upper, rows.tolist(), footprint)
    for group in [h for g in groups for h in _off_plate(measured, side, lower, upper, g, footprint)]:
        corners = lower[group].min(axis=0), upper[group].max(axis=0)
        seen = float(measured.visible_area[group, side].sum())
        across = (corners[1] - corners[0])[:2]
        if seen < 0.35 * float(np.prod(across)) or across.max() < MIN_CONTROL_SIZE or across.max() > MAX_CONTROL_SIZE:
            continue
        ground, ground_share = depth_around(measured.depth_images[side], *corners)
        if ground_share < MIN_GROUND_SHARE:
            continue
        group = _without_bezel(lower, upper, group, ground + float(lower[:, 2].min()))
        corners = lower[group].min(axis=0), upper[group].max(axis=0)
        across = (corners[1] - corners[0])[:2]
        protrusion = ground - float(corners[0][2] - lower[:, 2].min())
        found.append(Control(sorted(group), *corners, protrusion, has_round_outline(measured, side, group, across)))
    found.sort(key=lambda c: (-round(float(c.middle[1]), 3), round(float(c.middle[0]), 3)))
    return found


def control_normal(measured: MeasuredFragments, side: int, control: Control) -> Floats:
    """Return the (3,) unit direction that a control faces, in the frame: of its flat cap, else of the side."""
    outward: Floats = -SIDES[side][2]
    rows = measured.faces_of(control.fragments)
    normals, areas = measured.mesh.normals[rows], measured.mesh.areas[rows]
    ahead = normals @ outward > CAP_FACING_COS
    if not ahead.any():
        return outward
    normals, areas = normals[ahead], areas[ahead]
    share = (normals @ normals.T > CAP_FLAT_COS).astype(np.float64) @ areas / max(float(areas.sum()), 1e-18)
    best = int(np.argmax(np.round(share, 9)))
    if share[best] < MIN_CAP_SHARE or float(normals[best] @ outward) > CAP_FLAT_COS:
        return outward
    cap = (areas[:, None] * normals)[normals @ normals[best] > CAP_FLAT_COS].sum(axis=0)
    found: Floats = cap / np.linalg.norm(cap)
    # The (3,) unit vector along the median normal of the surface around it, zero without a surface.
    image = measured.depth_images[side]
    face = image.face[_surroundings(image, control.lower, control.upper)]
    face = face[face >= 0]
    face = face[~np.isin(measured.label[face], control.fragments)]
    middle = np.median(measured.mesh.normals[face], axis=0) if len(face) else np.zeros(3)
    return found if float(found @ (middle / max(float(np.linalg.norm(middle)), 1e-9))) > CAP_PARALLEL_COS else outward


def classify_control(control: Control, others: Sequence[Control]) -> tuple[PartKind | None, float, str]:
    """Classify a control among those of its side as knob, button or neither; with confidence and reason."""
    across = float(control.across.max())
    alike = sum(
        bool(np.abs(c.across - control.across).max() < 0.12 * across)
        and abs(c.protrusion - control.protrusion) < 0.25 * across
        for c in others
    )
    row = [
        c
        for c in others
        if float(np.abs(c.across - control.across).max()) < ROW_SIZE_TOLERANCE * across
        and abs(c.protrusion - control.protrusion) < ROW_SIZE_TOLERANCE * max(control.protrusion, c.protrusion)
    ]
    in_row = len(row) >= MIN_ROW_LENGTH
    is_round = sum(c.is_round for c in row) >= MIN_ROUND_SHARE_OF_ROW * len(row) if in_row else control.is_round
    if control.is_pin and control.protrusion > MIN_STICK_RATIO * across:
        return None, 0.0, ""
    if control.is_pin and control.is_round and across <= 0.09 and control.protrusion >= 0.0005:
        return PartKind.BUTTON, 0.7, "a round pin"
    if is_round and control.protrusion >= 0.22 * across and across >= 0.015:
        return PartKind.KNOB, 0.8 if alike > 1 else 0.65, "round, and stands out"
    if control.long <= 5.0 and control.protrusion >= 0.0005 and (alike > 1 or control.is_round) and across <= 0.09:
        return PartKind.BUTTON, 0.6 if alike > 1 else 0.45, "small, and one of several alike" if alike > 1 else "round"
    return None, 0.0, ""


def has_finger_room(measured: MeasuredFragments, side: int, control: Control) -> bool:
    """Return whether fingers fit around a control: little of what surrounds it protrudes nearly as far."""
    image = measured.depth_images[side]
    near = float(corners_from_side(measured, side)[0][:, 2].min())
    ring = _ring(image, control.lower, control.upper, FINGER_ROOM_BY_WIDTH * control.across, 0.0)
    level = float(control.lower[2]) - near + 0.4 * max(control.protrusion, 0.0)
    return bool((image.depth[ring] <= level).mean() < MAX_BLOCKED_SHARE) if ring.any() else True


def _nested(lower: Floats, upper: Floats, rows: list[int], footprint: Floats) -> list[list[int]]:
    """Group fragments whose middles lie within the rectangle of the group's largest, at nearly the same depth."""
    groups: list[list[int]] = []
    hosts = np.empty((0, 6))
    for i in sorted(rows, key=lambda r: (-footprint[r], r)):
        u, v = (lower[i, :2] + upper[i, :2]) / 2
        inside = (hosts[:, 0] <= u) & (u <= hosts[:, 3]) & (hosts[:, 1] <= v) & (v <= hosts[:, 4])
        inside &= (lower[i, 2] <= hosts[:, 5] + 0.02) & (upper[i, 2] >= hosts[:, 2] - 0.05)
        if inside.any():
            groups[int(np.argmax(inside))].append(i)
        else:
            groups.append([i])
            hosts = np.append(hosts, [[*lower[i], *upper[i]]], axis=0)
    return groups


def _off_plate(
    measured: MeasuredFragments, side: int, lower: Floats, upper: Floats, group: list[int], footprint: Floats
) -> list[list[int]]:
    """Return the keys of a small plate that bears several alike, and the plate; any other group as it is."""
    plate, on = group[0], np.array(group[1:], dtype=np.int64)
    on = on[footprint[on] <= MAX_KEY_OF_PLATE * footprint[plate]]
    if len(on) < MIN_KEYS_ON_PLATE or has_round_outline(measured, side, [plate], (upper - lower)[plate, :2]):
        return [group]
    size, middle = (upper - lower)[on, :2], (upper + lower)[on, :2] / 2
    alike = (np.abs(size[:, None] - size[None]) <= ROW_SIZE_TOLERANCE * size[:, None]).all(axis=2)
    apart = (np.abs(middle[:, None] - middle[None]) >= size[:, None]).any(axis=2)
    keys = on[(alike & apart).sum(axis=1) >= MIN_KEYS_ON_PLATE - 1]
    if len(keys) < MIN_KEYS_ON_PLATE:
        return [group]
    return [*_nested(lower, upper, group[1:], footprint), [plate]]


def _without_bezel(lower: Floats, upper: Floats, group: list[int], ground: float) -> list[int]:
    """Return a group without the scale or bezel around it, which is nearly flush with the `ground` around."""
    rows = np.array(group, dtype=np.int64)
    is_flush = lower[rows, 2] > ground - MAX_BEZEL_PROTRUSION
    # A flat sheet at the foot of a thing that stands out of it is what it stands on.
    is_flat = upper[rows, 2] - lower[rows, 2] <= MAX_SHEET_THICKNESS
    feet = upper[rows[~is_flush & ~is_flat], 2]
    is_flush |= is_flat & (np.abs(lower[rows, 2][:, None] - feet) <= MAX_SHEET_THICKNESS).any(axis=1)
    standing = rows[~is_flush]
    if not len(standing) or not is_flush.any():
        return group
    a, b = lower[standing, :2].min(axis=0), upper[standing, :2].max(axis=0)
    margin = BEZEL_MARGIN * float((b - a).max())
    around = ((lower[rows, :2] < a - margin) | (upper[rows, :2] > b + margin)).any(axis=1)
    kept = rows[~(is_flush & around)]
    return sorted(kept.tolist()) if float((b - a).max()) >= MIN_CONTROL_SIZE else group


def depth_around(image: DepthImage, lower: Floats, upper: Floats) -> tuple[float, float]:
    """Return the median depth around a rectangle, and the share of the surroundings that is surface."""
    depth = image.depth[_surroundings(image, lower, upper)]
    seen = depth[np.isfinite(depth)]
    return (float(np.median(seen)), len(seen) / len(depth)) if len(seen) else (0.0, 0.0)


def _surroundings(image: DepthImage, lower: Floats, upper: Floats) -> Mask:
    """Mark the (H, W) pixels right around a rectangle."""
    return _ring(image, lower, upper, np.maximum(0.25 * (upper - lower)[:2], 2.5 * image.pixel), image.pixel)


def _ring(image: DepthImage, lower: Floats, upper: Floats, outer: Floats, inner: float) -> Mask:
    """Mark the (H, W) pixels of a rectangle that is grown by `outer`, without those of the one grown by `inner`."""
    corners = np.array([lower[:2] - outer, upper[:2] + outer, lower[:2] - inner, upper[:2] + inner])
    row, column = image.rows_columns(corners)
    ring = np.zeros(image.face.shape, dtype=bool)
    ring[row[1] : row[0] + 1, column[0] : column[1] + 1] = True
    ring[row[3] : row[2] + 1, column[2] : column[3] + 1] = False
    return ring


def has_round_outline(measured: MeasuredFragments, side: int, group: Sequence[int], across: Floats) -> bool:
    """Return whether the outline of fragments is a circle, with a pointer or without.

    Of what is made of cubes, the outline is that of the middles of its cubes.
    """
    cell = measured.mesh.cell
    if across.max() > 1.2 * across.min() + cell or across.min() <= 2.5 * cell:
        return False
    flat = measured.points_of(group) @ SIDES[side][:2].T
    inner = across - cell
    share = (outline_area(flat) - cell * float(inner.sum()) - cell**2) / (np.pi / 4 * float(np.prod(inner)))
    return bool(abs(share - 1.0) <= ROUNDNESS_TOLERANCE + CUBE_ROUNDNESS_TOLERANCE * cell / float(inner.min()))


@dataclass(frozen=True)
class ControlGroup:
    """Controls of one size that belong together.

    Attributes:
        members: (N,) ascending indices of controls.
        rows, columns: how many lines their middles form across and upwards.
        pitch: median distance from the middle of a control to that of its nearest neighbour, by its width; 0 of one.
        irregularity: standard deviation of these distances by their mean.
        round_share: share of members whose outline is a circle.
    """

    members: tuple[int, ...]
    rows: int
    columns: int
    pitch: float
    irregularity: float
    round_share: float


def group_controls(controls: Sequence[Control], cell: float = 0.0) -> list[ControlGroup]:
    """Return the groups of the controls of one side; every control is in one, if alone.

    Sizes of alike controls may differ by `cell`, the edge of the cubes that the object is made of; 0 for others.
    """
    if not controls:
        return []
    middle = np.array([c.middle for c in controls])
    size = np.array([[*c.across, c.protrusion] for c in controls])
    width = size[:, :2].max(axis=1)
    larger = np.maximum(width[:, None], width[None])
    tolerance = np.maximum(ALIKE_TOLERANCE * larger, 1.05 * cell)
    alike = (np.abs(size[:, None] - size[None]) <= tolerance[..., None]).all(axis=2)
    away = np.abs(middle[:, None] - middle[None])
    distance = np.linalg.norm(away, axis=2)
    in_line = (away <= SAME_LINE_SHARE * np.maximum(size[:, None, :2], size[None, :, :2])).any(axis=2)
    near = distance <= np.where(in_line, MAX_ROW_PITCH, MAX_PAD_PITCH) * larger
    label = connected_groups(len(controls), *np.nonzero(alike & near))
    return [_group(np.flatnonzero(label == k), controls, middle, size) for k in range(int(label.max()) + 1)]


def _group(rows: Ints, controls: Sequence[Control], middle: Floats, size: Floats) -> ControlGroup:
    places = middle[rows]
    reach = np.median(size[rows, :2], axis=0)
    distance = np.linalg.norm(places[:, None] - places[None], axis=2)
    np.fill_diagonal(distance, np.inf)
    nearest = distance.min(axis=1) if len(rows) > 1 else np.zeros(1)
    return ControlGroup(
        members=tuple(rows.tolist()),
        rows=_lines(places[:, 1], SAME_LINE_SHARE * float(reach[1])),
        columns=_lines(places[:, 0], SAME_LINE_SHARE * float(reach[0])),
        pitch=float(np.median(nearest) / reach.max()),
        irregularity=float(nearest.std() / max(float(nearest.mean()), 1e-9)),
        round_share=float(np.mean([controls[i].is_round for i in rows])),
    )


def _lines(values: Floats, gap: float) -> int:
    """Return the number of heaps of values that lie further apart than `gap`."""
    return 1 + int((np.diff(np.sort(values)) > gap).sum())
