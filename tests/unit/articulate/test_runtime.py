"""What runtimes look for: names, places such as burners and slots, contracts, and state machines."""

from __future__ import annotations

import math

import numpy as np
import pytest

from casa_assets import registry
from casa_assets.articulate.kinds import KIND_NAMES, KIND_TRAITS, kind_named
from casa_assets.articulate.plan import HingeEdge, JointPlan, PartKind
from casa_assets.articulate.runtime.names import PlacedPart, RuntimeName, runtime_names
from casa_assets.articulate.runtime.places import (
    Burner,
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
from casa_assets.articulate.runtime.semantics import annotate_for_runtime, behavior_for, contract_for
from casa_assets.model.asset.asset import Asset, Collider, Joint, JointKind, Link, Region, Site
from casa_assets.model.asset.behavior import BehaviorState, Stimulus, start_behavior, step_behavior
from casa_assets.model.asset.parts import Box, Mesh, Visual
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2, Vec3
from tests.support.asset.articulated_assets import microwave
from tests.support.asset.asset_parts import box_inertial
from tests.unit.articulate.blocks import Part, box, disc, lattice, plan_of, together

SLIDES = frozenset({PartKind.DRAWER, PartKind.BUTTON, PartKind.TRAY})


SMALL = (0.02, 0.02, 0.02)


def at(
    name: str,
    kind: PartKind,
    middle: Vec3,
    size: Vec3 = SMALL,
    edge: HingeEdge | None = None,
    turns: bool | None = None,
) -> PlacedPart:
    """A part of a kind with its middle there."""
    hinged = kind not in SLIDES if turns is None else turns
    moves, endless = JointKind.HINGE if hinged else JointKind.SLIDE, kind is PartKind.TRAY and hinged
    joint = JointPlan(kind=moves, axis=(0, 0, 1), anchor=middle, range=(0, 1), endless=endless, edge=edge)
    return PlacedPart(plan_of(name, kind, np.empty(0, dtype=np.int64), joint), np.array(middle), np.array(size))


BURNERS = tuple(
    Burner(f"{row}_{side}", (x, y, 0.9), 0.08)
    for row, y in (("front", -0.1), ("rear", 0.2))
    for side, x in (("left", -0.2), ("right", 0.2))
)


def knobs(*middles: Vec3) -> list[PlacedPart]:
    return [at(f"k{i}", PartKind.KNOB, middle) for i, middle in enumerate(middles)]


ROW = knobs(*((x, -0.35, 0.8) for x in (-0.3, -0.2, 0.2, 0.3)))
COLUMN = knobs(*((0.35, y, 0.9) for y in (-0.2, -0.1, 0.1, 0.2)))
# With a knob in the middle, which is that of the oven.
FIVE = knobs(*((x, -0.35, 0.8) for x in (-0.3, -0.2, 0.0, 0.2, 0.3)))
ABOVE = knobs(*((0.2, -0.2, 0.3 - 0.05 * i) for i in range(5)))
FOLDS = at("door", PartKind.DOOR, (0, -0.3, 0.4), edge=HingeEdge.BOTTOM)
LEFT, MORE = (
    at(name, PartKind.DOOR, (x, -0.3, 0.5), edge=HingeEdge.LEFT) for name, x in (("left", -0.2), ("more", 0.6))
)
RIGHT = at("right", PartKind.DOOR, (0.2, -0.3, 0.5), edge=HingeEdge.RIGHT)
FLAP = at("flap", PartKind.DOOR, (0.0, -0.3, 0.5), edge=HingeEdge.TOP)
KEYS = [at(name, PartKind.BUTTON, (0.05, -0.15, z)) for name, z in (("high", 0.1), ("low", 0.05))]
WIDE = at("wide", PartKind.BUTTON, (0, -0.1, 0.3), size=(0.05, 0.01, 0.03))
LEVER = at("lever", PartKind.LEVER, (0, -0.15, 0.15), turns=False)
LID, SPOUT = at("lid", PartKind.LID, (0, 0, 0.2)), at("spout", PartKind.SPOUT, (0, 0, 0.3))
(DIAL,) = knobs((0, -0.15, 0.05))
STICKS = [at(name, PartKind.LEVER, (x, 0, 0.1)) for name, x in (("right", 0.1), ("left", -0.1))]
# Parts, category, and the joints that runtimes look for, by part.
NAMED: list[tuple[list[PlacedPart], str, dict[str, str]]] = [
    (ROW, "hob", {"k0": "front_left", "k1": "rear_left", "k2": "rear_right", "k3": "front_right"}),
    (COLUMN, "hob", {"k0": "front_right", "k1": "front_left", "k2": "rear_right", "k3": "rear_left"}),
    # One knob more or less than burners means that a burner, or a knob, was not found.
    (FIVE, "hob", {}),
    (FIVE[:3], "hob", {}),
    (ABOVE[:2], "wall_oven", {"k0": "temp", "k1": "time"}),
    (ABOVE[:3], "toaster_oven", {"k0": "temp", "k1": "function", "k2": "time"}),
    (ABOVE[:1], "wall_oven", {}),
    (ABOVE, "wall_oven", {}),
    ([LEFT, RIGHT], "base_cabinet", {"left": "leftdoorhinge", "right": "rightdoorhinge"}),
    ([RIGHT], "wall_cabinet", {"right": "doorhinge"}),
    (
        [LEFT, RIGHT, MORE],
        "tall_cabinet",
        {"left": "unit0_leftdoorhinge", "right": "rightdoorhinge", "more": "unit1_leftdoorhinge"},
    ),
    ([FLAP], "wall_cabinet", {}),
    ([*KEYS, WIDE], "coffee_machine", {"wide": "start_button"}),
    ([LID, *KEYS], "kettle", {"lid": "lid", "low": "switch", "high": "button_lid"}),
    ([LEVER, *KEYS, DIAL], "toaster", {"lever": "lever", "low": "button_cancel", "k0": "knob_doneness"}),
    ([SPOUT, *STICKS], "sink", {"spout": "spout", "right": "handle", "left": "handle_temp"}),
]


def test_parts_have_the_names_that_runtimes_look_for() -> None:
    for places, category, wanted in NAMED:
        found = {part: name.joint for part, name in runtime_names(places, category, BURNERS).items()}
        stem = "knob_" if category in ("hob", "wall_oven", "toaster_oven") else ""
        joints = {part: w if w.endswith("hinge") else f"{stem}{w}_joint" for part, w in wanted.items()}
        assert found == joints, category
    # The knob in the middle of a range is that of its oven.
    names = runtime_names([*FIVE, FOLDS], "range", BURNERS)
    found = {part: names[part].joint for part in ("k2", "k0", "k4", "door")}
    knob = {"k2": "knob_temp_joint", "k0": "knob_front_left_joint", "k4": "knob_front_right_joint"}
    assert found == knob | {"door": "door_joint"}


def test_the_lowest_keys_of_a_microwave_stop_and_start_it() -> None:
    places = [at(f"b{i}", PartKind.BUTTON, (0.4 + 0.04 * (i % 2), -0.2, 0.2 - 0.04 * (i // 2))) for i in range(4)]
    places += [LEFT, at("disc", PartKind.TRAY, (0, 0, 0.05), turns=True)]
    assert runtime_names(places, "microwave") == {
        "b3": RuntimeName("start_button", "start_button_joint", "start_button"),
        "b2": RuntimeName("stop_button", "stop_button_joint", "stop_button"),
        "left": RuntimeName("door", "microjoint"),
        "disc": RuntimeName("tray", "tray_joint", "tray"),
    }
    assert runtime_names([LEVER, *KEYS], "toaster")["low"].shape == "button_cancel"


BARE = {"states": (), "exclusions": (), "keyframes": (), "behavior": None, "sites": ()}
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


def spot(low: Vec3, high: Vec3) -> tuple[Pose, Vec3]:
    """Pose and size of what is between two corners."""
    a, b = np.array(low), np.array(high)
    return Pose(position=((a + b) / 2).tolist()), tuple((b - a).tolist())


def shape(name: str, low: Vec3, high: Vec3) -> Collider:
    pose, size = spot(low, high)
    return Collider(name=name, shape=Box(size=size), substance="steel", pose=pose)


def link(name: str, boards: Boards, parent: str | None = "object", label: str | None = None) -> Link:
    """A link of boards that are seen and touched alike."""
    seen = mesh(*(box(*b) for b in boards.values()))
    return Link(
        name=name,
        parent=parent,
        inertial=box_inertial(1.0, (0.3, 0.3, 0.3), (0.0, 0.0, 0.0)),
        visuals=(Visual(name=f"{name}_visual", mesh=seen, material="enamel", label=label),),
        colliders=tuple(shape(f"{name}_{n}", *b) for n, b in boards.items()),
    )


def thing(*links: Link, slides: tuple[str, ...] = (), regions: tuple[Region, ...] = ()) -> Asset:
    joints = tuple(
        Joint(name=f"{n}_joint", child=n, kind=JointKind.SLIDE, axis=(0.0, 1.0, 0.0), range=(-0.3, 0.0)) for n in slides
    )
    return microwave().replace(links=links, joints=joints, regions=regions, **BARE)


def region(low: Vec3, high: Vec3, name: str = "room") -> Region:
    pose, size = spot(low, high)
    return Region(name=name, pose=pose, size=size)


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
        asset = hob(FOUR)
        found = {b.loc: b for b in find_burners(asset)}
        assert set(found) == {"front_left", "rear_left", "front_right", "rear_right"}
        assert found["front_left"].middle == pytest.approx((-0.15, -0.12, 0.05), abs=1e-3)
        assert found["front_left"].radius == pytest.approx(0.09, abs=2e-3)
        assert burner_faces(asset.root.visuals[0].mesh, found["front_left"]).sum() == 4 * 24, "within its circle"
        assert "center" in {b.loc for b in find_burners(hob([*FOUR, (0.0, 0.0, 0.05)]))}
        assert len(find_burners(hob([*FOUR, (-0.15, -0.12, 0.05)]))) == 4, "rings in each other are one"
        assert [b.loc for b in find_burners(hob([(-0.15, 0.0, 0.09), (0.15, 0.0, 0.09)]))] == ["left", "right"]
        for places in ([], FOUR[:1], CROWDED):
            assert find_burners(hob(places)) == ()

    def test_rings_with_nothing_inside_are_burners_at_the_height_of_their_rim(self) -> None:
        around = np.linspace(0, 2 * np.pi, 25)
        circle = np.stack([np.cos(around), np.sin(around), 0 * around], axis=1)
        rims = [np.concatenate([circle * 0.08, circle * 0.075]) + np.array([x, y, 0.9]) for x, y, _ in FOUR]
        seen = (Visual(name=f"r{i}", mesh=mesh((rim, lattice(2, 25))), material="enamel") for i, rim in enumerate(rims))
        found = find_burners(thing(hob([]).root.replace(visuals=tuple(seen))))
        assert [b.loc for b in found] == ["front_left", "rear_left", "front_right", "rear_right"]
        assert {b.middle[2] for b in found} == {0.9}

    def test_a_knob_gives_its_burner_a_flame(self) -> None:
        asset = hob(FOUR)
        knob = link("knob_front_left", {"dial": ((-0.22, -0.24, 0.045), (-0.2, -0.22, 0.06))}, label="knob")
        turns = Joint(name="knob_front_left_joint", child=knob.name, kind=JointKind.HINGE, axis=(0, 0, 1), range=(0, 5))
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
        shelf, middle = ((-0.28, -0.28, 0.4), (0.28, 0.28, 0.418)), ((-0.01, -0.28, 0.02), (0.01, 0.28, 0.78))
        asset = thing(link("object", {**CARCASS, "shelf": shelf, "middle": middle}, None))
        found = split_by_shelves(asset, region((-0.279, -0.27, 0.021), (0.279, 0.27, 0.779)))
        boxes = [tuple(np.round(np.concatenate(region_bounds(asset, r))[[0, 3, 2, 5]], 3)) for r in found]
        assert len(found) == 4
        assert boxes[0] == pytest.approx((-0.279, -0.012, 0.02, 0.398), abs=4e-3)
        assert boxes[3] == pytest.approx((0.012, 0.279, 0.418, 0.777), abs=4e-3)
        asset = thing(link("object", CARCASS, None))
        (whole,) = split_by_shelves(asset, region((-0.279, -0.27, 0.021), (0.279, 0.27, 0.779)))
        low, high = region_bounds(asset, whole)
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
        def with_rack(boards: Boards) -> Asset:
            return thing(link("object", CARCASS, None), link("rack0", boards, label="rack"), slides=("rack0",))

        floor, rim = ((-0.25, -0.25, 0.3), (0.25, 0.25, 0.31)), ((-0.25, -0.25, 0.31), (0.25, -0.24, 0.4))
        asset = with_rack({"floor": floor, "rim": rim})
        room = region_over_rack(asset, "rack0", [region((-0.279, -0.27, 0.021), (0.279, 0.27, 0.4))])
        assert room.link == "rack0"
        low, high = region_bounds(asset, room)
        assert (low[2], high[2]) == pytest.approx((0.31, 0.39), abs=1e-3)
        below = region_below_racks(asset, region((-0.279, -0.27, 0.021), (0.279, 0.27, 0.779)))
        assert region_bounds(asset, below)[1][2] == pytest.approx(0.29, abs=1e-3)
        assert region_below_racks(asset, region((-0.279, -0.27, 0.26), (0.279, 0.27, 0.779))) is None
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
        low, high = find_cup_niche(thing(link("object", machine, None)))
        assert (low[2], high[2]) == pytest.approx((0.03, 0.22), abs=3e-3)
        assert (low[0] + high[0]) / 2 == pytest.approx(0.0, abs=3e-3)
        assert -0.15 <= (low[1] + high[1]) / 2 <= 0.0
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
        assert [(low + high)[1] / 2 for low, high in found] == pytest.approx([-0.04, 0.04], abs=3e-3)
        assert [low[2] for low, _ in found] == pytest.approx([0.03, 0.03], abs=3e-3)
        ready = annotate_for_runtime(asset, "toaster")
        assert {"slotL", "slotR"} <= {r.name for r in ready.regions}
        assert {"slotL_floor", "slotR_floor"} <= {c.name for c in ready.root.colliders}
        assert find_toaster_slots(thing(link("object", CARCASS, None))) == []


def test_a_contract_is_aimed_at_by_what_opens() -> None:
    for names, category, contract in [
        (("leftdoorhinge", "rightdoorhinge"), "base_cabinet", "hinge_cabinet"),
        (("doorhinge", "slidejoint"), "wall_cabinet", "single_cabinet"),
        (("drawer0_slidejoint", "drawer1_slidejoint"), "drawer_stack", "drawer"),
        ((), "wall_cabinet", None),
        (("fridge_left_door_joint", "fridge_right_door_joint"), "refrigerator", "fridge_french_door"),
        (("microjoint",), "microwave", "microwave"),
        (("knob_0_joint",), "blender", None),
    ]:
        joints = [
            Joint(name=n, child=f"part{i}", kind=JointKind.HINGE, axis=(0.0, 0.0, 1.0), range=(0.0, 1.5))
            for i, n in enumerate(names)
        ]
        links = [link("object", CARCASS, None), *(link(j.child, {"a": CARCASS["left"]}) for j in joints)]
        assert contract_for(thing(*links).replace(joints=tuple(joints)), category) == contract, names


def operated(joints: dict[str, Vec2], keys: tuple[str, ...] = (), sites: tuple[str, ...] = ()) -> Asset:
    """A body with a link to each joint and a collider to each key."""
    plain = microwave()
    boxes = tuple(Collider(name=k, shape=Box(size=SMALL), substance="steel") for k in keys)
    links = [plain.root.replace(colliders=(*plain.root.colliders, *boxes))]
    moved = []
    for name, span in joints.items():
        child = name.removesuffix("_joint") or "part"
        grip = Collider(name=f"{child}_main", shape=Box(size=SMALL), substance="steel")
        inertial = box_inertial(0.1, SMALL, (0.0, 0.0, 0.0))
        links.append(Link(name=child, parent="object", inertial=inertial, colliders=(grip,)))
        moved.append(Joint(name=name, child=child, kind=JointKind.HINGE, axis=(0.0, 0.0, 1.0), range=span))
    regions = (Region(name="int", size=SMALL), Region(name="fridge_shelf0", size=SMALL))
    bare = BARE | {"sites": tuple(Site(name=s) for s in sites)}
    return plain.replace(links=tuple(links), joints=tuple(moved), regions=regions, **bare)


class Run:
    """A machine that is operated step by step."""

    def __init__(self, asset: Asset, category: str) -> None:
        behavior = behavior_for(asset, category)
        self.machine: BehaviorState = start_behavior(behavior)
        self.joints = {j.name: 0.0 for j in asset.joints}
        self.go()

    def go(self, touched: str = "", steps: int = 3, **moved: float) -> dict[str, str]:
        self.joints |= moved
        for _ in range(steps):
            stimulus = Stimulus(self.joints, frozenset([touched] if touched else []))
            self.machine = step_behavior(self.machine, stimulus, 0.05)
        return dict(self.machine.values)


def test_a_microwave_heats_while_it_is_shut() -> None:
    run = Run(operated({"microjoint": (-1.57, 0.0)}, ("start_button", "stop_button")), "microwave")
    assert run.go() == {"power": "off"}
    assert run.go("start_button") == {"power": "on"}
    assert [(e.kind.value, e.target) for e in run.machine.effects] == [("heat", "int")]
    run.go()
    assert run.go("stop_button") == {"power": "off"}
    run.go()
    run.go("start_button")
    assert run.go(microjoint=-0.4) == {"power": "off"}
    assert run.go("start_button", steps=1) == {"power": "off"}, "not for a moment either"


def test_a_knob_turns_its_burner_low_and_high() -> None:
    joints = {"knob_left_joint": (0.0, 5.24), "knob_right_joint": (0.0, 5.24)}
    run = Run(operated(joints, sites=("burner_on_left", "burner_on_right")), "hob")
    assert run.go(knob_left_joint=0.3) == {"burner_left": "off", "burner_right": "off"}
    assert run.go(knob_left_joint=0.5)["burner_left"] == "low"
    assert run.go(knob_left_joint=math.radians(100)) == {"burner_left": "high", "burner_right": "off"}
    assert {e.target for e in run.machine.effects} == {"burner_on_left"}
    assert run.go(knob_left_joint=0.0)["burner_left"] == "off"


@pytest.mark.parametrize("far", [-1.57, 1.57])
def test_a_fridge_lights_while_one_of_its_doors_is_open(far: float) -> None:
    span = (min(far, 0.0), max(far, 0.0))
    doors = {"fridge_left_door_joint": span, "fridge_right_door_joint": span, "freezer_door_joint": span}
    run = Run(operated(doors, sites=("lamp",)), "refrigerator")
    assert run.go() == {"light": "off"}
    assert run.go(freezer_door_joint=far) == {"light": "off"}
    assert run.go(fridge_right_door_joint=far) == {"light": "on"}
    assert run.go(fridge_right_door_joint=0.002 * far) == {"light": "off"}


def test_the_lever_of_a_toaster_switches_it_on_and_its_key_off() -> None:
    run = Run(operated({"lever_joint": (-0.05, 0.0)}, ("button_cancel",)), "toaster")
    assert run.go(lever_joint=-0.03) == {"power": "off"}
    assert run.go(lever_joint=-0.05) == {"power": "on"}
    assert run.go("button_cancel") == {"power": "off"}
    run.go(lever_joint=0.0)
    assert run.go(lever_joint=-0.05) == {"power": "on"}
    assert run.go(lever_joint=0.0) == {"power": "off"}


def test_a_coffee_machine_pours_and_stops_by_itself() -> None:
    run = Run(operated({}, ("start_button",), ("coffee_liquid",)), "coffee_machine")
    assert run.go("start_button") == {"power": "on"}
    assert {e.kind.value for e in run.machine.effects} == {"show", "flow"}
    assert run.go(steps=200) == {"power": "on"}
    assert run.go(steps=320) == {"power": "off"}


def test_water_runs_by_how_far_the_handle_is_turned() -> None:
    run = Run(operated({"handle_joint": (0.0, 1.57), "handle_temp_joint": (-1.0, 1.0)}, sites=("water",)), "sink")
    assert run.go(handle_joint=0.3) == {"water": "off", "temperature": "cold"}
    assert run.go(handle_joint=0.6, handle_temp_joint=0.9) == {"water": "low", "temperature": "hot"}
    assert run.go(handle_joint=1.4)["water"] == "high"


def test_what_has_no_controls_has_no_states() -> None:
    assert behavior_for(operated({"microjoint": (-1.57, 0.0)}), "microwave") is None
    assert behavior_for(operated({"knob_left_joint": (0.0, 5.0)}), "hob") is None
    assert behavior_for(operated({"doorhinge": (-1.57, 0.0)}), "base_cabinet") is None


def test_whole_words_name_a_kind_and_every_kind_is_a_fixture_of_the_registry() -> None:
    fixtures = registry.load().fixtures
    assert set(KIND_NAMES) | set(KIND_TRAITS) <= set(fixtures)
    for hint, kind in [
        ("kitchenMicrowave", "microwave"),
        ("kitchen-stove_02", "range"),
        ("Fridge freezer", "refrigerator"),
        ("oven", "wall_oven"),
        ("toaster oven", "toaster_oven"),
        ("coffee_maker", "coffee_machine"),
        ("electric kettle", "kettle"),
        ("orange", None),
        ("strange", None),
        ("mesh_0042", None),
    ]:
        found = kind_named([hint])
        assert (found.id if found else None) == kind, hint
