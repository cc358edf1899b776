"""registry/ as it comes with the package, what names of strangers find in it, and the errors of a broken one."""

from __future__ import annotations

import shutil
from collections import Counter
from itertools import pairwise
from pathlib import Path

import pytest

from casa_assets import registry
from casa_assets.errors import RegistryError, UnknownId
from casa_assets.model.registry.category import (
    Affordance,
    Certainty,
    FrontRule,
    MatterFill,
    NumberBasis,
    ObjectType,
    RestingPose,
)
from casa_assets.model.registry.contract import RobocasaRelease
from casa_assets.registry import read_document
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
for cutlery: tray; chicken_soup_bowl: bowl; beef stew: food_bowl; oculus headset: vr_headset; gaming headset:
headphones; toy car: toy; chess knight: chess_piece; computer desk: desk; console table: table; wine cooler bucket:
bucket; wall socket: light_switch; dress shoe: shoe; bell pepper: bell_pepper; doll house: dollhouse; glue gun:
glue_gun; pocket watch: watch; Knife, kitchen: knife; Frying Pan (Low Poly): pan; Plate Orange: plate; Assiette plate à
café: plate; teapot_lid: saucepan_lid
"""
# Object names of the YCB set, and what each is here. Those of figures and parts are what they are.
YCB = """
001_chips_can chips_can, 002_master_chef_can can, 003_cracker_box boxed_food, 004_sugar_box boxed_food,
005_tomato_soup_can canned_food, 006_mustard_bottle mustard, 007_tuna_fish_can canned_food, 008_pudding_box
boxed_food, 009_gelatin_box boxed_food, 010_potted_meat_can canned_food, 011_banana banana, 012_strawberry strawberry,
013_apple apple, 014_lemon lemon, 015_peach peach, 016_pear pear, 017_orange orange, 018_plum plum, 019_pitcher_base
pitcher, 021_bleach_cleanser detergent_bottle, 022_windex_bottle bottle, 024_bowl bowl, 025_mug mug, 026_sponge
sponge, 028_skillet_lid saucepan_lid, 029_plate plate, 030_fork fork, 031_spoon spoon, 032_knife knife, 033_spatula
spatula, 035_power_drill drill, 036_wood_block building_block, 037_scissors scissors, 038_padlock padlock, 039_key
key, 040_large_marker pen, 042_adjustable_wrench wrench, 043_phillips_screwdriver screwdriver, 044_flat_screwdriver
screwdriver, 046_plastic_bolt bolt, 048_hammer hammer, 050_medium_clamp clamp, 051_large_clamp clamp,
053_mini_soccer_ball ball, 054_softball ball, 055_baseball ball, 056_tennis_ball ball, 057_racquetball ball,
058_golf_ball ball, 061_foam_brick foam_block, 062_dice dice, 063-a_marbles glass_marble, 065-a_cups cup,
070-a_colored_wood_blocks building_block, 072-a_toy_airplane toy, 073-a_lego_duplo toy, 076_timer timer,
077_rubiks_cube toy
"""
# Names that are neither ids nor aliases, and known by their words.
NOUNS = """
beef stew, chicken soup, vegetable curry, spring rolls, nuggets, caesar salad, toothpicks, hazelnuts, soundbar, dog
house, wooden blocks, sticky notes, office chair, bird cage
"""
# Figures, animals, vehicles, weapons and buildings are no things of a house, and toys only where the name says so.
OTHERS = """
car, sports car, police car, truck, fire truck, bus, train, steam train, boat, ship, airplane, helicopter, army tank,
bicycle, motorcycle, golf cart, sword, dagger, spear, shield, rifle, pistol, gun, cannon, grenade, house, castle,
church, barn, windmill, water tower, bedroom, city street, bridge, dog, cat, horse, duck, fox, wolf, bear, lion,
eagle, robot, knight, wizard, zombie, woman, soldier, dragon, pine tree, rock, boulder, cube, sphere, torus, suzanne,
bunny, terrain, door, window, wall, fence, roof, ring, nut, iron, bat, club, level, tie, nail, panel,
potion, forklift, scandal
"""
# Words that mean several things: known where nothing else is, but a person is asked.
AMBIGUOUS = "brick wall, chest armor, seat belt, cpu cooler, safe house, cable car, bell tower, rope bridge, car grill"
# Nothing is found in these: no word is found inside another.
NOTHING = (
    "Object_3",
    "",
    "  ",
    "0123",
    "日本",
    "059_chain",
    "071_nine_hole_peg_test",
    "canvas",
    "cupid",
    "panda",
    "panel",
)
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
SHIPPED = registry.load()
EVERY = SHIPPED.categories.values()
# Those of the reference runtime, RoboCasa.
ROWS = {c.id: c for c in EVERY if c.runtime}


def words(text: str) -> list[str]:
    return " ".join(text.split()).split(", ")


def found(name: str) -> str | None:
    """The category that the registry knows a name by."""
    match = SHIPPED.find_category([name])
    return match[0].id if match else None


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


def test_every_id_and_alias_finds_its_own_category() -> None:
    named = [(c.id, c.id) for c in EVERY if c.id != registry.FALLBACK]
    named += [(alias, c.id) for c in EVERY for alias in c.aliases]
    matches = {name: SHIPPED.find_category([name]) for name, _ in named}
    assert {name: match and match[0].id for name, match in matches.items()} == dict(named)
    assert min(match[1] for match in matches.values() if match) >= 0.9


def test_rows_of_categories_are_plausible() -> None:
    """Of the density of the bounding box: no more than 1.6 of that of the substance, no less than crumpled wire.

    Shapes are relative to the longest side. An open cavity is part of the outline, so a vessel is lighter than its
    outline filled with its substance. What nobody can name weighs what any category may.
    """
    rows = EVERY
    assert {c.id for c in rows if max(c.shape) != 1 or min(c.shape) <= 0} == set()
    assert {c.id for c in rows if c.upright == "lies" and c.shape[2] > c.shape[0]} == set()
    box = {c.id: c.longest_m.typical**3 * c.shape[0] * c.shape[1] * c.shape[2] for c in rows}
    share = {c.id: c.mass_kg.typical / box[c.id] / SHIPPED.substances[c.substance].density for c in rows}
    assert {name: mass for name, mass in share.items() if mass > 1.6} == {}
    assert {c.id for c in rows if not 10 <= c.mass_kg.typical / box[c.id] <= 4000} == set()
    assert {c.id for c in rows if c.build is MatterFill.VESSEL and share[c.id] >= 1} == set()
    assert SHIPPED.categories[registry.FALLBACK].mass_kg.high >= max(c.mass_kg.high for c in rows)
    assert {s.id for s in SHIPPED.substances.values() if s.dynamic_friction > s.static_friction} == set()


def test_classes_end_at_one_root() -> None:
    assert [c.id for c in SHIPPED.classes.values() if c.parent is None] == ["object"]
    for category in EVERY:
        chain = SHIPPED.classes_of(category)
        assert (chain[0], chain[-1]) == (category.id, "object")
        assert len(set(chain)) == len(chain)
        assert all(SHIPPED.classes[a].parent == b for a, b in pairwise(chain[1:]))
    assert SHIPPED.classes_of("mug") == ("mug", "drinkware", "tableware", "kitchenware", "object")
    with pytest.raises(UnknownId) as caught:
        SHIPPED.category("mugg")
    assert "mug" in caught.value.nearest


def test_limits_and_rejections() -> None:
    assert SHIPPED.limits.keys() == SHIPPED.limit_units.keys()
    assert SHIPPED.limits["hull_vertices"] == 64
    assert SHIPPED.limits["density_low"] < 1 < SHIPPED.limits["density_high"]
    assert {k for k, unit in SHIPPED.limit_units.items() if k.endswith("_m") and unit != "m"} == set()
    assert SHIPPED.rejections["GEO001"].name == "degenerate_shape"
    assert {r.code for r in SHIPPED.rejections.values() if not r.meaning or not r.remedy} == set()
    names = [r.name for r in SHIPPED.rejections.values()]
    assert len(set(names)) == len(names)


def test_a_qcode_is_its_own_or_that_of_the_class_above() -> None:
    for category in EVERY:
        above = SHIPPED.classes[category.parent].qcode
        if category.qcode.certainty is Certainty.PARENT:
            assert (category.qcode.id, category.qcode.label) == (above.id, above.label), category.id
    own = [c.qcode.id for c in EVERY if c.qcode.certainty is not Certainty.PARENT]
    assert [q for q, n in Counter(own).items() if n > 1] == []
    assert SHIPPED.category("mug").qcode.id == "Q386215"
    assert SHIPPED.category("teacup").qcode.label == "teacup"
    assert SHIPPED.category("saucer").qcode.label == "kitchenware"


def test_load_reads_once_and_digest_is_of_the_contents(tmp_path: Path) -> None:
    assert registry.load() is registry.load()
    copy = shutil.copytree(registry.data_root(), tmp_path / "copy")
    assert registry.load(copy).digest == SHIPPED.digest
    with (copy / "waivers.yaml").open("a") as file:
        file.write("# a word more\n")
    registry.load.cache_clear()
    assert registry.load(copy).digest != SHIPPED.digest


def test_names_find_their_category_and_no_word_is_found_inside_another() -> None:
    wanted = dict(row.split(": ") for row in " ".join(NAMES.split()).split("; "))
    wanted |= dict(row.rsplit(" ", 1) for row in words(YCB))
    matches = {text: SHIPPED.find_category([text]) for text in wanted}
    assert {text: match and match[0].id for text, match in matches.items()} == wanted
    assert all(match and 0 < match[1] <= 1 and text in match[2] for text, match in matches.items())
    assert [noun for noun in words(NOUNS) if found(noun) is None] == []
    assert [text for text in (*NOTHING, *words(OTHERS)) if found(text)] == []
    unsure = {name: SHIPPED.find_category([name]) for name in words(AMBIGUOUS)}
    assert [name for name, match in unsure.items() if match is None or match[1] >= 0.5] == []


def test_the_best_hint_decides_and_confidence_falls_from_id_to_alias_to_part_of_a_text() -> None:
    """A weak word yields to a later hint."""
    wanted: dict[tuple[str, ...], str | None] = {("mug", "plate"): "mug", ("a1b2c3", "plate"): "plate", (): None}
    wanted |= {("orange", "coffee mug"): "mug", ("orange", "a1b2c3"): "orange"}
    matches = {hints: SHIPPED.find_category(hints) for hints in wanted}
    assert {hints: match and match[0].id for hints, match in matches.items()} == wanted
    ranks = ["mug", "tea mug", "my old tea mug", "my old mug", "mug that i have", "soapmug"]
    confidences = [match[1] for text in ranks if (match := SHIPPED.find_category([text]))]
    assert len(confidences) == len(ranks)
    assert confidences == sorted(set(confidences), reverse=True)
    later = SHIPPED.find_category(["a1b2c3", "mug"])
    assert later
    assert later[1] < 1


def small(folder: Path, **files: str | None) -> Path:
    """A tiny registry with some files replaced."""
    for name, text in {**SOUND, **files}.items():
        if text is not None:
            (folder / f"{name}.yaml").write_text(text, encoding="utf-8")
    return folder


def test_a_sound_small_registry_loads(tmp_path: Path) -> None:
    loaded = registry.load(small(tmp_path))
    assert loaded.category("mug").longest_m.typical == 0.1
    qcode = loaded.category("mug").qcode
    assert (qcode.certainty, qcode.label) == (Certainty.PARENT, "object")
    assert loaded.waivers[0].subject == "mug_1"
    assert loaded.rejections["GEO001"].code == "GEO001"


def test_faults_name_file_line_and_pointer(tmp_path_factory: pytest.TempPathFactory) -> None:
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
        folder = small(tmp_path_factory.mktemp("small"), **{name: text})
        with pytest.raises(RegistryError) as caught:
            registry.load(folder)
        assert (caught.value.file, caught.value.line, caught.value.pointer) == (f"{name}.yaml", line, pointer)
        assert message in str(caught.value)


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


def test_look_alikes_are_few_and_a_broken_row_is_refused_with_its_place(tmp_path: Path) -> None:
    alike = look_alikes()
    assert alike["mug"] == alike["coffee_cup"] != alike["jug"]
    assert len(alike) < 0.2 * len(EVERY)
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


# Objects of the reference runtime: all of them, whole, and within reason --------------------------------------------


def test_all_of_both_releases_are_there_and_whole() -> None:
    assert set(ROWS) == set(ROBOCASA.split())
    releases = Counter(r for c in ROWS.values() for r in c.runtime)
    assert releases == {RobocasaRelease.V0_2: 153, RobocasaRelease.V1_0: 198}
    assert [c.id for c in ROWS.values() if c.runtime == (RobocasaRelease.V0_2,)] == ["kettle_electric"]
    assert [c.id for c in ROWS.values() if c.size_m is None or not c.prompts] == []
    assert [c.id for c in ROWS.values() if c.basis.uses is not NumberBasis.REFERENCE] == []
    # Of these the reference runtime has no type either.
    assert {c.id for c in ROWS.values() if not c.types} == {"flour_bag", "straw", "tofu", "walnut"}
    assert {kind for c in ROWS.values() for kind in c.types} == set(ObjectType)
    assert {use for c in ROWS.values() for use in c.affords} == set(Affordance)


def test_affordances_and_types_are_those_that_tasks_filter_by() -> None:
    wanted = {name: {LETTERS[letter] for letter in letters} for name, letters in SAMPLE.items()}
    assert {name: set(ROWS[name].affords) - OURS for name in SAMPLE} == wanted
    first = [c for c in ROWS.values() if RobocasaRelease.V0_2 in c.runtime]
    assert {letter: sum(c.can(LETTERS[letter]) for c in first) for letter in USES} == USES
    kinds = Counter(kind for c in first for kind in c.types)
    assert {kind: kinds[kind] for kind in KINDS} == KINDS


def test_sizes_and_masses_are_spans_that_agree_with_the_shape() -> None:
    odd = {}
    for c in ROWS.values():
        for name, span in zip(("x", "y", "z", "mass"), (*c.extents, c.mass_kg), strict=True):
            most = 100 if name == "mass" else 25
            if not 1.1 <= span.high / span.low <= most or not span.low >= 0.0005 or span.high > 20:
                odd[c.id, name] = span
        for span, share in zip(c.extents, c.shape, strict=True):
            assert span.typical == pytest.approx(share * c.longest_m.typical, rel=0.06, abs=0.0011), c.id
            assert span.high <= c.longest_m.high * 1.001, c.id
    assert odd == {}
    for name, (low, high) in MASSES.items():
        span = ROWS[name].mass_kg
        assert low <= span.low <= span.typical <= span.high <= high, name


def test_what_holds_things_is_open_what_stacks_rests_on_a_foot_and_what_lies_lies_along_its_length() -> None:
    holds = {c.id: c.build for c in EVERY if c.can(Affordance.CONTAINER)}
    assert {name for name, build in holds.items() if build in (MatterFill.SOLID, MatterFill.FILLED)} == set()
    assert {"bowl", "mug", "pan", "plate", "tray"} <= holds.keys()
    assert {c.id for c in EVERY if c.can(Affordance.STACKABLE) and c.upright is RestingPose.ANY} == set()
    assert {name: (ROWS[name].upright, ROWS[name].front) for name in POSES} == POSES
    assert [c.id for c in EVERY if c.front is FrontRule.LENGTH and c.shape[0] < max(c.shape[1:])] == []


def test_lvis_names_lead_to_their_category_and_phrases_distinguish_categories() -> None:
    names = {name: c.id for c in EVERY for name in c.lvis}
    assert len(names) > 280
    assert {name: found(name) for name in names} == names
    hard = {"crisp_(potato_chip)": "chips", "fume_hood": "range_hood", "cantaloup": "cantaloupe"}
    assert {name: names[name] for name in hard} == hard
    phrases = Counter(p for c in EVERY for p in c.phrases)
    assert [p for p, n in phrases.items() if n > 1] == []
    assert [p for p in phrases if not p.islower() or p.endswith(".")] == []
