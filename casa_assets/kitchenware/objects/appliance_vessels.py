"""Vessels of appliances: the jug of a blender, and electric kettles."""

from __future__ import annotations

from pydantic import Field

from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.solids import AssetBuilder
from casa_assets.kitchenware.fixtures import kettle
from casa_assets.kitchenware.fixtures.blender import BlenderJar, Cover, Jar, add_cover, add_jar, add_jar_handle
from casa_assets.kitchenware.fixtures.kettle import Kettle, KettleForm, KettleHandle
from casa_assets.kitchenware.objects.closures import LID, lift_off

# Bodies that are wide below and narrow above need two rows of staves, the others one.
ROUND = frozenset({KettleForm.RETRO, KettleForm.BELL})


class BlenderJug(Params):
    """Parameters of a blender's jug; lengths in metres."""

    jar: BlenderJar = Field(BlenderJar.ROUND, description="its section")
    height: float = Field(ge=0.1, le=0.25, description="of the glass, m")
    top: float = Field(ge=0.045, le=0.085, description="half width at the mouth, m")
    foot: float = Field(ge=0.035, le=0.065, description="half width at the foot, m")
    handle_reach: float = Field(0.045, ge=0.035, le=0.06, description="how far the handle projects, m")
    handle_low: float = Field(0.2, ge=0.05, le=0.4, description="height of the handle's lower end by that of the glass")
    lid: bool = Field(True, description="it has a cover that can be lifted")
    thickness: float = Field(0.015, ge=0.012, le=0.022, description="of the cover, m")
    cap_radius: float = Field(0.026, ge=0.018, le=0.034, description="of the cover's filler cap, m")
    cap_height: float = Field(0.014, ge=0.01, le=0.03, description="of the filler cap, m")
    grip: FinishId = Field("plastic_black", description="of collar, handle and cover")
    glass: FinishId = Field("glass_clear", description="of the jar")
    cap: FinishId = Field("plastic_clear", description="of the filler cap")


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


def build_electric_kettle(builder: AssetBuilder, p: Kettle) -> None:
    """Build the asset: its bottom is at z = 0, its handle towards +x and its spout towards -x."""
    if p.form in ROUND and p.grip is KettleHandle.LOOP:  # a loop takes a shape more than two rows of staves leave
        kettle.build(builder, p, 10, (0.0, 1.0), (0.1, 0.25, 0.5, 0.75))
    elif p.form in ROUND:
        kettle.build(builder, p, 7, (0.0, 0.5, 1.0))
    else:
        kettle.build(builder, p, 8, (0.0, 1.0))
