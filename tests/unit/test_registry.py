"""registry/ as it comes with the package, what free words find in it, and the errors of a broken one."""

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
from casa_assets.registry.tables import LOOK_ALIKES_FILE, look_alikes

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

# Names that sets of household meshes use, and messy ones, with what each is here.
NAMES = """
Chefmate 8" Frypan: pan; coffeemug: mug; pot-ww: pot; aws_Tableware_01_visual: dish_stack; kitchenMicrowave: microwave;
Room Essentials Mug White Yellow: mug; 003_cracker_box: boxed_food; Kitchen Knives: knife; loaves: bread; wine glasses:
wine_glass; SM_Fridge_01: refrigerator; HAMBURGER: hamburger; apple_juice_box: boxed_drink; mug with spoon: mug; tray
for cutlery: tray; Knife, kitchen: knife; Frying Pan (Low Poly): pan; Plate Orange: plate; Assiette plate à café: plate;
teapot_lid: saucepan_lid
"""
# Nothing is found in these: no word is found inside another.
NOTHING = ("panda", "panel", "potion", "canvas", "Object_3", "", "  ", "0123", "日本", "forklift", "cupid", "scandal")


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


def test_every_name_of_the_benchmark_is_a_category(shipped: Registry) -> None:
    assert len(ROBOCASA.split()) == 199
    assert set(ROBOCASA.split()) - shipped.categories.keys() == set()


def test_every_id_and_alias_finds_its_own_category(shipped: Registry) -> None:
    named = [(c.id, c.id) for c in shipped.categories.values() if c.id != registry.FALLBACK]
    named += [(alias, c.id) for c in shipped.categories.values() for alias in c.aliases]
    found = {name: shipped.find_category([name]) for name, _ in named}
    assert {name: match and match[0].id for name, match in found.items()} == dict(named)
    assert min(match[1] for match in found.values() if match) >= 0.9


def test_rows_of_categories_are_plausible(shipped: Registry) -> None:
    """Of the density of the bounding box: no more than 1.6 of that of the substance, no less than crumpled wire.

    Shapes are relative to the longest side. An open cavity is part of the outline, so a vessel is lighter than its
    outline filled with its substance. What nobody can name weighs what any category may.
    """
    rows = shipped.categories.values()
    assert {c.id for c in rows if max(c.shape) != 1 or min(c.shape) <= 0} == set()
    assert {c.id for c in rows if c.upright == "lies" and c.shape[2] > c.shape[0]} == set()
    box = {c.id: c.longest_m.typical**3 * c.shape[0] * c.shape[1] * c.shape[2] for c in rows}
    share = {c.id: c.mass_kg.typical / box[c.id] / shipped.substances[c.substance].density for c in rows}
    assert {name: mass for name, mass in share.items() if mass > 1.6} == {}
    assert {c.id for c in rows if not 10 <= c.mass_kg.typical / box[c.id] <= 4000} == set()
    assert {c.id for c in rows if c.build is MatterFill.VESSEL and share[c.id] >= 1} == set()
    assert shipped.categories[registry.FALLBACK].mass_kg.high >= max(c.mass_kg.high for c in rows)
    assert {s.id for s in shipped.substances.values() if s.dynamic_friction > s.static_friction} == set()


def test_classes_end_at_one_root(shipped: Registry) -> None:
    assert [c.id for c in shipped.classes.values() if c.parent is None] == ["object"]
    for category in shipped.categories.values():
        chain = shipped.classes_of(category)
        assert (chain[0], chain[-1]) == (category.id, "object")
        assert len(set(chain)) == len(chain)
        assert all(shipped.classes[a].parent == b for a, b in pairwise(chain[1:]))
    assert shipped.classes_of("mug") == ("mug", "drinkware", "tableware", "kitchenware", "object")
    with pytest.raises(UnknownId) as caught:
        shipped.category("mugg")
    assert "mug" in caught.value.nearest


def test_limits_and_rejections(shipped: Registry) -> None:
    assert shipped.limits.keys() == shipped.limit_units.keys()
    assert shipped.limits["hull_vertices"] == 64
    assert shipped.limits["density_low"] < 1 < shipped.limits["density_high"]
    assert {k for k, unit in shipped.limit_units.items() if k.endswith("_m") and unit != "m"} == set()
    assert shipped.rejections["GEO001"].name == "degenerate_shape"
    assert {r.code for r in shipped.rejections.values() if not r.meaning or not r.remedy} == set()
    names = [r.name for r in shipped.rejections.values()]
    assert len(set(names)) == len(names)


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


def test_load_reads_once_and_digest_is_of_the_contents(shipped: Registry, tmp_path: Path) -> None:
    assert registry.load() is registry.load()
    copy = shutil.copytree(registry.data_root(), tmp_path / "copy")
    assert registry.load(copy).digest == shipped.digest
    with (copy / "waivers.yaml").open("a") as file:
        file.write("# a word more\n")
    registry.load.cache_clear()
    assert registry.load(copy).digest != shipped.digest


def test_names_find_their_category_and_no_word_is_found_inside_another(shipped: Registry) -> None:
    wanted = dict(row.split(": ") for row in " ".join(NAMES.split()).split("; "))
    found = {text: shipped.find_category([text]) for text in wanted}
    assert {text: match and match[0].id for text, match in found.items()} == wanted
    assert all(match and 0 < match[1] <= 1 and text in match[2] for text, match in found.items())
    assert [text for text in NOTHING if shipped.find_category([text])] == []


def test_the_best_hint_decides_and_a_weak_word_yields_to_a_later_hint(shipped: Registry) -> None:
    wanted: dict[tuple[str, ...], str | None] = {("mug", "plate"): "mug", ("a1b2c3", "plate"): "plate", (): None}
    wanted |= {("orange", "coffee mug"): "mug", ("orange", "a1b2c3"): "orange"}
    found = {hints: shipped.find_category(hints) for hints in wanted}
    assert {hints: match and match[0].id for hints, match in found.items()} == wanted


def test_confidence_falls_from_id_to_alias_to_part_of_a_text(shipped: Registry) -> None:
    ranks = ["mug", "tea mug", "my old tea mug", "my old mug", "mug that i have", "soapmug"]
    found = [shipped.find_category([text]) for text in ranks]
    confidences = [match[1] for match in found if match]
    assert len(confidences) == len(ranks)
    assert confidences == sorted(set(confidences), reverse=True)
    later = shipped.find_category(["a1b2c3", "mug"])
    assert later
    assert later[1] < 1


def test_a_sound_small_registry_loads(tmp_path: Path) -> None:
    for name, text in SOUND.items():
        (tmp_path / f"{name}.yaml").write_text(str(text))
    small = registry.load(tmp_path)
    assert small.category("mug").longest_m.typical == 0.1
    assert small.category("mug").qcode.certainty is Certainty.PARENT
    assert small.category("mug").qcode.label == "object"
    assert small.waivers[0].subject == "mug_1"
    assert small.rejections["GEO001"].code == "GEO001"


def test_faults_name_file_line_and_pointer(broken: Callable[..., RegistryError]) -> None:
    for name, text, line, pointer, message in [
        ("categories", MUG + "cup: {colour: red}\n", 4, "cup.colour", "one of id, parent"),
        ("categories", MUG.replace("aliases:", "colour:"), 3, "mug.colour", "colour"),
        ("categories", MUG + MUG, 4, "mug", "each key once"),
        ("categories", MUG.replace("drinkware", "drinkwear"), 1, "mug.parent", "drinkwear"),
        ("categories", MUG.replace("ceramic", "clay"), 2, "mug.substance", "clay"),
        ("categories", MUG.replace("[1, 0.7, 0.8]", "[0.9, 0.7, 0.8]"), 2, "mug.shape", "0.9"),
        ("categories", MUG.replace("0.08, 0.1,", "0.2, 0.1,"), 1, "mug.longest_m", "hold"),
        ("categories", MUG.replace("0.08, 0.1,", "0.1,"), 1, "mug.longest_m", "typical"),
        ("categories", MUG.replace("0.3", "heavy"), 1, "mug.mass_kg.typical", "heavy"),
        ("categories", MUG.replace("vessel", "cup"), 2, "mug.build", "'cup'"),
        ("categories", MUG.replace("mug: {", "mug: {id: cup, "), 1, "mug.id", "cup"),
        ("categories", MUG.replace("mug:", "Mug:"), 1, "Mug.id", "'Mug'"),
        ("categories", MUG + MUG.replace("mug: {", "cup: {"), 6, "cup.aliases.0", "'coffee mug'"),
        ("categories", MUG + MUG.replace("mug: {", "m_ug: {").replace("coffee", "my"), 4, "m_ug", "'m_ug'"),
        ("categories", MUG + "cup: 3\n", 4, "cup", "a mapping"),
        ("categories", "- mug\n", 1, "", "list"),
        ("categories", "mug: {parent: [drinkware\n", 2, "", "YAML"),
        ("classes", "object: {parent: thing}\n", 1, "object.parent", "thing"),
        ("classes", "a: {parent: b}\nb: {parent: a}\n", 1, "a.parent", "a -> b -> a"),
        ("classes", "object: {}\n", 1, "object.qcode", "nothing"),
        ("substances", "ceramic: {density: -1}\n", 1, "ceramic.density", "-1"),
        ("limits", "a: {value: 1, why: w}\nb: {value: x, why: w}\n", 2, "b.value", "'x'"),
        ("rejections", "GEO1: {name: n, meaning: m, remedy: n}\n", 1, "GEO1.code", "GEO1"),
        ("waivers", "- {code: AST001, subject: s}\n", 1, "0.reason", "nothing"),
        ("words", "weak: [can]\nseparators: [with, on]\n", 2, "separators.1", "True"),
        ("limits", None, 1, "", "a readable file"),
    ]:
        error = broken(**{name: text})
        assert (error.file, error.line, error.pointer) == (f"{name}.yaml", line, pointer)
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


def test_look_alikes_are_categories_of_objects_and_few() -> None:
    found = look_alikes()
    assert found["mug"] == found["coffee_cup"] != found["jug"]
    assert len(found) < 0.2 * len(registry.load().categories)


def test_a_broken_row_of_look_alikes_is_refused_with_its_place(tmp_path: Path) -> None:
    folder = shutil.copytree(registry.data_root(), tmp_path / "registry")
    for text, expected in (
        ("cup: {categories: [mug, mugg], reason: x.}", "mugg"),
        ("cup: {categories: [mug], reason: x.}", "at least 2"),
        ("one: {categories: [mug, cup], reason: x.}\ntwo: {categories: [cup, bowl], reason: y.}", "no other row"),
    ):
        (folder / LOOK_ALIKES_FILE).write_text(text + "\n", encoding="utf-8")
        look_alikes.cache_clear()
        with pytest.raises(RegistryError, match=rf"{LOOK_ALIKES_FILE}.*{expected}"):
            look_alikes(folder)
