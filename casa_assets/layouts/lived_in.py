"""Put objects into a kitchen where people keep them: groups by habits, each in a free place of a space."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from casa_assets.core.numeric import Floats, about_axis, decimals
from casa_assets.layouts.compose import box_in_world
from casa_assets.layouts.spaces import CELL_M, Rect, Silhouette, Space, silhouette, taken_by
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.scene import Placement, Resting
from casa_assets.model.pose import Pose
from casa_assets.model.registry.rows import Arrangement, Habit, Habits, SpaceKind

# Between the objects of a group, and over what each stands on, metres.
GAP_M, SET_DOWN_GAP_M = 0.008, 0.0003
# How much the objects of a row differ in direction and line, degrees and metres; at rest nobody sets them down alike.
ROW_TURN_DEG, ROW_SHIFT_M = 5.0, 0.004
# Places that are tried for each thing in a vessel, and how little above its floor it stands at most.
HEAP_TRIES, ON_FLOOR_M = 120, 0.0012
HOB_TURN_DEG = 30.0
# A plate leans in its slot, by less than this, and this far from what it leans on and from the wires in front of it.
MAX_LEAN_RAD, SLOT_GAP_M = 0.15, 0.0004
_SIDES = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]])
# Members of a category that are drawn from: the first ones that `casa-assets objects build` makes.
MEMBERS = 12
# Habits that are tried for each object before a kitchen counts as full.
TRIES_PER_OBJECT = 12
# Draws of what a group consists of, where those drawn before do not go together or nowhere fit.
GROUP_DRAWS = 3
EDGE_M = 0.008  # that stays free along the edges of a space
HEAD_ROOM_M = 0.012  # that stays free above, for fingers and for a drawer on its way
THEME_POWER = 1.5
GRID_M = 0.02  # of the places that are tried
SHIFT_M = 0.03  # that things stand more or less far from the wall
# Nothing is stored as eagerly above the height that a person or robot reaches into without a step.
EASY_REACH_M, HARD_REACH_WEIGHT = 1.75, 0.15


@dataclass(frozen=True)
class Group:
    """Objects and their relative poses.

    Attributes:
        poses: group_from_asset of each; the middle of the group's footprint is the origin, its foot at z = 0.
        size: width, depth and height of the group, metres.
        body: point to place over a site, such as the middle of a pan without its handle; frame of the group, metres.
    """

    poses: tuple[Pose, ...]
    size: tuple[float, float, float]
    body: tuple[float, float] = (0.0, 0.0)


def arrange(arrangement: Arrangement, members: Sequence[Silhouette], rng: np.random.Generator) -> Group | None:
    """A group of objects, a vessel or rack first; None if they do not fit together, such as a melon and a cup."""
    if arrangement is Arrangement.STACK:
        return _stack(members)
    if arrangement is Arrangement.HEAP:
        return _heap(members, rng)
    if arrangement is Arrangement.ON_EDGE:
        return _on_edge(members, rng)
    return _side_by_side(members, _turns(arrangement, members, rng), rng)


def _turns(arrangement: Arrangement, members: Sequence[Silhouette], rng: np.random.Generator) -> list[float]:
    if arrangement is Arrangement.LOOSE:
        return [float(rng.uniform(-math.pi, math.pi)) for _ in members]
    if arrangement is Arrangement.HANDLE_FRONT:
        jitter = [math.radians(float(rng.uniform(-HOB_TURN_DEG, HOB_TURN_DEG))) for _ in members]
        # The handle is turned to the front, -y.
        handles = [m.handle for m in members]
        to_front = [0.0 if h is None else -math.pi / 2 - math.atan2(float(h[1]), float(h[0])) for h in handles]
        return [a + j for a, j in zip(to_front, jitter, strict=True)]
    jitter = [math.radians(float(rng.uniform(-ROW_TURN_DEG, ROW_TURN_DEG))) for _ in members]
    if arrangement is Arrangement.ROW:
        return jitter
    # From front to back: a quarter turn for what is longer from left to right, its head to the back.
    wide = [np.ptp(m.box[:, 0]) > np.ptp(m.box[:, 1]) for m in members]
    return [(math.pi / 2 if w else 0.0) + 0.4 * j for w, j in zip(wide, jitter, strict=True)]


def turned_box(member: Silhouette, angle: float) -> Floats:
    """(2, 2) bounds seen from above of an object that is turned; frame of the asset, metres."""
    filled = np.argwhere(np.isfinite(member.low))
    centers = member.box[0, :2] + (filled + 0.5) * CELL_M
    corners = (centers[:, None] + CELL_M / 2 * _SIDES).reshape(-1, 2)
    points = corners @ about_axis(np.array([0.0, 0.0, 1.0]), angle)[:2, :2].T
    return np.array([points.min(axis=0), points.max(axis=0)])


def _upright(x: float, y: float, z: float, angle: float = 0.0) -> Pose:
    return Pose(position=(x, y, z), quaternion=(math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)))


def _side_by_side(members: Sequence[Silhouette], turns: Sequence[float], rng: np.random.Generator) -> Group:
    boxes = [turned_box(member, turn) for member, turn in zip(members, turns, strict=True)]
    width = sum(float(np.ptp(b[:, 0])) for b in boxes) + GAP_M * (len(boxes) - 1)
    poses, x, front, back = [], -width / 2, 0.0, 0.0
    for member, turn, box in zip(members, turns, boxes, strict=True):
        shift = float(rng.uniform(-ROW_SHIFT_M, ROW_SHIFT_M)) if len(boxes) > 1 else 0.0
        y = shift - float(box.mean(axis=0)[1])
        poses.append((x - float(box[0, 0]), y, -float(member.box[0, 2]) + SET_DOWN_GAP_M, turn))
        front, back = min(front, y + float(box[0, 1])), max(back, y + float(box[1, 1]))
        x += float(np.ptp(box[:, 0])) + GAP_M
    middle = (front + back) / 2
    height = max(float(np.ptp(m.box[:, 2])) for m in members)
    centered = tuple(_upright(px, py - middle, pz, turn) for px, py, pz, turn in poses)
    x, y, _ = (float(c) for c in centered[0].apply(np.array([[*members[0].body, 0.0]]))[0])
    return Group(centered, (width, back - front, height), (x, y) if len(members) == 1 else (0.0, 0.0))


def _stack(members: Sequence[Silhouette]) -> Group:
    first, pitch = members[0], members[0].pitch
    (x, y, _), foot = (float(c) for c in first.box.mean(axis=0)), float(first.box[0, 2])
    poses = [_upright(-x, -y, -foot + SET_DOWN_GAP_M + k * pitch) for k in range(len(members))]
    width, depth, height = (float(s) for s in np.ptp(first.box, axis=0))
    return Group(tuple(poses), (width, depth, height + (len(members) - 1) * pitch))


def _heap(members: Sequence[Silhouette], rng: np.random.Generator) -> Group | None:
    """The first object upright, the others next to each other on its floor, each in a free place near its middle.

    No object leans against a wall or lies on another: in the light form of a scene, in which shapes are smaller, it
    would slide down. None if a place is not found for one of them.
    """
    vessel, *rest = members
    middle, foot = vessel.box.mean(axis=0), float(vessel.box[0, 2])
    ground = np.where(np.isfinite(vessel.high), vessel.high, np.inf)
    floor = float(ground.min())
    poses = [(0.0, 0.0, 0.0)]
    top = float(vessel.box[1, 2])
    for member in rest:
        low, extent = float(member.box[0, 2]), np.array(member.low.shape)
        room, filled = np.array(ground.shape) - extent, np.isfinite(member.low)
        if (room < 0).any():
            return None
        best: tuple[float, int, int, float] | None = None
        for _ in range(HEAP_TRIES):
            i, j = (int(rng.integers(0, r + 1)) for r in room)
            under = ground[i : i + extent[0], j : j + extent[1]]
            z = float((under[filled] - member.low[filled]).max())
            off_middle = float(np.hypot(*(np.array([i, j]) - room / 2)))
            if z + low < floor + ON_FLOOR_M and (best is None or off_middle < best[0]):
                best = (off_middle, i, j, z)
        if best is None:
            return None
        _, i, j, z = best
        # Nothing fits above or below it any more.
        ground[i : i + extent[0], j : j + extent[1]][filled] = np.inf
        corner = vessel.box[0, :2] + CELL_M * np.array([i, j]) - member.box[0, :2]
        poses.append((float(corner[0]), float(corner[1]), z + SET_DOWN_GAP_M))
        top = max(top, z + float(member.box[1, 2]))
    width, depth, _ = (float(s) for s in np.ptp(vessel.box, axis=0))
    lifted = [_upright(x - float(middle[0]), y - float(middle[1]), z - foot + SET_DOWN_GAP_M) for x, y, z in poses]
    return Group(tuple(lifted), (width, depth, top - foot))


def _on_edge(members: Sequence[Silhouette], rng: np.random.Generator) -> Group | None:
    """The first object, a rack, upright; the others in its slots, leaning left; None: too few, or one does not fit."""
    rack, *plates = members
    spare = len(rack.slots) - len(plates)
    if spare < 0:
        return None
    first = int(rng.integers(0, spare + 1))
    spots = [_in_slot(rack, slot, plate) for slot, plate in zip(rack.slots[first:], plates, strict=False)]
    middle, foot = rack.box.mean(axis=0), float(rack.box[0, 2])
    poses, boxes = [_upright(-float(middle[0]), -float(middle[1]), SET_DOWN_GAP_M - foot)], [rack.box]
    for plate, spot in zip(plates, spots, strict=True):
        if spot is None:
            return None
        pose = poses[0] @ spot
        poses.append(pose)
        boxes.append(box_in_world(spot, plate.box))
    low, high = np.min([b[0] for b in boxes], axis=0), np.max([b[1] for b in boxes], axis=0)
    # Plates may stand out at the left: the origin is the middle of all.
    off = Pose(position=(float(middle[0] - (low + high)[0] / 2), float(middle[1] - (low + high)[1] / 2), 0.0))
    width, depth, height = (float(s) for s in high - low)
    return Group(tuple(off @ pose for pose in poses), (width, depth, height))


def _in_slot(rack: Silhouette, slot: Floats, plate: Silhouette) -> Pose | None:
    """rack_from_plate of a plate in a slot: its foot on the tips of the left tines, its rim before the right ones.

    `slot`: (2, 3) bounds between the tines.
    """
    (half_x, half_y, _), (wide, _, high) = np.ptp(plate.box, axis=0) / 2, slot[1] - slot[0]
    thick, lowest_by_x = float(np.ptp(plate.box[:, 2])), plate.low.min(axis=1)
    rim_low = float(lowest_by_x[np.isfinite(lowest_by_x)][-1] - plate.box[0, 2])
    play = wide - 2 * SLOT_GAP_M - thick
    if play <= 0:
        return None
    lean = min(MAX_LEAN_RAD, math.asin(min(1.0, play / high)))
    sine, cosine = math.sin(lean), math.cos(lean)
    z = slot[0, 2] + SET_DOWN_GAP_M + half_x * cosine - rim_low * sine
    x = slot[0, 0] + SLOT_GAP_M - (z - slot[1, 2]) / cosine * sine
    y = float(slot[:, 1].mean())
    # Where the plate is wide it must be above the walls of the rack.
    i0, i1 = ((slot[:, 0] - rack.box[0, 0]) / CELL_M).astype(int)
    ys = rack.box[0, 1] + (np.arange(rack.high.shape[1]) + 0.5) * CELL_M - y
    round_ = np.sqrt(np.maximum(0.0, 1.0 - (ys / half_y) ** 2))
    lowest = np.where(np.abs(ys) < half_y, z - half_x * cosine * round_ + rim_low * sine, np.inf)
    if (rack.high[i0 + 1 : i1].max(axis=0) > lowest + CELL_M / 2).any():
        return None
    turned = Pose(quaternion=(math.cos(math.pi / 4 - lean / 2), 0.0, math.sin(math.pi / 4 - lean / 2), 0.0))
    own = np.array([*plate.box[:, :2].mean(axis=0), plate.box[0, 2]])
    shift = turned.apply(own[None])[0]
    return turned.replace(position=(float(x - shift[0]), float(y - shift[1]), float(z - shift[2])))


@dataclass(frozen=True)
class PutGroup:
    """A group that found a place: its habit, its objects as placements, and the (2, 3) box around them in the world."""

    habit: str
    placements: tuple[Placement, ...]
    box: Floats


@dataclass
class _Draw:
    habits: Habits
    spaces: Sequence[Space]
    member: Callable[[str, int], Asset]
    rng: np.random.Generator
    boxes: list[Floats] = field(default_factory=list)  # of the world, around the groups that found a place
    silhouettes: dict[str, Silhouette] = field(default_factory=dict)
    names: Counter[str] = field(default_factory=Counter)  # highest number that an object of a category has had
    themes: dict[tuple[str, str], str] = field(default_factory=dict)  # of the objects in a closed space

    def silhouette(self, asset: Asset) -> Silhouette:
        if asset.id not in self.silhouettes:
            self.silhouettes[asset.id] = silhouette(asset)
        return self.silhouettes[asset.id]

    def new_name(self, category: str) -> str:
        """A name that no object has had."""
        self.names[category] += 1
        return f"object_{category}_{self.names[category]}"

    def note(self, group: PutGroup) -> None:
        """Count a group: what it takes, the theme of its space, the names of its objects."""
        self.boxes.append(group.box)
        for place in group.placements:
            name, _, number = place.name.removeprefix("object_").rpartition("_")
            self.names[name] = max(self.names[name], int(number))
        rest = group.placements[0].resting
        for space in self.spaces:
            if rest and (space.placement, space.region) == (rest.placement, rest.region):
                is_open = all(self.habits.spaces[kind].is_open for kind in space.kinds)
                self.themes[space.placement, space.region] = "" if is_open else self.habits.habits[group.habit].theme

    def theme(self, space: Space) -> str:
        return self.themes.get((space.placement, space.region), "")


def put_objects(
    spaces: Sequence[Space],
    habits: Habits,
    member: Callable[[str, int], Asset],
    count: int,
    rng: np.random.Generator,
    already: Sequence[PutGroup] = (),
) -> tuple[PutGroup, ...]:
    """New groups of objects in free places, `count` objects in all, or fewer if no space is left.

    `member`: category and number -> the object, always the same. `already`: groups that are there.
    """
    draw = _Draw(habits, spaces, member, rng)
    for group in already:
        draw.note(group)
    times = Counter(group.habit for group in already)
    themes = Counter(habits.habits[group.habit].theme for group in already)
    groups: list[PutGroup] = []
    left = count
    for _ in range(TRIES_PER_OBJECT * count):
        # The more there is of a theme, the less of it comes: every kitchen has something of each.
        open_habits = {
            name: habit.weight / (1 + themes[habit.theme]) ** THEME_POWER
            for name, habit in habits.habits.items()
            if times[name] < habit.most and habit.fewest <= left
        }
        if left <= 0 or not open_habits:
            break
        name = _pick(open_habits, rng)
        tries = (_put_group(draw, name, habits.habits[name], left) for _ in range(GROUP_DRAWS))
        new = next((group for group in tries if group is not None), None)
        # A habit that found no room counts as well, or a kitchen without a hob would be searched for one for ever.
        times[name] += 1
        themes[habits.habits[name].theme] += 1
        if new is not None:
            groups.append(new)
            left -= len(new.placements)
    return tuple(groups)


def _pick(weights: Mapping[str, float], rng: np.random.Generator) -> str:
    names = sorted(weights)
    shares = np.array([weights[n] for n in names])
    return names[int(rng.choice(len(names), p=shares / shares.sum()))]


def _put_group(draw: _Draw, name: str, habit: Habit, left: int) -> PutGroup | None:
    rng = draw.rng
    low, high = habit.count
    number = int(rng.integers(low, min(high, left - bool(habit.vessel)) + 1))
    assets = [_member(draw, habit.vessel)] if habit.vessel else []
    alike = [_member(draw, habit.objects)] * number if habit.alike else []
    assets += alike or [_member(draw, habit.objects) for _ in range(number)]
    kind = _pick(habit.spaces, rng)
    for tried in (kind, *(k for k in sorted(habit.spaces) if k != kind)):
        rooms = [s for s in draw.spaces if tried in s.kinds and draw.theme(s) in ("", habit.theme)]
        if not rooms:
            continue
        space_kind = draw.habits.spaces[tried]
        ease = [1.0 if s.pose.position[2] <= EASY_REACH_M else HARD_REACH_WEIGHT for s in rooms]
        together = [space_kind.together if draw.theme(s) else 1.0 for s in rooms]
        weights = np.array([e * t for e, t in zip(ease, together, strict=True)])
        order = rng.choice(len(rooms), size=len(rooms), replace=False, p=weights / weights.sum())
        for index in order:
            room = rooms[int(index)]
            for fewer in range(len(assets), habit.fewest - 1, -1):
                group = arrange(habit.arrangement, [draw.silhouette(a) for a in assets[:fewer]], rng)
                spot = None if group is None else _free_spot(room, space_kind, group, draw.boxes, rng)
                if group is not None and spot is not None:
                    return _set_down(draw, name, room, assets[:fewer], group, spot)
    return None


def _member(draw: _Draw, categories: Mapping[str, float]) -> Asset:
    """A member of one of some categories, whole where there are whole ones: nobody keeps half an apple in a bowl."""
    category, first = _pick(categories, draw.rng), int(draw.rng.integers(MEMBERS))
    for step in range(MEMBERS):
        asset = draw.member(category, (first + step) % MEMBERS)
        if asset.labels.portion is None:
            return asset
    return draw.member(category, first)


def _free_spot(
    space: Space, kind: SpaceKind, group: Group, boxes: Sequence[Floats], rng: np.random.Generator
) -> tuple[float, float] | None:
    """Middle of a free place for a group, in the frame of the space, clear of (2, 3) boxes in the world; or None."""
    gap, (width, depth, height) = kind.gap_m, space.size
    half_x, half_y = group.size[0] / 2, group.size[1] / 2
    taken = [*space.taken, *taken_by(space, np.array(boxes))]
    if group.size[2] > height - HEAD_ROOM_M:
        return None
    if space.is_site:
        at = (-group.body[0], -group.body[1])
        return None if any(_overlap(_rect(*at, half_x + gap, half_y + gap), other) for other in taken) else at
    reach_x, reach_y = width / 2 - half_x - EDGE_M, depth / 2 - half_y - EDGE_M
    back = min(reach_y, kind.reach_m - depth / 2 - half_y)
    if reach_x < 0 or back < -reach_y:
        return None
    xs, ys = np.arange(-reach_x, reach_x + 1e-9, GRID_M), np.arange(-reach_y, back + 1e-9, GRID_M)
    if kind.from_back:
        ys = np.maximum(-reach_y, back - (ys + reach_y) - float(rng.uniform(0.0, SHIFT_M)))
    for y in ys:
        for x in xs[rng.permutation(len(xs))]:
            if space.is_round and math.hypot(abs(x) + half_x, abs(y) + half_y) > width / 2 - EDGE_M:
                continue
            if not any(_overlap(_rect(x, y, half_x + gap, half_y + gap), other) for other in taken):
                return float(x), float(y)
    return None


def _rect(x: float, y: float, half_x: float, half_y: float) -> Rect:
    return (x - half_x, y - half_y, x + half_x, y + half_y)


def _overlap(a: Rect, b: Rect) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _set_down(
    draw: _Draw, name: str, space: Space, assets: Sequence[Asset], group: Group, spot: tuple[float, float]
) -> PutGroup:
    (x, y), (width, depth, height) = spot, group.size
    box = np.array([(x - width / 2, y - depth / 2, 0.0), (x + width / 2, y + depth / 2, height)])
    frame = space.pose @ Pose(position=(x, y, 0.0))
    rest = Resting(placement=space.placement, link=space.link, region=space.region)
    placed = [(draw.new_name(a.labels.category), a.id, pose) for a, pose in zip(assets, group.poses, strict=True)]
    placements = tuple(
        Placement(name=own, asset=asset, pose=rounded_pose(frame @ pose), resting=rest) for own, asset, pose in placed
    )
    put = PutGroup(name, placements, box_in_world(space.pose, box))
    draw.note(put)
    return put


def rounded_pose(pose: Pose) -> Pose:
    """A pose to a hundredth of a millimetre, so that it is the same on every machine."""
    x, y, z = (decimals(float(c), 5) for c in pose.position)
    w, i, j, k = (decimals(float(c), 7) for c in pose.quaternion)
    return Pose(position=(x, y, z), quaternion=(w, i, j, k))
