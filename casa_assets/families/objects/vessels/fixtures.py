"""Objects made of fixtures' families: jugs of blenders, electric kettles, dish racks."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from casa_assets.families.family import FinishId, Params
from casa_assets.families.fixtures.kitchenware.dish_rack import DishRack, build
from casa_assets.families.fixtures.small import kettle
from casa_assets.families.fixtures.small.kettle import Kettle, KettleForm, KettleHandle
from casa_assets.families.kit.assemble import Family
from casa_assets.families.kit.asset_builder import AssetBuilder
from casa_assets.families.objects.containers.closures import LID, lift_off
from casa_assets.families.parts.appliance.blender_jar import (
    BlenderJar,
    Cover,
    Jar,
    add_cover,
    add_jar,
    add_jar_handle,
)
from casa_assets.model.asset.asset import Base

# Blender jug ----------------------------------------------------------------------------------------------------------
# Jugs of blenders by themselves: a jar with blades, a scale and a handle, with or without its cover.


class BlenderJug(Params):
    """Parameters of a blender's jug; lengths in metres.

    Attributes:
        jar: its section. height, top, foot: of the glass, and half width at the mouth and at the foot.
        handle_reach, handle_low: how far the handle projects, and the height of its lower end relative to that of the
            glass.
        lid: it has a cover that can be lifted. thickness, cap_radius, cap_height: of the cover and its filler cap.
        grip, glass, cap: finishes of collar, handle and cover, of the jar, of the filler cap.
    """

    jar: BlenderJar = BlenderJar.ROUND
    height: Annotated[float, Field(ge=0.1, le=0.25)]
    top: Annotated[float, Field(ge=0.045, le=0.085)]
    foot: Annotated[float, Field(ge=0.035, le=0.065)]
    handle_reach: Annotated[float, Field(ge=0.035, le=0.06)] = 0.045
    handle_low: Annotated[float, Field(ge=0.05, le=0.4)] = 0.2
    lid: bool = True
    thickness: Annotated[float, Field(ge=0.012, le=0.022)] = 0.015
    cap_radius: Annotated[float, Field(ge=0.018, le=0.034)] = 0.026
    cap_height: Annotated[float, Field(ge=0.01, le=0.03)] = 0.014
    grip: FinishId = "plastic_black"
    glass: FinishId = "glass_clear"
    cap: FinishId = "plastic_clear"


def build_blender_jug(builder: AssetBuilder, p: BlenderJug) -> None:
    """Build the asset: its bottom is at z = 0, its handle towards +x."""
    jar = Jar(p.jar, p.height, p.top, p.foot, p.grip, p.glass, p.handle_reach, p.handle_low, True)
    add_jar(builder, jar, 0.0)
    add_jar_handle(builder, jar, 0.0)
    if p.lid:
        builder.link(LID, (0.0, 0.0, jar.rim))
        cap = (p.cap_radius, p.cap_height, p.grip, p.cap, "filler_cap")
        add_cover(builder, Cover(p.jar, p.top, p.thickness, *cap), LID)
        lift_off(builder, 2 * p.top)


BLENDER_JUG = Family("blender_jug", BlenderJug, build_blender_jug, base=Base.FREE)

# Electric kettle ------------------------------------------------------------------------------------------------------
# Electric kettles as objects: those of the fixtures' family, with fewer collision shapes.

# Bodies that are wide below and narrow above need two rows of staves, the others one.
ROUND = frozenset({KettleForm.RETRO, KettleForm.BELL})


def build_electric_kettle(builder: AssetBuilder, p: Kettle) -> None:
    """Build the asset: its bottom is at z = 0, its handle towards +x and its spout towards -x."""
    if p.form in ROUND and p.grip is KettleHandle.LOOP:  # a loop takes a shape more than two rows of staves leave
        kettle.build(builder, p, 10, (0.0, 1.0), (0.1, 0.25, 0.5, 0.75))
    elif p.form in ROUND:
        kettle.build(builder, p, 7, (0.0, 0.5, 1.0))
    else:
        kettle.build(builder, p, 8, (0.0, 1.0))


ELECTRIC_KETTLE = Family("kettle", Kettle, build_electric_kettle, base=Base.FREE)

# Dish rack ------------------------------------------------------------------------------------------------------------
# Dish racks as objects: those of the fixtures' family, with a region for each plate.

DISH_RACK = Family("dish_rack", DishRack, build, base=Base.FREE)
