"""registry/ as it comes with the package, what free words find in it, and what a broken one says."""

from __future__ import annotations

import shutil
from collections import Counter
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from casa_assets import registry
from casa_assets.errors import RegistryError, UnknownId
from casa_assets.model.registry.category import Certainty, MatterFill
from casa_assets.registry import Registry, read_document
from casa_assets.registry.load import load_limits

# The object names of the RoboCasa kitchen benchmark, in any of its releases.
ROBOCASA = """
aluminum_foil apple apricot artichoke asparagus avocado bacon bagel bagged_food baguette baking_sheet banana bar
bar_soap basket beer beet bell_pepper blender_jug bottle_opener bottled_drink bottled_water bowl boxed_drink
boxed_food bread bread_flat broccoli brussel_sprout burrito butter_stick cabbage cake can can_opener candle
candy canned_food canola_oil cantaloupe carrot cauliflower celery cereal cheese cheese_grater cherry
chicken_breast chicken_drumstick chili_pepper chips chocolate cinnamon coconut coffee_cup colander
condiment_bottle cookie_dough_ball corn cream_cheese_stick croissant cucumber cup cupcake cutting_board dates
digital_scale dish_brush donut dumpling egg eggplant fish flour_bag fork garlic ginger glass_cup grapes ham
hamburger honey_bottle hot_dog hotdog_bun ice_cream ice_cube ice_cube_tray jam jar jello_cup jug
jug_wide_opening juice kebab_skewer kebabs ketchup kettle_electric kettle_non_electric kiwi knife ladle
lamb_chop lemon lemon_wedge lemonade lettuce lime liquor lobster lollipop mango marshmallow mayonnaise
measuring_cup milk mug mushroom mustard oil_and_vinegar_bottle olive_oil_bottle onion orange oven_tray pan
pancake paprika peach peanut_butter pear peeler pickle pickle_slice pineapple pitcher pizza pizza_cutter
placemat plate pomegranate pork_chop pork_loin pot potato radish raspberry reamer rolling_pin salami salsa
salt_and_pepper_shaker sandwich_bread saucepan saucepan_lid saucepan_with_lid sausage scallops scissors scone
shaker shrimp skewers soap_dispenser spaghetti_box spatula sponge spoon spray squash steak strainer straw
strawberry sugar_cube sushi sweet_potato syrup_bottle tacos tangerine teapot thermos tofu tomato tomato_slice
tongs tray tupperware turkey_slice turmeric vinegar waffle walnut water_bottle watermelon whisk wine wine_glass
wooden_spoon yogurt zucchini
"""

# Names that sets of household meshes use for what the list above calls otherwise or leaves out.
OTHER_SOURCES = {
    "frying_pan": "pan",
    "burger": "hamburger",
    "soap": "bar_soap",
    "kettle": "kettle_non_electric",
    "skillet": "pan",
    "fridge": "refrigerator",
    "doughnut": "donut",
    "microwave_oven": "microwave",
    "aubergine": "eggplant",
    "courgette": "zucchini",
    "sofa": "couch",
}
OTHER_IDS = """
bottle carton chips_can coffee_machine coffee_maker condiment_bottle detergent_bottle dish_rack dish_stack figurine
fries glue_stick knife_block lunch_box personal_care_bottle range_hood refrigerator soap_dispenser spice_rack spoon_rest
stove teacup toaster utensil_holder blender microwave oven dishwasher sink faucet washing_machine stool chair table
cabinet shelf toy book box ball screwdriver hammer drill tape pen remote phone headphones shoe bag hat lamp battery
"""


@pytest.fixture(scope="module")
def shipped() -> Registry:
    return registry.load()


@pytest.fixture
def broken(tmp_path: Path) -> Callable[..., RegistryError]:
    """A tiny registry with one file replaced; returns the error that reading it raises."""

    def fault(**files: str | None) -> RegistryError:
        for path in tmp_path.glob("*.yaml"):
            path.unlink()
        for name, text in {**SOUND, **files}.items():
            if text is not None:
                (tmp_path / f"{name}.yaml").write_text(text, encoding="utf-8")
        registry.load.cache_clear()
        load_limits.cache_clear()
        with pytest.raises(RegistryError) as caught:
            registry.load(tmp_path)
        return caught.value

    return fault


MUG = """\
mug: {parent: drinkware, longest_m: [0.08, 0.1, 0.15], mass_kg: [0.1, 0.3, 0.5],
  shape: [1, 0.7, 0.8], upright: stands, build: vessel, substance: ceramic,
  aliases: [coffee mug]}
"""
SOUND: dict[str, str | None] = {
    "categories": MUG,
    "classes": "object: {qcode: {id: Q488383, label: object, certainty: certain}}\ndrinkware: {parent: object}\n",
    "fixtures": "",
    "limits": 'hull_count: {value: 32, unit: "", why: "Cost."}\n',
    "materials": "",
    "other_things": "{always: [shader], parts: [leg], figures: [], places: [], shapes: [], outdoors: [], arms: []}\n",
    "rejections": "GEO001: {name: degenerate_shape, meaning: m, remedy: n}\n",
    "densities": 'hollow_clay: {kg_m3: 700, why: "A pot."}\n',
    "substances": "ceramic: {density: 2300, static_friction: 0.5, dynamic_friction: 0.4}\n",
    "waivers": "- {code: AST001, subject: mug_1, reason: measured}\n",
    "words": "weak: [can]\nseparators: [with]\n",
}


# ---- what comes with the package


def test_every_name_of_the_benchmark_is_a_category(shipped: Registry) -> None:
    assert len(ROBOCASA.split()) == 199
    assert set(ROBOCASA.split()) - shipped.categories.keys() == set()
    assert set(OTHER_IDS.split()) - shipped.categories.keys() == set()


def test_every_id_and_alias_finds_its_own_category(shipped: Registry) -> None:
    named = [(c.id, c.id) for c in shipped.categories.values() if c.id != registry.FALLBACK]
    named += [(alias, c.id) for c in shipped.categories.values() for alias in c.aliases]
    found = {name: shipped.find_category([name]) for name, _ in named}
    assert {name: match and match[0].id for name, match in found.items()} == dict(named)
    assert min(match[1] for match in found.values() if match) >= 0.9


def test_what_nobody_can_name_weighs_what_any_category_may(shipped: Registry) -> None:
    unknown = shipped.categories[registry.FALLBACK].mass_kg
    assert unknown.high >= max(c.mass_kg.high for c in shipped.categories.values())


def test_names_of_other_sources(subtests: pytest.Subtests, shipped: Registry) -> None:
    for name, category in OTHER_SOURCES.items():
        with subtests.test(name=name, category=category):
            match = shipped.find_category([name])
            assert match
            assert match[0].id == category


def test_shape_is_relative_to_the_longest_side(shipped: Registry) -> None:
    assert {c.id for c in shipped.categories.values() if max(c.shape) != 1 or min(c.shape) <= 0} == set()


def test_what_lies_is_not_taller_than_wide(shipped: Registry) -> None:
    lying = [c for c in shipped.categories.values() if c.upright == "lies"]
    assert {c.id for c in lying if c.shape[2] > c.shape[0]} == set()


def test_mass_fits_size_and_substance(shipped: Registry) -> None:
    """Typical mass over typical bounding box: no denser than 1.6 of its substance, no lighter than crumpled wire."""
    odd = {}
    for c in shipped.categories.values():
        x, y, z = c.shape
        density = c.mass_kg.typical / (c.longest_m.typical**3 * x * y * z)
        if not 10 <= density <= 4000 or density > 1.6 * shipped.substances[c.substance].density:
            odd[c.id] = density
    assert odd == {}


def test_vessels_are_not_said_to_be_full(shipped: Registry) -> None:
    """An open cavity is part of the outline, so a vessel is lighter than its outline filled with its substance."""
    for c in shipped.categories.values():
        if c.build is MatterFill.VESSEL:
            x, y, z = c.shape
            filled = shipped.substances[c.substance].density * c.longest_m.typical**3 * x * y * z
            assert c.mass_kg.typical < filled, c.id


def test_fixed_is_only_what_is_built_in(shipped: Registry) -> None:
    fixed = {c.id for c in shipped.categories.values() if c.fixed}
    assert fixed == {
        *("stove", "cooktop", "oven", "refrigerator", "dishwasher", "range_hood", "sink", "faucet", "cabinet"),
        *("air_conditioner", "counter", "washing_machine", "toilet", "bathtub", "fireplace"),
    }


def test_friction_at_rest_is_not_below_friction_in_motion(shipped: Registry) -> None:
    assert {s.id for s in shipped.substances.values() if s.dynamic_friction > s.static_friction} == set()


def test_classes_end_at_one_root(shipped: Registry) -> None:
    assert [c.id for c in shipped.classes.values() if c.parent is None] == ["object"]
    for category in shipped.categories.values():
        chain = shipped.classes_of(category)
        assert chain[0] == category.id
        assert chain[-1] == "object"
        assert len(set(chain)) == len(chain)
        assert all(shipped.classes[a].parent == b for a, b in pairwise(chain[1:]))


def test_classes_of_a_mug(shipped: Registry) -> None:
    assert shipped.classes_of("mug") == ("mug", "drinkware", "tableware", "kitchenware", "object")


def test_a_qcode_is_its_own_or_that_of_the_class_above(shipped: Registry) -> None:
    for category in shipped.categories.values():
        above = shipped.classes[category.parent].qcode
        if category.qcode.certainty is Certainty.PARENT:
            assert (category.qcode.id, category.qcode.label) == (above.id, above.label), category.id
    own = [c.qcode.id for c in shipped.categories.values() if c.qcode.certainty is not Certainty.PARENT]
    assert [q for q, n in Counter(own).items() if n > 1] == []
    assert shipped.category("mug").qcode.id == "Q386215"
    assert shipped.category("teacup").qcode.label == "teacup"
    assert shipped.category("saucer").qcode.label == "kitchenware"


def test_limits_have_values_and_units(shipped: Registry) -> None:
    assert shipped.limits.keys() == shipped.limit_units.keys()
    assert shipped.limits["hull_vertices"] == 64
    assert shipped.limits["density_low"] < 1 < shipped.limits["density_high"]
    assert shipped.limit_units["collider_error_m"] == "m"
    assert {k for k, unit in shipped.limit_units.items() if k.endswith("_m") and unit != "m"} == set()


def test_rejections_say_what_to_do(shipped: Registry) -> None:
    assert shipped.rejections["GEO001"].name == "degenerate_shape"
    assert {r.code for r in shipped.rejections.values() if not r.meaning or not r.remedy} == set()
    names = [r.name for r in shipped.rejections.values()]
    assert len(set(names)) == len(names)


def test_unknown_category_names_its_neighbours(shipped: Registry) -> None:
    with pytest.raises(UnknownId) as caught:
        shipped.category("mugg")
    assert "mug" in caught.value.nearest


def test_load_reads_once_and_digest_is_of_the_contents(shipped: Registry, tmp_path: Path) -> None:
    assert registry.load() is registry.load()
    copy = shutil.copytree(registry.data_root(), tmp_path / "copy")
    assert registry.load(copy).digest == shipped.digest
    with (copy / "waivers.yaml").open("a") as file:
        file.write("# a word more\n")
    registry.load.cache_clear()
    assert registry.load(copy).digest != shipped.digest


# ---- free words


def test_messy_names(subtests: pytest.Subtests, shipped: Registry) -> None:
    for text, category in [
        ('Chefmate 8" Frypan', "pan"),
        ("coffeemug", "mug"),
        ("coffee mug", "mug"),
        ("pot-ww", "pot"),
        ("aws_Tableware_01_visual", "dish_stack"),
        ("kitchenMicrowave", "microwave"),
        ("Room Essentials Mug White Yellow", "mug"),
        ("003_cracker_box", "boxed_food"),
        ("Kitchen Knives", "knife"),
        ("loaves", "bread"),
        ("cherries", "cherry"),
        ("wine glasses", "wine_glass"),
        ("SM_Fridge_01", "refrigerator"),
        ("HAMBURGER", "hamburger"),
        ("apple pie", "pie"),
        ("apple_juice_box", "boxed_drink"),
        ("table lamp", "lamp"),
        ("mug with spoon", "mug"),
        ("tray for cutlery", "tray"),
        ("Knife, kitchen", "knife"),
        ("Frying Pan (Low Poly)", "pan"),
        ("Plate Orange", "plate"),
        ("can opener", "can_opener"),
        ("box of cereal", "cereal"),
        ("Assiette plate à café", "plate"),
        ("teapot_lid", "saucepan_lid"),
    ]:
        with subtests.test(text=text, category=category):
            match = shipped.find_category([text])
            assert match
            assert match[0].id == category
            assert 0 < match[1] <= 1
            assert text in match[2]


def test_no_word_is_found_inside_another(subtests: pytest.Subtests, shipped: Registry) -> None:
    for text in [
        "panda",
        "panel",
        "potion",
        "canvas",
        "Object_3",
        "",
        "  ",
        "0123",
        "日本",
        "forklift",
        "cupid",
        "scandal",
    ]:
        with subtests.test(text=text):
            assert shipped.find_category([text]) is None


def test_the_best_hint_decides(shipped: Registry) -> None:
    assert _found(shipped, "mug", "plate") == "mug"
    assert _found(shipped, "a1b2c3", "plate") == "plate"
    assert _found(shipped) is None


def test_a_weak_word_yields_to_a_later_hint(shipped: Registry) -> None:
    assert _found(shipped, "orange", "coffee mug") == "mug"
    assert _found(shipped, "orange", "a1b2c3") == "orange"


def test_confidence_falls_from_id_to_alias_to_part_of_a_text(shipped: Registry) -> None:
    ranks = ["mug", "tea mug", "my old tea mug", "my old mug", "mug that i have", "soapmug"]
    found = [shipped.find_category([text]) for text in ranks]
    confidences = [match[1] for match in found if match]
    assert len(confidences) == len(ranks)
    assert confidences == sorted(set(confidences), reverse=True)
    later = shipped.find_category(["a1b2c3", "mug"])
    assert later
    assert later[1] < 1


def _found(shipped: Registry, *hints: str) -> str | None:
    match = shipped.find_category(hints)
    return match[0].id if match else None


# ---- what a broken registry says


def test_a_sound_small_registry_loads(tmp_path: Path) -> None:
    for name, text in SOUND.items():
        (tmp_path / f"{name}.yaml").write_text(str(text))
    small = registry.load(tmp_path)
    assert small.category("mug").longest_m.typical == 0.1
    assert small.category("mug").qcode.certainty is Certainty.PARENT
    assert small.category("mug").qcode.label == "object"
    assert small.waivers[0].subject == "mug_1"
    assert small.rejections["GEO001"].code == "GEO001"


def test_faults_name_file_line_and_pointer(subtests: pytest.Subtests, broken: Callable[..., RegistryError]) -> None:
    for files, file, line, pointer, message in [
        ({"categories": MUG + "cup: {colour: red}\n"}, "categories.yaml", 4, "cup.colour", "one of id, parent"),
        ({"categories": MUG.replace("aliases:", "colour:")}, "categories.yaml", 3, "mug.colour", "colour"),
        ({"categories": MUG + MUG}, "categories.yaml", 4, "mug", "each key once"),
        ({"categories": MUG.replace("drinkware", "drinkwear")}, "categories.yaml", 1, "mug.parent", "drinkwear"),
        ({"categories": MUG.replace("ceramic", "clay")}, "categories.yaml", 2, "mug.substance", "clay"),
        ({"categories": MUG.replace("[1, 0.7, 0.8]", "[0.9, 0.7, 0.8]")}, "categories.yaml", 2, "mug.shape", "0.9"),
        ({"categories": MUG.replace("0.08, 0.1,", "0.2, 0.1,")}, "categories.yaml", 1, "mug.longest_m", "hold"),
        ({"categories": MUG.replace("0.08, 0.1,", "0.1,")}, "categories.yaml", 1, "mug.longest_m", "typical"),
        ({"categories": MUG.replace("0.3", "heavy")}, "categories.yaml", 1, "mug.mass_kg.typical", "heavy"),
        ({"categories": MUG.replace("vessel", "cup")}, "categories.yaml", 2, "mug.build", "'cup'"),
        ({"categories": MUG.replace("mug: {", "mug: {id: cup, ")}, "categories.yaml", 1, "mug.id", "cup"),
        ({"categories": MUG.replace("mug:", "Mug:")}, "categories.yaml", 1, "Mug.id", "'Mug'"),
        (
            {"categories": MUG + MUG.replace("mug: {", "cup: {")},
            *("categories.yaml", 6, "cup.aliases.0", "'coffee mug'"),
        ),
        ({"categories": MUG + "cup: 3\n"}, "categories.yaml", 4, "cup", "a mapping"),
        ({"categories": "- mug\n"}, "categories.yaml", 1, "", "list"),
        ({"categories": "mug: {parent: [drinkware\n"}, "categories.yaml", 2, "", "YAML"),
        ({"classes": "object: {parent: thing}\n"}, "classes.yaml", 1, "object.parent", "thing"),
        ({"classes": "a: {parent: b}\nb: {parent: a}\n"}, "classes.yaml", 1, "a.parent", "a -> b -> a"),
        ({"classes": "object: {}\n"}, "classes.yaml", 1, "object.qcode", "nothing"),
        ({"substances": "ceramic: {density: -1}\n"}, "substances.yaml", 1, "ceramic.density", "-1"),
        ({"limits": "a: {value: 1, why: w}\nb: {value: x, why: w}\n"}, "limits.yaml", 2, "b.value", "'x'"),
        ({"rejections": "GEO1: {name: n, meaning: m, remedy: n}\n"}, "rejections.yaml", 1, "GEO1.code", "GEO1"),
        ({"waivers": "- {code: AST001, subject: s}\n"}, "waivers.yaml", 1, "0.reason", "nothing"),
        ({"words": "weak: [can]\nseparators: [with, on]\n"}, "words.yaml", 2, "separators.1", "True"),
        ({"limits": None}, "limits.yaml", 1, "", "a readable file"),
    ]:
        with subtests.test(files=files, file=file, line=line, pointer=pointer, message=message):
            error = broken(**files)
            assert (error.file, error.line, error.pointer) == (file, line, pointer)
            assert message in str(error)


def test_a_file_from_the_cache_has_the_same_lines_and_faults(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CASA_ASSETS_CACHE", str(tmp_path / "cache"))
    path = tmp_path / "a.yaml"
    path.write_text("mug:\n  sizes: [0.1, 2, yes]\n  note: a\n")
    parsed, kept = read_document(path), read_document(path)
    assert kept.value == parsed.value == {"mug": {"sizes": [0.1, 2, True], "note": "a"}}
    assert dict(kept.lines) == dict(parsed.lines)
    assert kept.lines["mug", "sizes", 2] == 2
    for damaged in (tmp_path / "cache").rglob("*.json"):
        damaged.write_text("{")
    again = read_document(path)
    assert (again.value, dict(again.lines)) == (parsed.value, dict(parsed.lines))
    path.write_text("mug: 1\nmug: 2\n")
    for _ in range(2):
        with pytest.raises(RegistryError, match="each key once"):
            read_document(path)


def test_two_ids_that_read_alike_are_a_fault(broken: Callable[..., RegistryError]) -> None:
    alike = MUG + MUG.replace("mug: {", "m_ug: {").replace("  aliases: [coffee mug]}", "  aliases: []}")
    error = broken(categories=alike)
    assert (error.line, error.pointer) == (4, "m_ug")
