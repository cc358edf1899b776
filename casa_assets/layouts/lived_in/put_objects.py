"""Draw groups of objects by the habits of people, and find free places for them in the spaces of a kitchen."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from casa_assets.core.numeric import Floats, decimals
from casa_assets.layouts.compose.compose import box_in_world
from casa_assets.layouts.lived_in.groups import Group, arrange
from casa_assets.layouts.lived_in.spaces import Rect, Silhouette, Space, silhouette, taken_by
from casa_assets.model.asset.asset import Asset
from casa_assets.model.kitchen.habit import Habit, Habits, SpaceKind
from casa_assets.model.kitchen.scene import Placement, Resting
from casa_assets.model.pose import Pose

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
class PutGroup:
    """A group that found a place: its habit, its objects as placements, and the (2, 3) box around them in the world."""

    habit: str
    placements: tuple[Placement, ...]
    box: Floats


@dataclass
class _Room:
    """A space while it is being filled, with the theme of its objects."""

    space: Space
    theme: str = ""


@dataclass
class _Draw:
    """State of one draw."""

    habits: Habits
    rooms: list[_Room]
    member: Callable[[str, int], Asset]
    rng: np.random.Generator
    boxes: list[Floats] = field(default_factory=list)  # of the world, around the groups that found a place
    silhouettes: dict[str, Silhouette] = field(default_factory=dict)
    names: Counter[str] = field(default_factory=Counter)  # highest number that an object of a category has had

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
        for room in self.rooms:
            if rest and (room.space.placement, room.space.region) == (rest.placement, rest.region):
                is_open = all(self.habits.spaces[kind].is_open for kind in room.space.kinds)
                room.theme = "" if is_open else self.habits.habits[group.habit].theme


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
    draw = _Draw(habits, [_Room(space) for space in spaces], member, rng)
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
        rooms = [r for r in draw.rooms if tried in r.space.kinds and r.theme in ("", habit.theme)]
        if not rooms:
            continue
        space_kind = draw.habits.spaces[tried]
        ease = [1.0 if r.space.pose.position[2] <= EASY_REACH_M else HARD_REACH_WEIGHT for r in rooms]
        weights = np.array([e * (space_kind.together if r.theme else 1.0) for e, r in zip(ease, rooms, strict=True)])
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
    room: _Room, kind: SpaceKind, group: Group, boxes: Sequence[Floats], rng: np.random.Generator
) -> tuple[float, float] | None:
    """Middle of a free place for a group, in the frame of the space, clear of (2, 3) boxes in the world; or None."""
    space, gap = room.space, kind.gap_m
    width, depth, height = space.size
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
    draw: _Draw, name: str, room: _Room, assets: Sequence[Asset], group: Group, spot: tuple[float, float]
) -> PutGroup:
    """The objects of a group as placements, and what they take noted."""
    (x, y), space, (width, depth, height) = spot, room.space, group.size
    box = np.array([(x - width / 2, y - depth / 2, 0.0), (x + width / 2, y + depth / 2, height)])
    frame = space.pose @ Pose(position=(x, y, 0.0))
    rest = Resting(placement=space.placement, link=space.link, region=space.region)
    placements = tuple(
        Placement(
            name=draw.new_name(asset.labels.category), asset=asset.id, pose=rounded_pose(frame @ pose), resting=rest
        )
        for asset, pose in zip(assets, group.poses, strict=True)
    )
    put = PutGroup(name, placements, box_in_world(space.pose, box))
    draw.note(put)
    return put


def rounded_pose(pose: Pose) -> Pose:
    """A pose to a hundredth of a millimetre, so that it is the same on every machine."""
    x, y, z = (decimals(float(c), 5) for c in pose.position)
    w, i, j, k = (decimals(float(c), 7) for c in pose.quaternion)
    return Pose(position=(x, y, z), quaternion=(w, i, j, k))
