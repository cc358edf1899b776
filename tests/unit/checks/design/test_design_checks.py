"""Checks of kitchens' facts, the floor as a grid, where a base parks, how things are put, and a kitchen as built."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from casa_assets.checks.check import run
from casa_assets.checks.design import task_view
from casa_assets.checks.design.floor_map import BASE_RADIUS_M, CELL_M, GAP_M, FloorMap, find_parking
from casa_assets.checks.design.grade import grade
from casa_assets.checks.design.subject import FLOOR, REACHED, DesignSubject, floor_picture, whereabouts
from casa_assets.core.numeric import rng_for
from casa_assets.layouts.floor_facts import facts_of
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import build_scene
from casa_assets.mesh.outline import penetration_depth
from casa_assets.mesh.planar import distance
from casa_assets.model.issue import Status
from casa_assets.model.kitchen.floor import (
    APPLIANCES,
    AisleKind,
    Fixture,
    FixtureRegion,
    Footprint,
    KitchenFacts,
    ParkingSide,
    Role,
    RoomWall,
    SweptArea,
)
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.kitchen.scene import Scene
from casa_assets.model.record import Vec2
from tests.support.asset.examples import between, check_examples
from tests.support.kitchen import reference_kitchen as made
from tests.support.kitchen.reference_kitchen import DOOR, LIMITS, WALLS, changed, kitchen, thing, with_more

Build = Callable[[], KitchenFacts]
ALONE = Footprint(center=(0.3, -2.4), size=(0.5, 0.3), yaw=math.pi / 2)
SHELF = Fixture(name="alone", role=Role.SHELF, category="open_shelf", footprint=ALONE, bottom=0.0, top=1.0)


def swung(reach: float) -> KitchenFacts:
    """A door's leaf that comes so near the refrigerator's front, which ends at y = -0.77: 0 touches it."""
    outline = ((0.0, -2.0), (0.9, -2.0), (0.9, -0.77 + reach), (0.0, -0.77 + reach))
    leaf = SweptArea(outline=outline, open_outline=outline, bottom=0.0, top=0.05, sweeps_front=False)
    return made.kitchen().replace(openings=(made.WINDOW, made.DOOR.replace(swept_area=leaf)))


def named(name: str) -> Fixture:
    return next(f for f in made.kitchen().fixtures if f.name == name)


def crossing(reach: float) -> KitchenFacts:
    washer = named("dishwasher")
    (joint,) = washer.joints
    assert joint.swept_area is not None
    # That of the range ends at y = -0.67 - 0.6.
    swept = ((2.6, -1.9), (4.4, -1.9), (4.4, -1.27 + reach), (2.6, -1.27 + reach))
    moved = joint.replace(swept_area=joint.swept_area.replace(outline=swept))
    return made.changed(made.kitchen(), "dishwasher", washer.replace(joints=(moved,)))


def hung(name: str, low: float) -> KitchenFacts:
    """The hood, or a cabinet in its place, so high over the range, whose top is at 0.915 m."""
    cabinet = made.upper(2.4, 3.2, "over", low=0.915 + low).replace(joints=())
    other = named("hood").replace(bottom=0.915 + low) if name == "hood" else cabinet
    return made.changed(made.kitchen(), "hood", other)


def glazed(length: float) -> KitchenFacts:
    way = made.WINDOW.replace(wall="back", start=(3.208 - length, 0.0), end=(4.2, 0.0))
    return made.kitchen().replace(openings=(way, made.DOOR))


def tasteless(count: int) -> KitchenFacts:
    facts = made.kitchen()
    rows = tuple(r.replace(height=0.96, depth_before=0.6) for r in facts.runs[:2])
    if count > 0:
        facts = made.changed(facts.replace(runs=rows), "hood", None)
    if count > 1:
        facts = made.changed(facts, "microwave", named("microwave").replace(bottom=1.5, top=1.79))
        facts = facts.replace(runs=tuple(r.replace(units=r.units[:4]) for r in facts.runs))
    if count > 2:
        facts = made.with_more(facts, made.upper(0.0, 0.4, "low_one", low=1.1).replace(joints=()))
        facts = made.with_unit(facts, "main", "range", 0.96, 1.8)
    return facts


def shelf(*around: Fixture) -> KitchenFacts:
    return made.with_more(made.kitchen(), SHELF, *around)


def crate(long: float) -> Fixture:
    return made.thing("crate", Role.ON_FLOOR, (0.9, -2.4), (0.5, long), 0.0, 0.3)


def flapped(out: float) -> KitchenFacts:
    """The shelf has a flap across the room, which comes out so far."""
    joint = made.flap(ALONE, "flap_joint", out, 0.1, 0.5)
    assert joint.swept_area is not None
    outline = made.box(ALONE, -1.6, 1.6, 0.0, out)
    moved = joint.replace(swept_area=joint.swept_area.replace(open_outline=outline, outline=outline))
    return made.changed(shelf(), "alone", SHELF.replace(joints=(moved,)))


def crowded(low: float) -> KitchenFacts:
    tops = made.kitchen().with_role(Role.WORKTOP)
    row: dict[str, Any] = {"role": Role.THING, "category": "board", "bottom": low, "top": low + 0.02}
    boards = [Fixture(name=f"board_{k}", footprint=top.footprint, **row) for k, top in enumerate(tops)]
    return made.with_more(made.kitchen(), *boards)


EXAMPLES: dict[str, tuple[Build, Build]] = {
    "NKB001": between(
        lambda n: made.kitchen().replace(openings=(made.WINDOW, made.DOOR.replace(clear_width=n))), 0.814, 0.812
    ),
    "NKB002": between(swung, -0.01, 0.02),
    "NKB003": between(crossing, -0.01, 0.02),
    "NKB004": between(lambda n: made.with_aisle(made.kitchen(), AisleKind.WORK, n), 1.07, 1.06),
    "NKB005": between(lambda n: made.with_aisle(made.kitchen().replace(compact=True), AisleKind.WORK, n), 0.92, 0.91),
    "NKB006": between(lambda n: made.with_aisle(made.kitchen(), AisleKind.WALK, n), 0.92, 0.91),
    "NKB007": between(lambda gap: made.with_unit(made.kitchen(), "right", "dishwasher", 0.65 + gap, 1.95), 0.54, 0.52),
    "NKB008": (lambda: hung("hood", 0.62), lambda: hung("hood", 0.6)),
    "NKB009": (lambda: hung("cabinet", 0.77), lambda: hung("cabinet", 0.75)),
    "NKB010": between(glazed, 0.0, 0.1),
    "NKB011": between(lambda gap: made.with_unit(made.kitchen(), "main", "range", 2.45, 4.35 - gap), 0.39, 0.37),
    "NKB012": between(tasteless, 1, 3),
    "NAV001": (lambda: shelf(crate(0.2)), lambda: shelf(crate(1.6))),
    "NAV002": between(flapped, 0.4, 3.6),
    "NAV003": (
        made.kitchen,
        lambda: made.with_more(made.kitchen(), made.thing("chest", Role.ON_FLOOR, (0.5, -3.3), (0.9, 1.3), 0.0, 0.5)),
    ),
    "TSK001": (made.kitchen, lambda: made.changed(made.kitchen(), "coffee_machine", None)),
    "TSK002": between(crowded, 2.0, 0.921),
}


@pytest.mark.parametrize("code", EXAMPLES)
def test_each_code_is_tripped_by_its_fault_alone(code: str) -> None:
    check_examples(code, *(made.judged(make()) for make in EXAMPLES[code]), parted=True)


def test_all_tasks_are_only_asked_of_plans_that_say_so() -> None:
    facts = made.changed(made.kitchen(), "coffee_machine", None)
    assert [issue.code for issue in made.judged(facts).issues] == ["TSK001"] * 3
    some = facts.replace(all_tasks=False)
    assert {r.code: r.status for r in made.judged(some).results}["TSK001"] is Status.NOT_APPLICABLE
    wants = [t.task for t in DesignSubject(some).tasks if t.wants]
    assert wants == ["coffee_press_button", "coffee_setup_mug", "coffee_serve_mug"]


def test_compact_waives_what_small_kitchens_cannot_keep() -> None:
    facts = made.kitchen()
    short = facts.replace(runs=tuple(r.replace(units=r.units[:4]) for r in facts.runs))
    plain, compact = (grade(DesignSubject(f)) for f in (short, short.replace(compact=True)))
    assert "N25" in {f.rule for f in plain.design if f.passed is False}
    assert not {f.rule for f in plain.design if f.waived}
    assert "N25" in {f.rule for f in compact.design if f.waived}
    assert compact.score > plain.score


def test_grade_has_every_rule_once_with_its_number() -> None:
    found = grade(DesignSubject(made.kitchen()))
    rules = (*found.design, *found.access)
    numbers = {f.rule: f.number for f in rules}
    assert len(rules) == len(numbers) == 40
    assert numbers["N11_long"] == pytest.approx(1.35)  # from the sink to the inside corner
    assert numbers["N13"] == pytest.approx(0.05, abs=0.01)
    assert numbers["A4"] == pytest.approx(0.92)


CLOSED = tuple(wall.replace(is_open=False) for wall in WALLS)


class TestFloor:
    def test_nobody_comes_in_through_a_closet(self) -> None:
        facts = kitchen()
        ways = tuple(o.replace(leads_out=False) for o in facts.openings)
        assert FloorMap(facts.replace(walls=CLOSED)).entries.any()
        assert not FloorMap(facts.replace(walls=CLOSED, openings=ways)).entries.any()

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
        floor = FloorMap(with_more(kitchen(), bar).replace(walls=CLOSED))
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
        (flap,) = (joint.swept_area for joint in named("dishwasher").joints if joint.swept_area)
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
    def zone(self, *taken: task_view.WorldBox, shoulder: Vec2 = (0.5, -0.2)) -> task_view.PlacingZone:
        return task_view.PlacingZone(
            "top", "top", task_view.WorldBox(0.0, 0.0, 1.0, 0.5, 0.92, 1.3), taken, np.array([shoulder])
        )

    def rate(self, zone: task_view.PlacingZone, side: float = 0.1, high: float = 0.1) -> float:
        return task_view.acceptance((zone,), task_view.BoxSizes(side, side, high, high), 200, rng_for(0, "test"))

    def test_share_that_finds_room_within_reach(self) -> None:
        """With a box there: the middle of one of 0.1 m is drawn from 0.9 m, of which 0.5 m are blocked to it."""
        assert self.rate(self.zone()) == 1.0
        found = self.rate(self.zone(task_view.WorldBox(0.0, 0.0, 0.5, 0.5, 0.92, 1.2)))
        assert found == pytest.approx(1 - 0.5 / 0.9, abs=0.08)
        assert self.rate(self.zone(shoulder=(0.5, -0.9))) == 0.0
        assert self.rate(self.zone(), high=0.5) == 0.0
        assert self.rate(self.zone(), side=0.6) == 0.0

    def test_same_seed_same_rate(self) -> None:
        rates = [[t.rate for t in DesignSubject(kitchen(), seed).tasks] for seed in (0, 0, 1)]
        assert rates[0] == rates[1] != rates[2]

    def test_worktops_near_a_fixture_end_where_it_is_far(self) -> None:
        facts = kitchen()
        spans = [span for _, _, span in task_view.worktops_near(facts, named("range"), 0.6)]
        assert [span.x0 for span in spans] == pytest.approx([1.852, 3.21])
        assert [span.x1 for span in spans] == pytest.approx([2.45, 3.808])
        assert len(task_view.worktop_regions(facts)) == 4
        assert sorted(s.x0 for s in task_view.on_worktops(facts)) == pytest.approx([1.1, 3.55])


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
        of_sink = "PickPlaceCounterToSink TurnOnSinkFaucet TurnSinkSpout"
        for name, lost, lost_now in [
            ("upper_double", "open_double_door close_double_door", ""),
            ("sink_basin", "pnp_counter_to_sink pnp_sink_to_counter turn_sink_spout", of_sink),
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

    def test_a_plate_needs_room_beside_or_before_a_microwave_on_a_worktop(self) -> None:
        """The microwave is 0.5 m wide, its front 0.44 m from the wall; it stands at the left end of the worktop."""
        top = named("worktop_0")
        for width, depth, is_afforded in ((0.85, 0.65, False), (0.91, 0.65, True), (0.6, 0.7, True)):
            foot = Footprint(center=(1.1 + width / 2, -depth / 2), size=(width, depth))
            region = top.regions[0].replace(footprint=foot)
            facts = changed(kitchen(), top.name, top.replace(footprint=foot, regions=(region,)))
            found = {t.task: t for t in DesignSubject(facts).atomic_tasks}["PickPlaceCounterToMicrowave"]
            assert bool(found.fixtures) == is_afforded, (width, depth)
            assert ("worktop beside a microwave" in found.wants) != is_afforded, (width, depth)

    def test_bread_goes_into_slots_from_front_to_back(self) -> None:
        place = named("microwave")
        lever = place.joints[0].replace(name="lever_joint")
        for size, is_afforded in (((0.03, 0.14), True), ((0.26, 0.03), False)):
            foot = Footprint(center=place.footprint.center, size=size)
            slot = FixtureRegion(name="slotL", footprint=foot, bottom=0.95, top=1.1)
            toaster = place.replace(name="toaster", role=Role.TOASTER, regions=(slot,), joints=(lever,))
            found = {t.task: t for t in DesignSubject(changed(kitchen(), place.name, toaster)).atomic_tasks}
            assert found["TurnOnToaster"].fixtures == ("toaster",)
            assert bool(found["PickPlaceToasterToCounter"].fixtures) == is_afforded, size


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
    hidden = whereabouts(DesignSubject(kitchen().replace(openings=(), walls=CLOSED)))
    assert hidden["parking"]["fridge"]["shut"] is None
    assert not hidden["tasks"]["open_drawer"]["afforded"]
    assert hidden["tasks"]["open_drawer"]["wants"]


Built = tuple[KitchenRequest, Scene]


@pytest.fixture(scope="module")
def built(cache: Path) -> Built:
    return build_scene(SceneRecipe("l_small", "coastal"), cache)


@pytest.fixture(scope="module")
def facts(built: Built) -> KitchenFacts:
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
    assert run(subject, facts.id, LIMITS).issues == ()
    places = subject.parking.every
    assert {p.fixture for p in places} >= {f.name for f in facts.with_role(*APPLIANCES)}
    for place in places:
        assert distance(facts.with_role(Role.SINK)[0].footprint.corners, np.array([place.position]))[0] > 0.3
