"""Names that strangers give to things of a house: those that the registry knows, and what it must not take for one."""

from __future__ import annotations

from casa_assets import registry

# Object names of the YCB set, and what each is here (-: nothing). Those of figures and parts are what they are.
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
058_golf_ball ball, 059_chain -, 061_foam_brick foam_block, 062_dice dice, 063-a_marbles glass_marble, 065-a_cups cup,
070-a_colored_wood_blocks building_block, 071_nine_hole_peg_test -, 072-a_toy_airplane toy, 073-a_lego_duplo toy,
076_timer timer, 077_rubiks_cube toy
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
bunny, terrain, door, window, wall, fence, roof, ring, nut, iron, bat, club, level, tie, nail
"""
# Words that mean several things: known where nothing else is, but a person is asked.
AMBIGUOUS = "brick wall, chest armor, seat belt, cpu cooler, safe house, cable car, bell tower, rope bridge, car grill"
# Names of which the whole counts.
WHOLE = """
chicken_soup_bowl: bowl, beef stew: food_bowl, oculus headset: vr_headset, gaming headset: headphones, toy car: toy,
chess knight: chess_piece, computer desk: desk, console table: table, wine cooler bucket: bucket, wall socket:
light_switch, dress shoe: shoe, bell pepper: bell_pepper, doll house: dollhouse, glue gun: glue_gun, pocket watch:
watch
"""


def words(text: str) -> list[str]:
    return " ".join(text.split()).split(", ")


def found(name: str) -> str | None:
    """The category that the registry knows a name by."""
    match = registry.load().find_category([name])
    return match[0].id if match else None


def test_names_are_those_of_their_categories() -> None:
    ycb = [row.rsplit(" ", 1) for row in words(YCB)]
    assert {name: found(name) or "-" for name, _ in ycb} == dict(ycb)
    whole = [row.split(": ") for row in words(WHOLE)]
    assert {name: found(name) for name, _ in whole} == dict(whole)


def test_nouns_of_a_house_are_known_and_others_stay_unknown() -> None:
    assert [noun for noun in words(NOUNS) if found(noun) is None] == []
    assert [name for name in words(OTHERS) if found(name)] == []


def test_ambiguous_words_are_not_sure() -> None:
    matches = {name: registry.load().find_category([name]) for name in words(AMBIGUOUS)}
    assert [name for name, match in matches.items() if match is None or match[1] >= 0.5] == []
