"""Objects in the spaces of a kitchen: inside their regions, clear of each other, the same for the same seed."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from casa_assets.core.numeric import rng_for
from casa_assets.layouts.lived_in import arrange, put_objects
from casa_assets.layouts.spaces import (
    Silhouette,
    Space,
    count_of_things,
    find_spaces,
    free_cells,
    largest_box,
    silhouette,
)
from casa_assets.model.asset.asset import Asset, Base, Region
from casa_assets.model.kitchen.scene import Placement, Scene
from casa_assets.model.pose import Pose
from casa_assets.model.registry.rows import Arrangement, Habit, Habits, SpaceKind
from tests.support.asset.assets import rigid_mug, textured_box
from tests.support.asset.box_assets import plain_box

SHELF = SpaceKind(assets=("*",), regions=("*",))
TOP = Region(name="top", pose=Pose(position=(0.0, 0.0, 0.3)), size=(1.0, 0.5, 0.4))
MEMBERS = {"mug": rigid_mug(), "carton": textured_box()}


def member(category: str, number: int) -> Asset:
    assert number >= 0
    return MEMBERS[category]


def habits(**changes: object) -> Habits:
    row = {"about": "", "objects": {"mug": 1, "carton": 1}, "spaces": {"shelf": 1}, "count": (1, 3), "most": 9}
    habit = Habit.model_validate({**row, "theme": "tableware", **changes})
    return Habits(spaces={"shelf": SHELF}, habits={"things": habit})


def shelf(number: int = 1, width: float = 0.8, height: float = 0.3) -> Space:
    pose = Pose(position=(2.0, float(number), 1.0), quaternion=(0.5**0.5, 0.0, 0.0, 0.5**0.5))
    return Space(f"unit_{number}", "object", "level0", ("shelf",), pose, (width, 0.35, height))


def box_of(place: Placement) -> np.ndarray:
    asset = next(a for a in MEMBERS.values() if a.id == place.asset)
    points = np.concatenate([place.pose.apply(v.mesh.vertices) for k in asset.links for v in k.visuals])
    return np.array([points.min(axis=0), points.max(axis=0)])


def test_everything_is_inside_its_space_and_apart() -> None:
    spaces = [shelf(1), shelf(2)]
    first = put_objects(spaces, habits(), member, 12, rng_for(3, "test"))
    more = put_objects(spaces, habits(), member, 2, rng_for(2, "test"), first)
    places = [place for group in (*first, *more) for place in group.placements]
    assert len({place.name for place in places}) == len(places) == 14
    boxes = [box_of(p) for p in places]
    of = {space.placement: space for space in spaces}
    for place, box in zip(places, boxes, strict=True):
        space = of[place.resting.placement]
        local = space.pose.inverse().apply(np.array([[x, y, z] for x, y in box[:, :2] for z in box[:, 2]]))
        width, depth, height = space.size
        assert (np.abs(local[:, :2]) <= (width / 2, depth / 2)).all()
        assert ((local[:, 2] >= 0.0) & (local[:, 2] <= height)).all()
    for one, other in itertools.combinations(boxes, 2):
        assert (one[0] >= other[1] - 1e-4).any() or (other[0] >= one[1] - 1e-4).any()


class TestGroups:
    def test_stack_is_as_close_as_the_shapes_allow(self) -> None:
        carton = silhouette(MEMBERS["carton"])
        group = arrange(Arrangement.STACK, [carton] * 3, rng_for(0, "test"))
        heights = [pose.position[2] for pose in group.poses]
        assert np.diff(heights) == pytest.approx([float(np.ptp(carton.box[:, 2]))] * 2, abs=0.001)

    def test_heap_lies_in_its_vessel(self) -> None:
        mug, pea = silhouette(MEMBERS["mug"]), silhouette(plain_box((0.02, 0.02, 0.02)))
        group = arrange(Arrangement.HEAP, [mug, pea], rng_for(0, "test"))
        vessel, pose = (np.array(p.position) for p in group.poses)
        assert np.abs((pose - vessel)[:2]).max() < mug.box[1, 1]
        assert 0.0 < pose[2] < mug.box[1, 2] - 0.02

    def test_plates_stand_in_slots_between_the_tines(self) -> None:
        box = np.array([[-0.2, -0.16, 0.0], [0.2, 0.16, 0.1]])
        flat = np.zeros((134, 107))
        slots = np.array([[[x, -0.07, 0.02], [x + 0.034, 0.07, 0.09]] for x in (-0.1, -0.06, -0.02)])
        rack = Silhouette(box, flat, flat + 0.02, slots)
        plate = silhouette(plain_box((0.24, 0.24, 0.02)))
        group = arrange(Arrangement.ON_EDGE, [rack, plate, plate], rng_for(0, "test"))
        shift = group.poses[0].position
        edges = np.array([[x, 0.0, z] for x in (-0.12, 0.12) for z in (0.0, 0.02)])
        for pose in group.poses[1:]:
            corners = pose.apply(edges) - shift
            low = corners[corners[:, 2] < 0.09]
            assert any((low[:, 0] > slot[0, 0]).all() and (low[:, 0] < slot[1, 0]).all() for slot in slots)
            assert 0.02 <= corners[:, 2].min() < 0.022
        assert arrange(Arrangement.ON_EDGE, [rack, *[plate] * 4], rng_for(0, "test")) is None
        thick = silhouette(plain_box((0.24, 0.24, 0.04)))
        assert arrange(Arrangement.ON_EDGE, [rack, thick], rng_for(0, "test")) is None

    def test_handle_of_a_pan_is_in_front(self) -> None:
        size = np.array([[-0.2, -0.1, 0.0], [0.2, 0.1, 0.05]])
        low = np.zeros((134, 67))
        low[:67, :30] = low[:67, 37:] = np.inf  # a handle to the left
        pan = Silhouette(size, low, np.where(np.isfinite(low), 0.05, -np.inf))
        assert pan.body == pytest.approx((0.1, 0.0))
        for seed in range(5):
            group = arrange(Arrangement.HANDLE_FRONT, [pan], rng_for(seed, "test"))
            x, y, _ = group.poses[0].rotation @ np.array([-1.0, 0.0, 0.0])
            assert y < -abs(x)
            assert group.body[1] > abs(group.body[0])


def test_other_things_take_their_part_of_a_region() -> None:
    box = plain_box((1.0, 0.5, 0.1))
    table = box.replace(id="table_0123456789", base=Base.FIXED, regions=(TOP,))
    standing = Placement(name="box", asset=box.id, pose=Pose(position=(0.9, 0.0, 0.1)))
    scene = Scene(id="corner", assets=(box, table), placements=(Placement(name="table", asset=table.id), standing))
    (space,) = find_spaces(scene, {"table": SpaceKind(assets=("carton",), regions=("top",))})
    assert (space.placement, space.region) == ("table", "top")
    assert space.taken == (pytest.approx((0.4, -0.25, 1.4, 0.25)),)


def test_habit_with_a_fault_is_refused() -> None:
    for changes, message in [
        ({"spaces": {"shelv": 1}}, "no kind of space 'shelv'"),
        ({"arrangement": "heap"}, "a heap and what stands on edge have a vessel, and nothing else has"),
        ({"arrangement": "stack"}, "only what is alike is stacked"),
        ({"count": (3, 2)}, "the fewest come first"),
    ]:
        with pytest.raises(ValidationError, match=message):
            habits(**changes)


BOARD = Space("unit", "object", "level0", ("shelf",), Pose(position=(1.0, 2.0, 3.0)), (0.8, 0.3, 0.25))


def test_largest_box_is_beside_what_stands_there() -> None:
    space = replace(BOARD, taken=((-0.2, -0.15, 0.05, 0.15), (0.3, 0.1, 0.4, 0.15)))
    size, (x, y) = largest_box(space)
    assert size == pytest.approx((0.35, 0.25, 0.25))
    assert (x, y) == pytest.approx((0.225, -0.025))
    assert count_of_things(space) == 1 * 2 + 3 * 2


@pytest.mark.parametrize("seed", range(6))
def test_largest_box_is_the_best_of_all_rectangles(seed: int) -> None:
    rng = np.random.default_rng(seed)
    small = replace(BOARD, size=(0.14, 0.11, 0.2))
    rects = [(float(x), float(y), float(x + 0.02), float(y + 0.01)) for x, y in rng.uniform(-0.07, 0.06, (4, 2))]
    space = replace(small, taken=tuple(rects))
    free = free_cells(space)
    columns, rows = itertools.combinations(range(15), 2), list(itertools.combinations(range(12), 2))
    every = [(i0, i1, j0, j1) for (i0, i1), (j0, j1) in itertools.product(columns, rows)]
    best = max((i1 - i0) * (j1 - j0) for i0, i1, j0, j1 in every if free[i0:i1, j0:j1].all())
    size, _ = largest_box(space)
    assert round(size[0] * size[1] * 1e4) == best
