"""What the registry says of the object categories of the reference runtime: all of them, whole, and within reason."""

from __future__ import annotations

import csv
import io
from collections import Counter

import pytest

from casa_assets import registry
from casa_assets.model.registry.category import (
    Affordance,
    Category,
    FrontRule,
    MatterFill,
    NumberBasis,
    ObjectType,
    RestingPose,
)
from casa_assets.model.registry.contract import RobocasaRelease

# Name: what tasks may do with it. Of the reference runtime, as far as tasks filter by it; g graspable, w washable,
# m microwavable, c cookable, f freezable, r fridgable, d dishwashable.
SAMPLE = """
apple,gwcr
bacon,mcr
bowl,gwmrd
carrot,gwmcfr
cereal,g
fork,wmc
ice_cube,gwf
kettle_electric,g
mug,gwmrd
pan,gwrd
placemat,w
spaghetti_box,
tupperware,gwmfrd
whisk,gw
"""
LETTERS = dict(
    zip(
        "gwmcfrd",
        (
            Affordance.GRASPABLE,
            Affordance.WASHABLE,
            Affordance.MICROWAVABLE,
            Affordance.COOKABLE,
            Affordance.FREEZABLE,
            Affordance.FRIDGABLE,
            Affordance.DISHWASHABLE,
        ),
        strict=True,
    )
)
OURS = {Affordance.CONTAINER, Affordance.STACKABLE}


@pytest.fixture(scope="module")
def rows() -> dict[str, Category]:
    """Those of the reference runtime."""
    return {c.id: c for c in registry.load().categories.values() if c.runtime}


def test_all_of_both_releases_are_there(rows: dict[str, Category]) -> None:
    assert len(rows) == 199
    assert Counter(r for c in rows.values() for r in c.runtime) == {
        RobocasaRelease.V0_2: 153,
        RobocasaRelease.V1_0: 198,
    }
    assert [c.id for c in rows.values() if c.runtime == (RobocasaRelease.V0_2,)] == ["kettle_electric"]


def test_each_is_whole(rows: dict[str, Category]) -> None:
    assert [c.id for c in rows.values() if c.size_m is None] == []
    assert [c.id for c in rows.values() if not c.prompts] == []
    assert [c.id for c in rows.values() if c.basis.uses is not NumberBasis.REFERENCE] == []
    # Of these the reference runtime has no type either.
    assert {c.id for c in rows.values() if not c.types} == {"flour_bag", "straw", "tofu", "walnut"}


def test_affordances_are_those_that_tasks_filter_by(subtests: pytest.Subtests, rows: dict[str, Category]) -> None:
    for name, letters in list(csv.reader(io.StringIO(SAMPLE.strip()))):
        with subtests.test(name=name, letters=letters):
            assert set(rows[name].affords) - OURS == {LETTERS[letter] for letter in letters}


def test_counts_of_attributes(rows: dict[str, Category]) -> None:
    """Of the names of the first release, with the attributes of the second."""
    first = [c for c in rows.values() if RobocasaRelease.V0_2 in c.runtime]
    counts = {use: sum(c.can(use) for c in first) for use in LETTERS.values()}
    assert counts[Affordance.GRASPABLE] == 123
    assert counts[Affordance.WASHABLE] == 112
    assert counts[Affordance.MICROWAVABLE] == 55
    assert counts[Affordance.COOKABLE] == 52
    assert counts[Affordance.FREEZABLE] == 74
    kinds = Counter(kind for c in first for kind in c.types)
    assert {
        kind: kinds[kind]
        for kind in (ObjectType.VEGETABLE, ObjectType.FRUIT, ObjectType.RECEPTACLE, ObjectType.CLEANER)
    } == {
        ObjectType.VEGETABLE: 29,
        ObjectType.FRUIT: 19,
        ObjectType.RECEPTACLE: 16,
        ObjectType.CLEANER: 4,
    }


def test_every_type_and_affordance_is_in_use(rows: dict[str, Category]) -> None:
    assert {kind for c in rows.values() for kind in c.types} == set(ObjectType)
    assert {use for c in rows.values() for use in c.affords} == set(Affordance)


def test_spans_are_neither_points_nor_anything(rows: dict[str, Category]) -> None:
    odd = {}
    for c in rows.values():
        for name, span in zip(("x", "y", "z", "mass"), (*c.extents, c.mass_kg), strict=True):
            most = 100 if name == "mass" else 25
            if not 1.1 <= span.high / span.low <= most or not span.low >= 0.0005 or span.high > 20:
                odd[c.id, name] = span
    assert odd == {}


def test_sizes_agree_with_the_shape_and_the_longest(rows: dict[str, Category]) -> None:
    for c in rows.values():
        for span, share in zip(c.extents, c.shape, strict=True):
            assert span.typical == pytest.approx(share * c.longest_m.typical, rel=0.06, abs=0.0011), c.id
            assert span.high <= c.longest_m.high * 1.001, c.id


def test_masses_that_are_asked_for(subtests: pytest.Subtests, rows: dict[str, Category]) -> None:
    for name, low, high in [("apple", 0.1, 0.3), ("mug", 0.25, 0.5), ("egg", 0.04, 0.08), ("can", 0.1, 0.6)]:
        with subtests.test(name=name, low=low, high=high):
            span = rows[name].mass_kg
            assert low <= span.low <= span.typical <= span.high <= high


def test_what_holds_things_is_open(rows: dict[str, Category]) -> None:
    holds = [c for c in registry.load().categories.values() if c.can(Affordance.CONTAINER)]
    assert {c.id for c in holds if c.build in (MatterFill.SOLID, MatterFill.FILLED)} == set()
    assert {"bowl", "mug", "pan", "plate", "tray"} <= {c.id for c in holds}


def test_what_stacks_rests_on_a_foot(rows: dict[str, Category]) -> None:
    stacks = [c for c in registry.load().categories.values() if c.can(Affordance.STACKABLE)]
    assert {c.id for c in stacks if c.upright is RestingPose.ANY} == set()


def test_poses(rows: dict[str, Category]) -> None:
    pose = {name: (rows[name].upright, rows[name].front) for name in ("knife", "mug", "cereal", "orange")}
    assert pose == {
        "knife": (RestingPose.LIES, FrontRule.LENGTH),
        "mug": (RestingPose.STANDS, FrontRule.HANDLE),
        "cereal": (RestingPose.STANDS, FrontRule.FACE),
        "orange": (RestingPose.ANY, FrontRule.ANY),
    }
    turned = [c for c in registry.load().categories.values() if c.front is FrontRule.LENGTH]
    assert [c.id for c in turned if c.shape[0] < max(c.shape[1:])] == []


def test_lvis_names_lead_to_their_category() -> None:
    known = registry.load()
    names = {name: c.id for c in known.categories.values() for name in c.lvis}
    assert len(names) > 280
    found = {name: known.find_category([name]) for name in names}
    assert {name: match and match[0].id for name, match in found.items()} == names
    hard = {"crisp_(potato_chip)": "chips", "fume_hood": "range_hood", "cantaloup": "cantaloupe"}
    assert {name: names[name] for name in hard} == hard


def test_phrases_tell_categories_apart(rows: dict[str, Category]) -> None:
    phrases = Counter(p for c in registry.load().categories.values() for p in c.phrases)
    assert [p for p, n in phrases.items() if n > 1] == []
    assert [p for p in phrases if not p.islower() or p.endswith(".")] == []
