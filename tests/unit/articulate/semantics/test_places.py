"""Burners, cups, slots, shelves and racks: places of a thing, found in what it is made of."""

from __future__ import annotations

import numpy as np
import pytest

from casa_assets.articulate.interior.regions import (
    burner_faces,
    find_burners,
    find_cup_niche,
    find_toaster_slots,
    floor_collider,
    region_below_racks,
    region_bounds,
    region_in_drawer,
    region_over_rack,
    split_by_shelves,
)
from casa_assets.articulate.runtime_semantics import annotate_for_runtime, contract_for
from casa_assets.model.asset.asset import Asset, Collider, Joint, JointKind, Link, Region
from casa_assets.model.asset.parts import Box, Mesh, Visual
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3
from tests.support.asset.articulated_assets import microwave
from tests.support.asset.asset_parts import box_inertial
from tests.unit.articulate.blocks import Part, box, disc, together

Boards = dict[str, tuple[Vec3, Vec3]]
CARCASS: Boards = {
    "left": ((-0.3, -0.3, 0.0), (-0.28, 0.3, 0.8)),
    "right": ((0.28, -0.3, 0.0), (0.3, 0.3, 0.8)),
    "floor": ((-0.28, -0.3, 0.0), (0.28, 0.3, 0.02)),
    "roof": ((-0.28, -0.3, 0.78), (0.28, 0.3, 0.8)),
    "back": ((-0.28, 0.28, 0.02), (0.28, 0.3, 0.78)),
}


def mesh(*parts: Part) -> Mesh:
    vertices, faces, _ = together(*parts)
    return Mesh(vertices=vertices, faces=faces)


def shape(name: str, low: Vec3, high: Vec3) -> Collider:
    a, b = np.array(low), np.array(high)
    x, y, z = (a + b) / 2
    size = tuple(float(s) for s in b - a)
    return Collider(name=name, shape=Box(size=size), substance="steel", pose=Pose(position=(x, y, z)))


def link(name: str, boards: Boards, parent: str | None = "object", label: str | None = None) -> Link:
    """A link of boards that are seen and touched alike."""
    return Link(
        name=name,
        parent=parent,
        inertial=box_inertial(1.0, (0.3, 0.3, 0.3), (0.0, 0.0, 0.0)),
        visuals=(
            Visual(
                name=f"{name}_visual", mesh=mesh(*(box(*b) for b in boards.values())), material="enamel", label=label
            ),
        ),
        colliders=tuple(shape(f"{name}_{n}", *b) for n, b in boards.items()),
    )


def thing(*links: Link, slides: tuple[str, ...] = (), regions: tuple[Region, ...] = ()) -> Asset:
    joints = tuple(
        Joint(name=f"{n}_joint", child=n, kind=JointKind.SLIDE, axis=(0.0, 1.0, 0.0), range=(-0.3, 0.0)) for n in slides
    )
    bare = {"states": (), "exclusions": (), "keyframes": (), "behavior": None, "sites": ()}
    return microwave().replace(links=links, joints=joints, regions=regions, **bare)


def region(low: Vec3, high: Vec3, name: str = "room") -> Region:
    a, b = np.array(low), np.array(high)
    x, y, z = (a + b) / 2
    return Region(name=name, pose=Pose(position=(x, y, z)), size=tuple(float(s) for s in b - a))


def upright(part: Part) -> Part:
    """A disc that stands on its rim, laid flat: its front is its top."""
    points, faces = part
    return np.stack([points[:, 0], points[:, 2], -points[:, 1]], axis=1), faces


def hob(places: list[tuple[float, float, float]]) -> Asset:
    rings = [upright(disc((x, -0.05, y), r, 0.004)) for x, y, r in places]
    root = link("object", {"plate": ((-0.3, -0.25, 0.0), (0.3, 0.25, 0.045))}, None)
    body = mesh(box((-0.3, -0.25, 0.0), (0.3, 0.25, 0.045)), *rings)
    return thing(root.replace(visuals=(root.visuals[0].replace(mesh=body),)))


FOUR = [(-0.15, -0.12, 0.09), (-0.15, 0.12, 0.07), (0.15, -0.12, 0.07), (0.15, 0.12, 0.09)]
# Two of them are at the front, on the left.
CROWDED = [*((x, y, 0.04) for x, y, _ in FOUR), (-0.12, -0.05, 0.03)]


class TestBurners:
    def test_each_is_named_by_its_place(self) -> None:
        found = {b.loc: b for b in find_burners(hob(FOUR))}
        assert set(found) == {"front_left", "rear_left", "front_right", "rear_right"}
        assert found["front_left"].middle == pytest.approx((-0.15, -0.12, 0.05), abs=1e-3)
        assert found["front_left"].radius == pytest.approx(0.09, abs=2e-3)

    def test_a_place_may_be_the_centre_and_rings_in_each_other_are_one(self) -> None:
        assert "center" in {b.loc for b in find_burners(hob([*FOUR, (0.0, 0.0, 0.05)]))}
        assert len(find_burners(hob([*FOUR, (-0.15, -0.12, 0.05)]))) == 4
        assert [b.loc for b in find_burners(hob([(-0.15, 0.0, 0.09), (0.15, 0.0, 0.09)]))] == ["left", "right"]

    def test_none_where_their_places_cannot_be_told(self, subtests: pytest.Subtests) -> None:
        for places in [[], FOUR[:1], CROWDED]:
            with subtests.test(places=places):
                assert find_burners(hob(places)) == ()

    def test_what_is_seen_of_one_is_within_its_circle(self) -> None:
        asset = hob(FOUR)
        burner = find_burners(asset)[0]
        own = burner_faces(asset.root.visuals[0].mesh, burner)
        assert own.sum() == 4 * 24

    def test_a_knob_gives_its_burner_a_flame(self) -> None:
        asset = hob(FOUR)
        knob = link("knob_front_left", {"dial": ((-0.22, -0.24, 0.045), (-0.2, -0.22, 0.06))}, label="knob")
        turns = Joint(
            name="knob_front_left_joint",
            child="knob_front_left",
            kind=JointKind.HINGE,
            axis=(0.0, 0.0, 1.0),
            range=(0.0, 5.0),
        )
        asset = asset.replace(links=(asset.root, knob), joints=(turns,))
        ready = annotate_for_runtime(asset, "hob", find_burners(asset))
        assert [s.name for s in ready.sites] == ["burner_on_front_left", "burner_front_left_place_site"]
        assert [v.label for v in ready.root.visuals] == ["burner", None]
        assert sum(len(v.mesh.faces) for v in ready.root.visuals) == len(asset.root.visuals[0].mesh.faces)
        assert ready.contract == "stovetop"
        assert [k.name for k in ready.keyframes] == ["closed", "on"]
        assert ready.behavior is not None


class TestRooms:
    def test_shelves_and_boards_part_a_room(self) -> None:
        boards = {
            **CARCASS,
            "shelf": ((-0.28, -0.28, 0.4), (0.28, 0.28, 0.418)),
            "middle": ((-0.01, -0.28, 0.02), (0.01, 0.28, 0.78)),
        }
        asset = thing(link("object", boards, None))
        found = split_by_shelves(asset, region((-0.279, -0.27, 0.021), (0.279, 0.27, 0.779)))
        boxes = [tuple(np.round(np.concatenate(region_bounds(asset, r))[[0, 3, 2, 5]], 3)) for r in found]
        assert len(found) == 4
        assert boxes[0] == pytest.approx((-0.279, -0.012, 0.02, 0.398), abs=4e-3)
        assert boxes[3] == pytest.approx((0.012, 0.279, 0.418, 0.777), abs=4e-3)

    def test_an_empty_room_stays_whole(self) -> None:
        asset = thing(link("object", CARCASS, None))
        (found,) = split_by_shelves(asset, region((-0.279, -0.27, 0.021), (0.279, 0.27, 0.779)))
        low, high = region_bounds(asset, found)
        assert low == pytest.approx([-0.279, -0.27, 0.02], abs=2e-3)
        assert high == pytest.approx([0.279, 0.27, 0.777], abs=2e-3)

    def test_a_room_found_in_a_thick_post_is_sought_behind_the_doors(self) -> None:
        boards = {**CARCASS, "post": ((-0.04, -0.3, 0.02), (0.04, 0.28, 0.78))}
        doors = [
            link("leftdoor", {"a": ((-0.3, -0.32, 0.0), (-0.001, -0.301, 0.8))}, label="door"),
            link("rightdoor", {"a": ((0.001, -0.32, 0.0), (0.3, -0.301, 0.8))}, label="door"),
        ]
        asset = thing(link("object", boards, None), *doors, slides=("leftdoor", "rightdoor"))
        found = split_by_shelves(asset, region((-0.04, -0.27, 0.3), (0.04, 0.27, 0.5)))
        ends = [(region_bounds(asset, r)[0][0], region_bounds(asset, r)[1][0]) for r in found]
        assert ends == [pytest.approx((-0.278, -0.042), abs=3e-3), pytest.approx((0.042, 0.278), abs=3e-3)]
        assert region_bounds(asset, found[0])[0][2] == pytest.approx(0.02, abs=1e-3)

    def test_what_is_over_a_rack_moves_with_it(self) -> None:
        rack = {"floor": ((-0.25, -0.25, 0.3), (0.25, 0.25, 0.31)), "rim": ((-0.25, -0.25, 0.31), (0.25, -0.24, 0.4))}
        asset = thing(link("object", CARCASS, None), link("rack0", rack, label="rack"), slides=("rack0",))
        room = region_over_rack(asset, "rack0", [region((-0.279, -0.27, 0.021), (0.279, 0.27, 0.4))])
        assert room is not None
        assert room.link == "rack0"
        low, high = region_bounds(asset, room)
        assert (low[2], high[2]) == pytest.approx((0.31, 0.39), abs=1e-3)
        below = region_below_racks(asset, region((-0.279, -0.27, 0.021), (0.279, 0.27, 0.779)))
        assert below is not None
        assert region_bounds(asset, below)[1][2] == pytest.approx(0.29, abs=1e-3)
        assert region_below_racks(asset, region((-0.279, -0.27, 0.26), (0.279, 0.27, 0.779))) is None

    def test_nothing_lies_over_a_rack_that_is_a_wire(self) -> None:
        wire = {"wire": ((-0.0003, -0.0003, 0.3), (0.0003, 0.0003, 0.302))}
        asset = thing(link("object", CARCASS, None), link("rack0", wire, label="rack"), slides=("rack0",))
        assert region_over_rack(asset, "rack0", [region((-0.279, -0.27, 0.021), (0.279, 0.27, 0.4))]) is None

    def test_a_drawer_holds_what_lies_on_its_floor(self) -> None:
        tub = {
            "floor": ((-0.2, -0.25, 0.3), (0.2, 0.2, 0.31)),
            "left": ((-0.2, -0.25, 0.31), (-0.19, 0.2, 0.42)),
            "front": ((-0.25, -0.27, 0.28), (0.25, -0.25, 0.45)),
        }
        asset = thing(link("object", CARCASS, None), link("drawer", tub, label="drawer"), slides=("drawer",))
        room = region_in_drawer(asset, "drawer")
        assert room is not None
        assert region_bounds(asset, room)[0][2] == pytest.approx(0.31, abs=1e-3)
        solid = {"block": ((-0.2, -0.25, 0.3), (0.2, 0.2, 0.45))}
        asset = thing(link("object", CARCASS, None), link("drawer", solid, label="drawer"), slides=("drawer",))
        assert region_in_drawer(asset, "drawer") is None

    def test_the_floor_of_a_microwave_is_its_tray(self) -> None:
        asset = thing(link("object", CARCASS, None))
        room = region((-0.279, -0.27, 0.02), (0.279, 0.27, 0.779), "door_0_int")
        assert floor_collider(asset, room) == "object_floor"
        ready = annotate_for_runtime(
            asset.replace(regions=(region((-0.3, -0.3, 0), (0.3, 0.3, 0.8), "main"), room)), "microwave"
        )
        assert "tray" in [c.name for c in ready.root.colliders]
        assert {"main", "int", "tray"} == {r.name for r in ready.regions}


class TestHollows:
    def test_a_cup_stands_under_what_pours(self) -> None:
        machine = {
            "back": ((-0.1, 0.0, 0.0), (0.1, 0.15, 0.35)),
            "head": ((-0.1, -0.15, 0.22), (0.1, 0.0, 0.35)),
            "foot": ((-0.1, -0.15, 0.0), (0.1, 0.0, 0.03)),
            "left": ((-0.1, -0.15, 0.03), (-0.09, 0.0, 0.22)),
            "right": ((0.09, -0.15, 0.03), (0.1, 0.0, 0.22)),
        }
        place = find_cup_niche(thing(link("object", machine, None)))
        assert place is not None
        assert place.lower[2] == pytest.approx(0.03, abs=3e-3)
        assert place.upper[2] == pytest.approx(0.22, abs=3e-3)
        assert place.middle[0] == pytest.approx(0.0, abs=3e-3)
        assert -0.15 <= place.middle[1] <= 0.0
        assert find_cup_niche(thing(link("object", {"block": machine["back"]}, None))) is None

    def test_slots_are_long_and_narrow_and_deep(self) -> None:
        walls = {
            "floor": ((-0.15, -0.09, 0.0), (0.15, 0.09, 0.03)),
            "front": ((-0.15, -0.09, 0.03), (0.15, -0.06, 0.2)),
            "middle": ((-0.15, -0.02, 0.03), (0.15, 0.02, 0.2)),
            "back": ((-0.15, 0.06, 0.03), (0.15, 0.09, 0.2)),
            "left": ((-0.15, -0.06, 0.03), (-0.08, 0.06, 0.2)),
            "right": ((0.08, -0.06, 0.03), (0.15, 0.06, 0.2)),
        }
        asset = thing(link("object", walls, None))
        found = find_toaster_slots(asset)
        assert [h.middle[1] for h in found] == pytest.approx([-0.04, 0.04], abs=3e-3)
        assert [h.lower[2] for h in found] == pytest.approx([0.03, 0.03], abs=3e-3)
        ready = annotate_for_runtime(asset, "toaster")
        assert {"slotL", "slotR"} <= {r.name for r in ready.regions}
        assert {"slotL_floor", "slotR_floor"} <= {c.name for c in ready.root.colliders}
        assert find_toaster_slots(thing(link("object", CARCASS, None))) == []


def test_a_contract_is_aimed_at_by_what_opens(subtests: pytest.Subtests) -> None:
    for names, category, contract in [
        (("leftdoorhinge", "rightdoorhinge"), "base_cabinet", "hinge_cabinet"),
        (("doorhinge", "slidejoint"), "wall_cabinet", "single_cabinet"),
        (("drawer0_slidejoint", "drawer1_slidejoint"), "drawer_stack", "drawer"),
        ((), "wall_cabinet", None),
        (("fridge_left_door_joint", "fridge_right_door_joint"), "refrigerator", "fridge_french_door"),
        (("microjoint",), "microwave", "microwave"),
        (("knob_0_joint",), "blender", None),
    ]:
        with subtests.test(names=names, category=category, contract=contract):
            links = [
                link("object", CARCASS, None),
                *(link(f"part{i}", {"a": CARCASS["left"]}) for i in range(len(names))),
            ]
            joints = tuple(
                Joint(name=n, child=f"part{i}", kind=JointKind.HINGE, axis=(0.0, 0.0, 1.0), range=(0.0, 1.5))
                for i, n in enumerate(names)
            )
            assert contract_for(thing(*links).replace(joints=joints), category) == contract
