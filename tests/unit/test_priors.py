"""What the registry has of the object categories of the reference runtime: all of them, whole, and within reason."""

from __future__ import annotations

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

LETTERS = {
    "g": Affordance.GRASPABLE, "w": Affordance.WASHABLE, "m": Affordance.MICROWAVABLE, "c": Affordance.COOKABLE,
    "f": Affordance.FREEZABLE, "r": Affordance.FRIDGABLE, "d": Affordance.DISHWASHABLE,
}  # fmt: skip
OURS = {Affordance.CONTAINER, Affordance.STACKABLE}
# What tasks may do with some. Of the reference runtime, as far as tasks filter by it.
SAMPLE = {
    "apple": "gwcr", "bacon": "mcr", "bowl": "gwmrd", "carrot": "gwmcfr", "cereal": "g", "fork": "wmc",
    "ice_cube": "gwf", "kettle_electric": "g", "mug": "gwmrd", "pan": "gwrd", "placemat": "w", "spaghetti_box": "",
    "tupperware": "gwmfrd", "whisk": "gw",
}  # fmt: skip
# Of the names of the first release, with the attributes of the second.
USES = {"g": 123, "w": 112, "m": 55, "c": 52, "f": 74}
KINDS = {ObjectType.VEGETABLE: 29, ObjectType.FRUIT: 19, ObjectType.RECEPTACLE: 16, ObjectType.CLEANER: 4}
MASSES = {"apple": (0.1, 0.3), "mug": (0.25, 0.5), "egg": (0.04, 0.08), "can": (0.1, 0.6)}  # kg
POSES = {
    "knife": (RestingPose.LIES, FrontRule.LENGTH),
    "mug": (RestingPose.STANDS, FrontRule.HANDLE),
    "cereal": (RestingPose.STANDS, FrontRule.FACE),
    "orange": (RestingPose.ANY, FrontRule.ANY),
}
EVERY = registry.load().categories.values()


@pytest.fixture(scope="module")
def rows() -> dict[str, Category]:
    """Those of the reference runtime."""
    return {c.id: c for c in EVERY if c.runtime}


def test_all_of_both_releases_are_there_and_whole(rows: dict[str, Category]) -> None:
    assert len(rows) == 199
    releases = Counter(r for c in rows.values() for r in c.runtime)
    assert releases == {RobocasaRelease.V0_2: 153, RobocasaRelease.V1_0: 198}
    assert [c.id for c in rows.values() if c.runtime == (RobocasaRelease.V0_2,)] == ["kettle_electric"]
    assert [c.id for c in rows.values() if c.size_m is None or not c.prompts] == []
    assert [c.id for c in rows.values() if c.basis.uses is not NumberBasis.REFERENCE] == []
    # Of these the reference runtime has no type either.
    assert {c.id for c in rows.values() if not c.types} == {"flour_bag", "straw", "tofu", "walnut"}
    assert {kind for c in rows.values() for kind in c.types} == set(ObjectType)
    assert {use for c in rows.values() for use in c.affords} == set(Affordance)


def test_affordances_and_types_are_those_that_tasks_filter_by(rows: dict[str, Category]) -> None:
    wanted = {name: {LETTERS[letter] for letter in letters} for name, letters in SAMPLE.items()}
    assert {name: set(rows[name].affords) - OURS for name in SAMPLE} == wanted
    first = [c for c in rows.values() if RobocasaRelease.V0_2 in c.runtime]
    assert {letter: sum(c.can(LETTERS[letter]) for c in first) for letter in USES} == USES
    kinds = Counter(kind for c in first for kind in c.types)
    assert {kind: kinds[kind] for kind in KINDS} == KINDS


def test_sizes_and_masses_are_spans_that_agree_with_the_shape(rows: dict[str, Category]) -> None:
    odd = {}
    for c in rows.values():
        for name, span in zip(("x", "y", "z", "mass"), (*c.extents, c.mass_kg), strict=True):
            most = 100 if name == "mass" else 25
            if not 1.1 <= span.high / span.low <= most or not span.low >= 0.0005 or span.high > 20:
                odd[c.id, name] = span
        for span, share in zip(c.extents, c.shape, strict=True):
            assert span.typical == pytest.approx(share * c.longest_m.typical, rel=0.06, abs=0.0011), c.id
            assert span.high <= c.longest_m.high * 1.001, c.id
    assert odd == {}
    for name, (low, high) in MASSES.items():
        span = rows[name].mass_kg
        assert low <= span.low <= span.typical <= span.high <= high, name


def test_what_holds_things_is_open_and_what_stacks_rests_on_a_foot() -> None:
    holds = {c.id: c.build for c in EVERY if c.can(Affordance.CONTAINER)}
    assert {name for name, build in holds.items() if build in (MatterFill.SOLID, MatterFill.FILLED)} == set()
    assert {"bowl", "mug", "pan", "plate", "tray"} <= holds.keys()
    assert {c.id for c in EVERY if c.can(Affordance.STACKABLE) and c.upright is RestingPose.ANY} == set()


def test_poses(rows: dict[str, Category]) -> None:
    assert {name: (rows[name].upright, rows[name].front) for name in POSES} == POSES
    turned = [c for c in EVERY if c.front is FrontRule.LENGTH]
    assert [c.id for c in turned if c.shape[0] < max(c.shape[1:])] == []


def test_lvis_names_lead_to_their_category_and_phrases_distinguish_categories() -> None:
    names = {name: c.id for c in EVERY for name in c.lvis}
    assert len(names) > 280
    found = {name: registry.load().find_category([name]) for name in names}
    assert {name: match and match[0].id for name, match in found.items()} == names
    hard = {"crisp_(potato_chip)": "chips", "fume_hood": "range_hood", "cantaloup": "cantaloupe"}
    assert {name: names[name] for name in hard} == hard
    phrases = Counter(p for c in EVERY for p in c.phrases)
    assert [p for p, n in phrases.items() if n > 1] == []
    assert [p for p in phrases if not p.islower() or p.endswith(".")] == []
