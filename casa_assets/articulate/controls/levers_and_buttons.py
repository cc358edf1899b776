"""Find levers, wall switches and single buttons, and distinguish burner caps from knobs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from casa_assets.articulate.controls.controls import Control, find_controls, has_round_outline
from casa_assets.articulate.fronts.panels import find_panels
from casa_assets.articulate.plan import JointPlan, PartKind, hinge, to_vec3
from casa_assets.articulate.segment.fragments import MeasuredFragments, corners_from_side
from casa_assets.articulate.segment.orthographic import FRONT, SIDES
from casa_assets.core.numeric import Floats, Mask

# Depth of a slot against both sides, widest gap between the lever and its slot, and length of a slot; diagonals.
MIN_SLOT_DEPTH, MAX_SLOT_START_GAP, MIN_SLOT_LENGTH = 0.008, 0.02, 0.06
# A painted slot lies at most this far before its surroundings, diagonals.
PAINTED_SLOT_TOLERANCE = 0.001
# Least protrusion of a lever, diagonals.
MIN_PROTRUSION = 0.01
# Longest stretch of a slot that something beside it hides, diagonals.
MAX_SLOT_BREAK = 0.06
# Width to height of a level bar, and its travel by its height above the floor.
MIN_BAR_RATIO, BAR_TRAVEL_SHARE = 1.8, 0.5
# Distance from the middle of a slot at which its sides are sampled, in widths of the lever.
BESIDE_WIDTHS = 0.75
# Depth of a plate and of what is behind its face, by its shorter side; share of its rectangle that it fills, and width
# by height between these: up to six switches in one frame.
MAX_PLATE_DEPTH, MIN_PLATE_FILL, PLATE_RATIOS = 0.25, 0.85, (0.5, 5.0)
# Depth of the whole, with what stands out, by the shorter side of the plate.
MAX_REACH = 0.6
# Pieces: how many, their height by that of the plate, offset of their middle from that of the plate by its height.
MAX_PIECES, PIECE_HEIGHTS, MAX_OFF_MIDDLE = 6, (0.08, 0.75), 0.15
# Sizes, and distances between neighbours, of pieces of one row differ by at most this share.
MAX_UNEVENNESS = 0.15
# Pieces that share so much of their width and height are one.
MIN_COMMON = 0.8
# A toggle is narrow, by the height of the plate, and stands out by this, by its own width.
MAX_TOGGLE_WIDTH, MIN_TOGGLE_REACH = 0.16, 1.0
# Widest and narrowest a dimmer knob may be by the height of the plate; what it stands out by, by its width.
DIMMER_WIDTHS, MIN_DIMMER_REACH = (0.15, 0.75), 0.12
# Rockers tilt by 9 degrees to either side, toggles by 29.
ROCKER_RAD, TOGGLE_RAD = 0.15, 0.5
SWITCH_CONFIDENCE = 0.6
# Share of what is seen from the front that the plate and its switches are: the rest are frames and screws.
MIN_SHOWN = 0.8
# Least thickness of a piece that is alone, by the height of the plate.
MIN_THICKNESS = 0.005
# Width of a single button, diagonals (a ring around one is wider), its least protrusion, and its most by its width.
MAX_BUTTON_WIDTH, MIN_BUTTON_PROTRUSION, MAX_PROTRUSION_BY_WIDTH = 0.22, 0.004, 0.6
# Burner caps are surrounded by slim arms that bear pans: fewest arms, their length to width, and their distance from
# the cap by its width. Knobs of an object are alike: with this many on its front, a round control of another width on
# the top is none.
MIN_PAN_SUPPORT_ARMS, MIN_ARM_RATIO, MAX_ARM_GAP_BY_WIDTH, MIN_FRONT_KNOBS, KNOB_WIDTH_TOLERANCE = 3, 4.0, 0.5, 2, 0.25


@dataclass(frozen=True)
class Lever:
    """A control that slides in a slot.

    Attributes:
        control: the thing. way: (3,) unit direction in (u, v, w) along which it goes. length: of the slot on that side.
    """

    control: Control
    way: Floats
    length: float


def find_levers(measured: MeasuredFragments, controls: Sequence[Control]) -> list[Lever]:
    """Return the controls that run in a slot."""
    near = float(corners_from_side(measured, FRONT)[0][:, 2].min())
    levers: list[Lever] = []
    for control in controls:
        found: Lever | None = None
        for along, sign in ((1, -1.0), (1, 1.0), (0, -1.0), (0, 1.0)):
            if control.is_round or control.protrusion < MIN_PROTRUSION:
                break
            slot = _slot(measured, control, along, sign, near)
            if slot is not None and (found is None or slot.length > found.length + 1e-6):
                found = slot
        levers += [] if found is None else [found]
    return levers


def find_bar_levers(measured: MeasuredFragments, controls: Sequence[Control]) -> list[Lever]:
    """Return level bars, which lower the bread of a toaster though no slot is drawn for them."""
    floor = float(corners_from_side(measured, FRONT)[0][:, 1].min())
    levers = []
    for control in controls:
        wide = float(control.across[0]) >= MIN_BAR_RATIO * float(control.across[1])
        room = float(control.lower[1]) - floor
        if not control.is_round and wide and control.protrusion >= MIN_PROTRUSION and room >= MIN_SLOT_LENGTH:
            levers.append(Lever(control, np.array([0.0, -1.0, 0.0]), BAR_TRAVEL_SHARE * room))
    return levers


def _slot(measured: MeasuredFragments, control: Control, along: int, sign: float, near: float) -> Lever | None:
    """Return the slot that leads away from a control along an axis, or None; `near` is the nearest depth of all."""
    image = measured.depth_images[FRONT]
    across = 1 - along
    wide = float(control.across[across])
    start = float((control.upper if sign > 0 else control.lower)[along])
    steps = np.arange(1, int(0.7 / image.pixel)) * image.pixel
    lines, marks = [], []
    for shift in (0.0, -BESIDE_WIDTHS * wide, BESIDE_WIDTHS * wide):
        line = np.empty((len(steps), 2))
        line[:, along] = start + sign * steps
        line[:, across] = control.middle[across] + shift
        row, column = image.rows_columns(line)
        lines.append(image.depth[row, column])
        marks.append(np.where(image.face[row, column] >= 0, measured.label[image.face[row, column]], -1))
    inside = np.isfinite(lines[1]) & np.isfinite(lines[2])
    left, right = np.where(inside, lines[1], 0.0), np.where(inside, lines[2], 0.0)
    beside = np.maximum(left, right)
    # One fragment lies between two sides of another.
    middle, one, other = marks
    strip = (middle >= 0) & (one == other) & (middle != one)
    painted = strip & (middle == (middle[strip][0] if strip.any() else -1))
    deep = (
        inside
        & (np.abs(left - right) < MIN_SLOT_DEPTH)
        & ((lines[0] > beside + MIN_SLOT_DEPTH) | (painted & (lines[0] > beside - PAINTED_SLOT_TOLERANCE)))
    )
    last = _run(deep, image.pixel)
    # The surface goes on beyond its end: a gap between fronts runs to the border.
    beyond = slice(last + 2, last + 6)
    ends = inside[beyond].all() and len(inside[beyond]) == 4 and not deep[beyond].any()
    if last * image.pixel < max(MIN_SLOT_LENGTH, 1.2 * float(control.across[along])) or not ends:
        return None
    # By how much the surface falls back, from its first to its last third, for a shell of cubes goes down in stairs.
    third = max(1, last // 3)
    fall = float(np.median(beside[last - third : last]) - np.median(beside[:third]))
    slope = fall / max(last - third, 1) / image.pixel
    way = np.zeros(3)
    way[along], way[2] = sign, slope
    return Lever(control, way / np.linalg.norm(way), last * image.pixel)


def _run(deep: Mask, pixel: float) -> int:
    """Return the number of steps that a slot goes on from its start, which may lie a little way off."""
    rows = np.flatnonzero(deep)
    if not len(rows) or rows[0] * pixel > MAX_SLOT_START_GAP:
        return 0
    breaks = np.flatnonzero(np.diff(rows) * pixel > MAX_SLOT_BREAK)
    return int(rows[breaks[0]] if len(breaks) else rows[-1]) + 1


def find_switch_parts(measured: MeasuredFragments) -> list[tuple[PartKind, list[int], JointPlan]]:
    """Return what is pressed or turned on a wall switch: kind, fragments and joint of each; none of other things."""
    lower, upper = corners_from_side(measured, FRONT)
    plate = _plate(measured, lower, upper)
    if plate is None:
        return []
    corner, size = lower[plate], upper[plate] - lower[plate]
    rest = [i for i in range(measured.count) if i != plate and measured.visible_area[i, FRONT] > 0.0]
    inside = [i for i in rest if (lower[i] >= corner - 1e-6)[:2].all() and (upper[i] <= upper[plate] + 1e-6)[:2].all()]
    groups = _stacked(inside, lower, upper)
    boxes = [np.array([lower[g].min(axis=0), upper[g].max(axis=0)]) for g in groups]
    middle = float(corner[1] + size[1] / 2)
    row = [k for k, b in enumerate(boxes) if _fits(b, float(size[1]), middle)]
    if not 0 < len(row) <= MAX_PIECES or not _is_even([boxes[k] for k in row]):
        return []
    # One flat piece alone is a label.
    if len(row) == 1 and float(np.ptp(boxes[row[0]][:, 2])) <= MIN_THICKNESS * float(size[1]):
        return []
    # Of a back that lies behind a body one sees little.
    shown = [plate, *(i for k in row for i in groups[k])]
    if float(measured.visible_area[shown, FRONT].sum()) < MIN_SHOWN * float(measured.visible_area[:, FRONT].sum()):
        return []
    found = [_part(measured, groups[k], boxes[k], float(size[1]), float(corner[2])) for k in row]
    return [part for part in found if part is not None] if all(found) else []


def _plate(measured: MeasuredFragments, lower: Floats, upper: Floats) -> int | None:
    """Return the fragment that is a thin plate behind all others, or None if no fragment is."""
    size = upper - lower
    whole = upper.max(axis=0) - lower.min(axis=0)
    plate = int(np.argmax(size[:, 0] * size[:, 1]))
    wide, high, deep = (float(v) for v in size[plate])
    seen = measured.depth_images[FRONT].face >= 0
    is_whole = min(wide / float(whole[0]), high / float(whole[1])) > 0.95
    # Behind the leaf of a door there is a body, and before the back of a body.
    deep = max(deep, float(upper[:, 2].max() - lower[plate, 2]))
    is_whole &= float(whole[2]) <= MAX_REACH * min(wide, high)
    if not is_whole or deep > MAX_PLATE_DEPTH * min(wide, high) or float(seen.mean()) < MIN_PLATE_FILL:
        return None
    return plate if PLATE_RATIOS[0] <= wide / high <= PLATE_RATIOS[1] else None


def _stacked(rows: Sequence[int], lower: Floats, upper: Floats) -> list[list[int]]:
    """Return the fragments in groups that lie one in front of the other, from left to right.

    The frame around a toggle is not in its group unless it is as high as the toggle.
    """
    groups: list[list[int]] = []
    for i in sorted(rows, key=lambda k: (round(float(lower[k, 0]), 6), k)):
        for group in groups:
            j = group[0]
            common = np.minimum(upper[i], upper[j])[:2] - np.maximum(lower[i], lower[j])[:2]
            both = np.maximum(upper[i] - lower[i], upper[j] - lower[j])[:2]
            if (common >= MIN_COMMON * both).all():
                group.append(i)
                break
        else:
            groups.append([i])
    return groups


def _fits(box: Floats, high: float, middle: float) -> bool:
    """Return whether a piece lies in the middle of the height of a plate."""
    size = box[1] - box[0]
    is_high = PIECE_HEIGHTS[0] * high <= float(size[1]) <= PIECE_HEIGHTS[1] * high
    return is_high and abs(float(box[:, 1].mean()) - middle) <= MAX_OFF_MIDDLE * high


def _is_even(boxes: Sequence[Floats]) -> bool:
    """Return whether pieces are of one size, at one height, and at even distances."""
    sizes = np.array([b[1] - b[0] for b in boxes])[:, :2]
    if float(np.ptp(sizes, axis=0).max()) > MAX_UNEVENNESS * float(sizes.max()):
        return False
    gaps = np.diff(np.sort([float(b[:, 0].mean()) for b in boxes]))
    apart = not len(gaps) or float(gaps.min()) >= float(sizes[:, 0].max())
    return apart and (len(gaps) < 2 or float(np.ptp(gaps)) <= MAX_UNEVENNESS * float(gaps.max()))


def _part(
    measured: MeasuredFragments, group: list[int], box: Floats, high: float, ground: float
) -> tuple[PartKind, list[int], JointPlan] | None:
    """Return a rocker, a toggle or a knob with its joint, or None if the piece is anything else.

    Args:
        box: (2, 3) corners in (u, v, w). high: height of the plate. ground: depth of its face.
    """
    size = box[1] - box[0]
    wide, tall, reach = float(size[0]), float(size[1]), ground - float(box[0, 2])
    u, v = (float(c) for c in box[:, :2].mean(axis=0))
    foot = to_vec3(np.array([u, v, ground]) @ SIDES[FRONT])
    if has_round_outline(measured, FRONT, group, size[:2]):
        if not DIMMER_WIDTHS[0] * high <= wide <= DIMMER_WIDTHS[1] * high or reach < MIN_DIMMER_REACH * wide:
            return None
        reason = "a round piece in the middle of a thin plate"
        return PartKind.KNOB, group, hinge((0.0, -1.0, 0.0), foot, None, SWITCH_CONFIDENCE, reason)
    is_toggle = wide <= MAX_TOGGLE_WIDTH * high and reach >= MIN_TOGGLE_REACH * wide
    if not is_toggle and (reach > 0.5 * tall or wide > 2.0 * tall):
        return None
    angle = TOGGLE_RAD if is_toggle else ROCKER_RAD
    reason = "a stick that stands out of a thin plate" if is_toggle else "it lies in the middle of a thin plate"
    return PartKind.LEVER, group, hinge((1.0, 0.0, 0.0), foot, (-angle, angle), SWITCH_CONFIDENCE, reason)


def drop_burner_caps(over: Sequence[Control], top: Sequence[Control], front: Sequence[Control]) -> list[Control]:
    """Return the round things on a top that may be knobs, without caps of burners; by all of the top and front."""
    knobs = [float(c.across.max()) for c in front if c.is_round and c.protrusion >= MIN_BUTTON_PROTRUSION]
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
    standing = [
        c for c in found if MIN_BUTTON_PROTRUSION <= c.protrusion <= MAX_PROTRUSION_BY_WIDTH * float(c.across.max())
    ]
    return standing[0] if len(standing) == 1 else None
