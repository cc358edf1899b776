"""The floor as a grid, where a base parks, how things are put, and facts of a kitchen of the registry as built."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from casa_assets.checks.check import run
from casa_assets.checks.design.floor_map import BASE_RADIUS_M, CELL_M, GAP_M, FloorMap, find_parking
from casa_assets.checks.design.subject import FLOOR, REACHED, DesignSubject, floor_picture, whereabouts
from casa_assets.checks.design.task_view import (
    BoxSizes,
    PlacingZone,
    WorldBox,
    acceptance,
    on_worktops,
    worktop_regions,
    worktops_near,
)
from casa_assets.core.numeric import rng_for
from casa_assets.layouts.floor_facts import facts_of
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import build_scene
from casa_assets.mesh.outline import penetration_depth
from casa_assets.mesh.planar import distance
from casa_assets.model.kitchen.floor import (
    APPLIANCES,
    FixtureRegion,
    Footprint,
    KitchenFacts,
    ParkingSide,
    Role,
    RoomWall,
)
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.kitchen.scene import Scene
from casa_assets.model.record import Vec2
from tests.support.kitchen.reference_kitchen import DOOR, LIMITS, WALLS, changed, kitchen, thing, with_more


class TestFloor:
    def test_nobody_comes_in_through_a_closet(self) -> None:
        facts = kitchen()
        closed = tuple(w.replace(is_open=False) for w in facts.walls)
        ways = tuple(o.replace(leads_out=False) for o in facts.openings)
        assert FloorMap(facts.replace(walls=closed)).entries.any()
        assert not FloorMap(facts.replace(walls=closed, openings=ways)).entries.any()

    def test_walls_end_at_a_corner_that_points_into_the_room(self) -> None:
        """They close the corners round the room, and stand nowhere on its floor."""
        outline = ((0.0, 0.0), (2.0, 0.0), (2.0, -1.0), (1.0, -1.0), (1.0, -2.0), (0.0, -2.0))
        ends = zip(outline, (*outline[1:], outline[0]), strict=True)
        walls = tuple(RoomWall(id=f"wall_{k}", start=a, end=b) for k, (a, b) in enumerate(ends))
        floor = FloorMap(kitchen().replace(outline=outline, walls=walls, openings=(), runs=(), fixtures=()))
        assert not (floor.solid & floor.room).any()
        assert floor.holds(floor.solid, (2.05, 0.05))

    def test_floor_near_what_stands_is_taken_and_what_is_cut_off_is_not_reached(self) -> None:
        near, front = FloorMap(kitchen()), -0.65
        assert near.holds(near.reached, (2.0, front - BASE_RADIUS_M - 2 * CELL_M))
        assert not near.holds(near.free, (2.0, front - BASE_RADIUS_M + 2 * CELL_M))
        bar = thing("bar", Role.ON_FLOOR, (2.5, -2.2), (5.0, 0.3), 0.0, 0.9)
        closed = tuple(w.replace(is_open=False) for w in kitchen().walls)
        floor = FloorMap(with_more(kitchen(), bar).replace(walls=closed))
        assert floor.holds(floor.reached, (2.0, -3.0))
        assert floor.holds(floor.free, (2.0, -1.3))
        assert not floor.holds(floor.reached, (2.0, -1.3))

    def test_what_the_base_passes(self, subtests: pytest.Subtests) -> None:
        for kind, passed in ((OpeningKind.PASSAGE, True), (OpeningKind.DOOR, False)):
            floor = FloorMap(kitchen().replace(openings=(DOOR.replace(kind=kind),)))
            assert floor.holds(floor.solid, (-0.05, -3.35)) is not passed
        for low, high, blocks in [(0.0, 0.02, False), (0.0, 0.2, True), (1.0, 1.4, False)]:
            with subtests.test(low=low, high=high, blocks=blocks):
                floor = FloorMap(with_more(kitchen(), thing("rug", Role.ON_FLOOR, (2.5, -2.5), (0.8, 0.8), low, high)))
                assert floor.holds(floor.free, (2.5, -2.5)) is not blocks


class TestParking:
    def test_base_stands_before_a_worktop_and_a_door_and_beside_a_flap(self) -> None:
        facts = kitchen()
        lots = find_parking(facts, FloorMap(facts))
        place = lots.shut["main_drawers"]
        assert place is not None
        assert place.position == pytest.approx((2.1, -0.65 - GAP_M - BASE_RADIUS_M))
        assert place.yaw == pytest.approx(math.pi / 2, abs=1e-4)
        assert (place.side, place.offset) == (ParkingSide.FRONT, 0.0)
        washer, fridge = lots.open["dishwasher", "door_joint"], lots.open["fridge", "door_joint"]
        assert washer is not None
        assert fridge is not None
        assert washer.side in (ParkingSide.LEFT, ParkingSide.RIGHT)
        (flap,) = (j.swept_area for f in facts.fixtures if f.name == "dishwasher" for j in f.joints if j.swept_area)
        assert distance(flap.open_outline, np.array([washer.position]))[0] > BASE_RADIUS_M
        assert fridge.side is ParkingSide.FRONT

    def test_base_stands_behind_a_drawer_with_no_room_beside(self) -> None:
        left = thing("left", Role.ON_FLOOR, (1.4, -1.2), (0.5, 0.9), 0.0, 0.3)
        right = thing("right", Role.ON_FLOOR, (2.85, -1.2), (0.6, 0.9), 0.0, 0.3)
        facts = with_more(kitchen(), left, right)
        place = find_parking(facts, FloorMap(facts)).open["main_drawers", "drawer2_slidejoint"]
        assert place is not None
        assert place.side is ParkingSide.BEHIND
        assert place.position[1] < -0.6 - 0.5 - BASE_RADIUS_M


class TestPutting:
    def zone(self, *taken: WorldBox, shoulder: Vec2 = (0.5, -0.2)) -> PlacingZone:
        return PlacingZone("top", "top", WorldBox(0.0, 0.0, 1.0, 0.5, 0.92, 1.3), taken, np.array([shoulder]))

    def rate(self, zone: PlacingZone, side: float = 0.1, high: float = 0.1) -> float:
        return acceptance((zone,), BoxSizes(side, side, high, high), 200, rng_for(0, "test"))

    def test_share_that_finds_room_within_reach(self) -> None:
        """With a box there: the middle of one of 0.1 m is drawn from 0.9 m, of which 0.5 m are blocked to it."""
        assert self.rate(self.zone()) == 1.0
        found = self.rate(self.zone(WorldBox(0.0, 0.0, 0.5, 0.5, 0.92, 1.2)))
        assert found == pytest.approx(1 - 0.5 / 0.9, abs=0.08)
        assert self.rate(self.zone(shoulder=(0.5, -0.9))) == 0.0
        assert self.rate(self.zone(), high=0.5) == 0.0
        assert self.rate(self.zone(), side=0.6) == 0.0

    def test_same_seed_same_rate(self) -> None:
        rates = [[t.rate for t in DesignSubject(kitchen(), seed).tasks] for seed in (0, 0, 1)]
        assert rates[0] == rates[1] != rates[2]

    def test_worktops_near_a_fixture_end_where_it_is_far(self) -> None:
        facts = kitchen()
        stove = next(f for f in facts.fixtures if f.name == "range")
        spans = [span for _, _, span in worktops_near(facts, stove, 0.6)]
        assert [span.x0 for span in spans] == pytest.approx([1.852, 3.21])
        assert [span.x1 for span in spans] == pytest.approx([2.45, 3.808])
        assert len(worktop_regions(facts)) == 4
        assert sorted(s.x0 for s in on_worktops(facts)) == pytest.approx([1.1, 3.55])


class TestTasks:
    def test_names_are_those_of_scene_files_and_of_robocasas_classes(self) -> None:
        subject = DesignSubject(kitchen())
        found = {t.task: t for t in subject.tasks}
        assert len(found) == 25
        assert found["open_drawer"].joints == ("main_drawers__drawer2_slidejoint", "main_drawers_2__drawer2_slidejoint")
        assert found["turn_on_stove"].sites == ("range__burner_on_front_left", "range__burner_front_left_place_site")
        assert found["open_double_door"].fixtures == ("upper_double",)
        assert found["navigate_kitchen"].rate is None
        atomic = {t.task: t for t in subject.atomic_tasks}
        assert len(atomic) == 65
        assert atomic["OpenDrawer"].fixtures == ("main_drawers", "main_drawers_2")
        assert atomic["TurnOnStove"].fixtures == ("range",)
        assert "a blender" in atomic["TurnOnBlender"].wants
        assert atomic["TurnOnBlender"].fixtures == ()

    def test_what_is_taken_out_takes_its_tasks_along(self, subtests: pytest.Subtests) -> None:
        before = {t.task for t in DesignSubject(kitchen()).atomic_tasks if t.fixtures}
        for name, lost, lost_now in [
            ("upper_double", "open_double_door close_double_door", ""),
            (
                "sink_basin",
                "pnp_counter_to_sink pnp_sink_to_counter turn_sink_spout",
                "PickPlaceCounterToSink TurnOnSinkFaucet TurnSinkSpout",
            ),
            ("range", "turn_on_stove pnp_stove_to_counter", "TurnOnStove LowerHeat PickPlaceStoveToCounter"),
            ("microwave", "turn_on_microwave pnp_microwave_to_counter", "TurnOnMicrowave PickPlaceMicrowaveToCounter"),
        ]:
            with subtests.test(name=name):
                subject = DesignSubject(changed(kitchen(), name, None))
                found = {t.task for t in subject.tasks if t.wants}
                assert set(lost.split()) <= found
                assert "navigate_kitchen" not in found
                after = {t.task for t in subject.atomic_tasks if t.fixtures}
                assert set(lost_now.split()) <= before - after
                assert "OpenDrawer" in after

    def test_drawer_wants_floor_beside_it(self) -> None:
        places = enumerate((1.45, 2.83, 4.1))
        boxes = [thing(f"box_{k}", Role.ON_FLOOR, (x, -1.3), (0.35, 0.7), 0.0, 0.3) for k, x in places]
        found = {t.task: t for t in DesignSubject(with_more(kitchen(), *boxes)).tasks}
        assert found["open_drawer"].joints == ()
        assert "free floor" in found["open_drawer"].wants

    @pytest.mark.parametrize(
        ("width", "depth", "is_afforded"), [(0.85, 0.65, False), (0.91, 0.65, True), (0.6, 0.7, True)]
    )
    def test_a_plate_needs_room_beside_or_before_a_microwave_on_a_worktop(
        self, width: float, depth: float, is_afforded: bool
    ) -> None:
        """The microwave is 0.5 m wide, its front 0.44 m from the wall; it stands at the left end of the worktop."""
        top = next(f for f in kitchen().fixtures if f.name == "worktop_0")
        foot = Footprint(center=(1.1 + width / 2, -depth / 2), size=(width, depth))
        region = top.regions[0].replace(footprint=foot)
        facts = changed(kitchen(), top.name, top.replace(footprint=foot, regions=(region,)))
        found = {t.task: t for t in DesignSubject(facts).atomic_tasks}["PickPlaceCounterToMicrowave"]
        assert bool(found.fixtures) == is_afforded
        assert ("worktop beside a microwave" in found.wants) != is_afforded

    @pytest.mark.parametrize(("size", "is_afforded"), [((0.03, 0.14), True), ((0.26, 0.03), False)])
    def test_bread_goes_into_slots_from_front_to_back(self, size: Vec2, is_afforded: bool) -> None:
        place = next(f for f in kitchen().fixtures if f.name == "microwave")
        foot = Footprint(center=place.footprint.center, size=size)
        slot = FixtureRegion(name="slotL", footprint=foot, bottom=0.95, top=1.1)
        lever = place.joints[0].replace(name="lever_joint")
        toaster = place.replace(name="toaster", role=Role.TOASTER, regions=(slot,), joints=(lever,))
        found = {t.task: t for t in DesignSubject(changed(kitchen(), place.name, toaster)).atomic_tasks}
        assert found["TurnOnToaster"].fixtures == ("toaster",)
        assert bool(found["PickPlaceToasterToCounter"].fixtures) == is_afforded


def test_picture_shows_the_floor_that_is_reached() -> None:
    picture = floor_picture(DesignSubject(kitchen()))
    colours = {colour: count for count, colour in picture.getcolors(maxcolors=1 << 16) or []}
    assert colours[REACHED] > 0.3 * picture.width * picture.height
    assert colours[FLOOR] > 0


def test_whereabouts_are_json_with_a_place_for_every_fixture_and_leaf() -> None:
    subject = DesignSubject(kitchen())
    told = json.loads(json.dumps(whereabouts(subject)))
    assert told["parking"]["fridge"]["shut"]["side"] == "front"
    assert set(told["parking"]["upper_double"]["open"]) == {"leftdoorhinge", "rightdoorhinge"}
    assert len(told["tasks"]) == 25
    assert all(task["afforded"] == ("wants" not in task) for task in told["tasks"].values())
    drawers = told["tasks"]["open_drawer"]
    assert drawers["afforded"]
    assert {name.split("__")[0] for name in drawers["joints"]} == set(drawers["fixtures"])
    closed = tuple(w.replace(is_open=False) for w in WALLS)
    hidden = whereabouts(DesignSubject(kitchen().replace(openings=(), walls=closed)))
    assert hidden["parking"]["fridge"]["shut"] is None
    assert not hidden["tasks"]["open_drawer"]["afforded"]
    assert hidden["tasks"]["open_drawer"]["wants"]


@pytest.fixture(scope="module")
def built(cache: Path) -> tuple[KitchenRequest, Scene]:
    return build_scene(SceneRecipe("l_small", "coastal"), cache)


@pytest.fixture(scope="module")
def facts(built: tuple[KitchenRequest, Scene]) -> KitchenFacts:
    return facts_of(*built)


def test_every_placement_is_a_fixture_and_facts_repeat(
    built: tuple[KitchenRequest, Scene], facts: KitchenFacts
) -> None:
    assert [f.name for f in facts.fixtures] == [p.name for p in built[1].placements]
    for role in (Role.SINK, Role.FRIDGE, Role.DISHWASHER, Role.MICROWAVE, Role.COFFEE_MACHINE, Role.WORKTOP):
        assert facts.with_role(role), role
    assert facts.with_role(Role.RANGE, Role.HOB)
    assert facts_of(*built).to_json() == facts.to_json()
    assert KitchenFacts.from_json(facts.to_json()) == facts


def test_what_was_built_faces_the_room_in_the_slot_that_was_planned_for_it(facts: KitchenFacts) -> None:
    for fixture in facts.with_role(*APPLIANCES, Role.CABINET, Role.DRAWERS):
        row = facts.run(fixture.run)
        assert row is not None
        assert math.cos(fixture.footprint.yaw - row.yaw) == pytest.approx(1.0, abs=1e-6), fixture.name
        assert row.to_local(fixture.footprint.at(0.0, 0.0))[1] > row.to_local(fixture.footprint.center)[1]
    on_floor = [f for f in facts.fixtures if f.bottom < 0.2 and f.role is not Role.TRIM]
    units = [(row, unit) for row in facts.runs for unit in row.units]
    for row, unit, fixture in ((row, unit, f) for row, unit in units for f in on_floor if f.unit == unit.name):
        middle, half = row.to_local(fixture.footprint.center)[0], fixture.footprint.size[0] / 2
        assert unit.left - 1e-3 <= middle - half, fixture.name
        assert middle + half <= unit.right + 1e-3, fixture.name


def test_leaves_begin_at_their_fixture_and_reach_out_of_it(facts: KitchenFacts) -> None:
    for fixture in facts.fixtures:
        for leaf in (joint.swept_area for joint in fixture.joints if joint.swept_area is not None):
            assert penetration_depth(leaf.outline, fixture.footprint.corners) > -0.05, fixture.name
            assert penetration_depth(leaf.outline, leaf.open_outline) > 0.0
            assert leaf.bottom < leaf.top
    washer = facts.with_role(Role.DISHWASHER)[0]
    flap = washer.joint("door_joint")
    assert flap is not None
    assert flap.swept_area is not None
    assert flap.swept_area.sweeps_front
    assert max(washer.footprint.to_local(p)[1] for p in flap.swept_area.open_outline) == pytest.approx(0.68, abs=0.12)


def test_knobs_and_keys_have_no_leaf_and_a_door_is_less_clear_than_its_hole(facts: KitchenFacts) -> None:
    small = [j for f in facts.fixtures for j in f.joints if j.name.startswith("knob") or "button" in j.name]
    assert small
    assert [j.name for j in small if j.swept_area is not None] == []
    doors = [w for w in facts.openings if w.kind is OpeningKind.DOOR]
    assert doors
    for way in doors:
        assert 0.08 < math.dist(way.start, way.end) - way.clear_width < 0.15
        assert way.swept_area is not None


def test_what_the_checks_say(facts: KitchenFacts) -> None:
    """It is reached everywhere, with each of its doors open, and has what every task wants."""
    subject = DesignSubject(facts)
    report = run(subject, facts.id, LIMITS)
    assert report.issues == ()
    places = subject.parking.every
    assert {p.fixture for p in places} >= {f.name for f in facts.with_role(*APPLIANCES)}
    for place in places:
        assert distance(facts.with_role(Role.SINK)[0].footprint.corners, np.array([place.position]))[0] > 0.3
