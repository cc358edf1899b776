"""The code of every family, by name. Their presets are data: `casa_assets.registry.families` joins the two."""

from __future__ import annotations

from typing import Any

from casa_assets.ext.families import Family, Params
from casa_assets.kitchenware.fixtures.cabinets import cabinets, corner_cabinets, housings, island_base
from casa_assets.kitchenware.fixtures.cold import dishwasher, fridges
from casa_assets.kitchenware.fixtures.cooking import hob, hood, microwave, toaster_oven, wall_oven
from casa_assets.kitchenware.fixtures.cooking import range as stove
from casa_assets.kitchenware.fixtures.counters import counters, door, sink, wall_plates, window
from casa_assets.kitchenware.fixtures.decor import candle, cookbook_stack, plant, vase
from casa_assets.kitchenware.fixtures.furniture import ceiling_light, chair, curtain, pendant_light, rug, stool, table
from casa_assets.kitchenware.fixtures.kitchenware import (
    bottle,
    cutting_board,
    dish_rack,
    fruit_bowl,
    jar,
    knife_block,
    paper_towel,
    utensil_holder,
)
from casa_assets.kitchenware.fixtures.room import floors, room_ceiling, room_wall, wall_trim
from casa_assets.kitchenware.fixtures.small import blender, coffee_machine, kettle, stand_mixer, toaster
from casa_assets.kitchenware.fixtures.trim import shelves, trim
from casa_assets.kitchenware.fixtures.wall_decor import clock, picture_frame, spice_rack, utensil_rack
from casa_assets.kitchenware.parts.appliance.front import ApplianceLook
from casa_assets.kitchenware.parts.fronts.fronts import CabinetLook

GROUPS: dict[str, tuple[Family[Any], ...]] = {
    "cabinets": (
        cabinets.BASE_CABINET_MODEL,
        cabinets.WALL_CABINET_MODEL,
        cabinets.TALL_CABINET_MODEL,
        cabinets.DRAWER_STACK_MODEL,
        corner_cabinets.CORNER_CABINET_BLIND_MODEL,
        corner_cabinets.CORNER_CABINET_DIAGONAL_MODEL,
        cabinets.SINK_BASE_MODEL,
        island_base.MODEL,
        housings.HOUSING_OVEN_MODEL,
        housings.HOUSING_MICROWAVE_MODEL,
        housings.HOUSING_FRIDGE_MODEL,
        shelves.OPEN_SHELF_MODEL,
        shelves.FLOATING_SHELF_MODEL,
        trim.CABINET_PANEL_MODEL,
        trim.FILLER_MODEL,
        trim.TOE_KICK_MODEL,
        trim.CORNICE_MODEL,
    ),
    "counters": (
        counters.COUNTER_MODEL,
        counters.COUNTER_CORNER_MODEL,
        counters.COUNTER_ISLAND_MODEL,
        wall_trim.BACKSPLASH_MODEL,
        sink.MODEL,
        window.MODEL,
        door.MODEL,
        wall_plates.OUTLET_MODEL,
        wall_plates.SWITCH_MODEL,
    ),
    "cooking": (
        stove.MODEL,
        hob.MODEL,
        wall_oven.MODEL,
        microwave.MODEL,
        toaster_oven.MODEL,
        hood.MODEL,
    ),
    "cold": (
        fridges.FRIDGE_TOP_FREEZER_MODEL,
        fridges.FRIDGE_BOTTOM_FREEZER_MODEL,
        fridges.FRIDGE_SIDE_BY_SIDE_MODEL,
        fridges.FRIDGE_FRENCH_DOOR_MODEL,
        dishwasher.MODEL,
    ),
    "small": (
        coffee_machine.MODEL,
        toaster.MODEL,
        kettle.MODEL,
        blender.BLENDER_MODEL,
        blender.BLENDER_LID_MODEL,
        stand_mixer.MODEL,
    ),
    "decor": (
        stool.MODEL,
        chair.MODEL,
        table.MODEL,
        plant.MODEL,
        clock.MODEL,
        paper_towel.MODEL,
        utensil_holder.MODEL,
        knife_block.MODEL,
        fruit_bowl.MODEL,
        pendant_light.MODEL,
        ceiling_light.MODEL,
        curtain.MODEL,
        dish_rack.MODEL,
        utensil_rack.MODEL,
        jar.MODEL,
        candle.MODEL,
        vase.MODEL,
        bottle.MODEL,
        spice_rack.MODEL,
        cutting_board.MODEL,
        cookbook_stack.MODEL,
        rug.MODEL,
        picture_frame.MODEL,
    ),
    "room": (
        room_wall.MODEL,
        floors.ROOM_FLOOR_MODEL,
        room_ceiling.MODEL,
        floors.ROOM_COLUMN_MODEL,
        floors.ROOM_RECESS_MODEL,
        wall_trim.SKIRTING_MODEL,
        wall_trim.WALL_PANELLING_MODEL,
    ),
}
MODELS: dict[str, Family[Any]] = {model.name: model for models in GROUPS.values() for model in models}
# Records of looks that members of several families share; `cabinet` has named ones in registry/looks.yaml, and each has
# its rules in registry/look_rules.yaml.
LOOKS: dict[str, type[Params]] = {"cabinet": CabinetLook, "appliance": ApplianceLook}
