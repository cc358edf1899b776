"""Facts of a kitchen of the registry, as it is built, and what the checks say of them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from casa_assets.checks.check import run
from casa_assets.checks.design.subject import DesignSubject
from casa_assets.layouts.floor_facts import facts_of
from casa_assets.layouts.order.build_order import KitchenRequest
from casa_assets.layouts.run.recipe import SceneRecipe
from casa_assets.layouts.run.resolve import build_scene
from casa_assets.mesh.outline import penetration_depth
from casa_assets.mesh.planar import distance
from casa_assets.model.kitchen.floor import APPLIANCES, KitchenFacts, Role
from casa_assets.model.kitchen.plan import OpeningKind
from casa_assets.model.kitchen.scene import Scene
from tests.support.kitchen.reference_kitchen import LIMITS


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
