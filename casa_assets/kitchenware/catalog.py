"""The code of every family, by name. Their presets are data: `casa_assets.registry.families` joins the two."""

from __future__ import annotations

from typing import Any

from casa_assets.ext.families import Family, Params
from casa_assets.ext.records import Base
from casa_assets.kitchenware.fixtures import (
    blender,
    boards,
    cabinets,
    clocks,
    coffee_machine,
    cookers,
    corners,
    dish_rack,
    dishwasher,
    fridges,
    furniture,
    holders,
    hood,
    kettle,
    lamps,
    microwave,
    openings,
    pictures,
    plants,
    room,
    room_trim,
    sink,
    stand_mixer,
    textiles,
    toasters,
    trim,
    vases,
    wall_plates,
    wall_racks,
    worktops,
)
from casa_assets.kitchenware.parts.appliance import ApplianceLook
from casa_assets.kitchenware.parts.carcass import build_housing
from casa_assets.kitchenware.parts.fronts import CabinetLook

FREE = Base.FREE

# fmt: off
GROUPS: dict[str, tuple[Family[Any], ...]] = {
    "cabinets": (
        Family("base_cabinet", cabinets.BaseCabinet, cabinets.build_base_cabinet),
        Family("wall_cabinet", cabinets.WallCabinet, cabinets.build_wall_cabinet),
        Family("tall_cabinet", cabinets.TallCabinet, cabinets.build_tall_cabinet),
        Family("drawer_stack", cabinets.DrawerStack, cabinets.build_drawer_stack, contract="drawer"),
        Family("corner_cabinet_blind", corners.CornerCabinetBlind, corners.build_blind, contract="single_cabinet"),
        Family("corner_cabinet_diagonal", corners.CornerCabinetDiagonal, corners.build_diagonal,
            contract="single_cabinet"),
        Family("sink_base", cabinets.SinkBase, cabinets.build_sink_base),
        Family("island_base", cabinets.IslandBase, cabinets.build_island_base, cabinets.sample_island_base,
            contract="island_base"),
        Family("housing_oven", cabinets.HousingOven, build_housing, contract="housing_cabinet"),
        Family("housing_microwave", cabinets.HousingMicrowave, build_housing, contract="housing_cabinet"),
        Family("housing_fridge", cabinets.HousingFridge, cabinets.build_housing_fridge, contract="housing_cabinet"),
        Family("open_shelf", trim.OpenShelf, trim.build_open_shelf, contract="open_cabinet"),
        Family("floating_shelf", trim.FloatingShelf, trim.build_floating_shelf, contract="open_cabinet"),
        Family("cabinet_panel", trim.CabinetPanel, trim.build_cabinet_panel, contract="panel_cabinet"),
        Family("filler", trim.Filler, trim.build_filler, contract="panel_cabinet"),
        Family("toe_kick", trim.ToeKick, trim.build_toe_kick, contract="panel_cabinet"),
        Family("cornice", trim.Cornice, trim.build_cornice, contract="panel_cabinet"),
    ),
    "counters": (
        Family("counter", worktops.Counter, worktops.build_counter, worktops.sample_counter, contract="counter"),
        Family("counter_corner", worktops.CornerCounter, worktops.build_counter_corner, contract="counter"),
        Family("counter_island", worktops.Island, worktops.build_counter_island, worktops.sample_counter_island,
            contract="counter"),
        Family("backsplash", room_trim.Backsplash, room_trim.build_backsplash, room_trim.sample_backsplash,
            contract="backsplash"),
        Family("sink", sink.Sink, sink.build_sink, sink.sample_sink, contract="sink"),
        Family("window", openings.Window, openings.build_window, contract="window"),
        Family("door", openings.Door, openings.build_door, contract="door"),
        Family("outlet", wall_plates.Outlet, wall_plates.build_outlet, contract="outlet"),
        Family("switch", wall_plates.Switch, wall_plates.build_switch, contract="switch"),
    ),
    "cooking": (
        Family("range", cookers.Range, cookers.build_range, contract="stove"),
        Family("hob", cookers.Hob, cookers.build_hob, contract="stovetop"),
        Family("wall_oven", cookers.WallOven, cookers.build_wall_oven, contract="oven"),
        Family("microwave", microwave.Microwave, microwave.build, contract="microwave"),
        Family("toaster_oven", toasters.ToasterOven, toasters.build_toaster_oven, contract="toaster_oven", base=FREE),
        Family("hood", hood.Hood, hood.build, contract="hood"),
    ),
    "cold": (
        Family("fridge_top_freezer", fridges.FridgeTopFreezer, fridges.build_top_freezer,
            contract="fridge_top_freezer"),
        Family("fridge_bottom_freezer", fridges.FridgeBottomFreezer, fridges.build_bottom_freezer,
            contract="fridge_bottom_freezer"),
        Family("fridge_side_by_side", fridges.FridgeSideBySide, fridges.build_side_by_side, fridges.sample_side_by_side,
            contract="fridge_side_by_side"),
        Family("fridge_french_door", fridges.FridgeFrenchDoor, fridges.build_french_door, fridges.sample_french_door,
            contract="fridge_french_door"),
        Family("dishwasher", dishwasher.Dishwasher, dishwasher.build_dishwasher, contract="dishwasher"),
    ),
    "small": (
        Family("coffee_machine", coffee_machine.CoffeeMachine, coffee_machine.build, coffee_machine.sample,
            contract="coffee_machine", base=FREE),
        Family("toaster", toasters.Toaster, toasters.build_toaster, contract="toaster", base=FREE),
        Family("kettle", kettle.Kettle, kettle.build, contract="electric_kettle", base=FREE),
        Family("blender", blender.Blender, blender.build_blender, blender.sample_blender, contract="blender",
            base=FREE),
        Family("blender_lid", blender.BlenderLid, blender.build_blender_lid, contract="blender_lid", base=FREE),
        Family("stand_mixer", stand_mixer.StandMixer, stand_mixer.build_stand_mixer, contract="stand_mixer", base=FREE),
    ),
    "decor": (
        Family("stool", furniture.Stool, furniture.build_stool, contract="stool", base=FREE),
        Family("chair", furniture.Chair, furniture.build_chair, contract="chair", base=FREE),
        Family("table", furniture.Table, furniture.build_table, contract="table", base=FREE),
        Family("plant", plants.Plant, plants.build_plant, contract="plant", base=FREE),
        Family("wall_clock", clocks.Clock, clocks.build_clock, contract="clock"),
        Family("paper_towel", holders.PaperTowel, holders.build_paper_towel, contract="paper_towel"),
        Family("utensil_holder", holders.UtensilHolder, holders.build_utensil_holder, contract="utensil_holder",
            base=FREE),
        Family("knife_block", holders.KnifeBlock, holders.build_knife_block, contract="knife_block", base=FREE),
        Family("fruit_bowl", plants.FruitBowl, plants.build_fruit_bowl, contract="accessory", base=FREE),
        Family("pendant_light", lamps.Pendant, lamps.build_pendant_light, contract="light"),
        Family("ceiling_light", lamps.CeilingLight, lamps.build_ceiling_light, contract="light"),
        Family("curtain", textiles.Curtain, textiles.build_curtain, contract="curtain"),
        Family("dish_rack", dish_rack.DishRack, dish_rack.build, contract="dish_rack", base=FREE),
        Family("utensil_rack", wall_racks.UtensilRack, wall_racks.build_utensil_rack, contract="utensil_rack"),
        Family("jar", vases.StorageJar, vases.build_jar, contract="accessory", base=FREE),
        Family("candle", vases.Candle, vases.build_candle, contract="accessory", base=FREE),
        Family("vase", vases.Vase, vases.build_vase, contract="accessory", base=FREE),
        Family("bottle", holders.Bottle, holders.build_bottle, contract="accessory", base=FREE),
        Family("spice_rack", wall_racks.SpiceRack, wall_racks.build_spice_rack, contract="accessory", base=FREE),
        Family("cutting_board", boards.CuttingBoard, boards.build_cutting_board, contract="accessory", base=FREE),
        Family("cookbook_stack", boards.Cookbooks, boards.build_cookbook, contract="accessory", base=FREE),
        Family("rug", textiles.Rug, textiles.build_rug, contract="accessory", base=FREE),
        Family("picture_frame", pictures.Picture, pictures.build_picture, pictures.sample_picture,
            contract="wall_accessory"),
    ),
    "room": (
        Family("room_wall", room.Wall, room.build_room_wall, room.sample_room_wall, contract="room"),
        Family("room_floor", room.Floor, room.build_room_floor, room.sample_room_floor, contract="room"),
        Family("room_ceiling", room_trim.Ceiling, room_trim.build_room_ceiling, room_trim.sample_room_ceiling,
            contract="room"),
        Family("room_column", room.Column, room.build_room_column, contract="room"),
        Family("room_recess", room.Recess, room.build_room_recess, contract="room"),
        Family("skirting", room_trim.Skirting, room_trim.build_skirting, contract="room"),
        Family("wall_panelling", room_trim.Panelling, room_trim.build_wall_panelling, contract="room"),
    ),
}
# fmt: on
MODELS: dict[str, Family[Any]] = {model.name: model for models in GROUPS.values() for model in models}
# Looks that families share; those of `cabinet` are in registry/looks.yaml, rules of all in registry/look_rules.yaml.
LOOKS: dict[str, type[Params]] = {"cabinet": CabinetLook, "appliance": ApplianceLook}
