"""Forms of movable objects in a kitchen; registry/objects/ lists what is made of them."""

from __future__ import annotations

from typing import Any

from casa_assets.ext.families import Family
from casa_assets.ext.records import Base
from casa_assets.kitchenware.fixtures import dish_rack, kettle
from casa_assets.kitchenware.objects import (
    appliance_vessels,
    block,
    boards,
    cluster,
    container,
    crustacean,
    dough,
    package,
    produce,
    slab,
    stacked,
    utensil,
    vessel,
    vessel_fittings,
)

FORMS: dict[str, Family[Any]] = {
    form.name: form
    for form in (
        Family("dough", dough.Dough, dough.build, base=Base.FREE),
        Family("cluster", cluster.Cluster, cluster.build, base=Base.FREE),
        Family("container", container.Container, container.build_container, base=Base.FREE),
        Family("produce", produce.Produce, produce.build, base=Base.FREE),
        Family("slab", slab.SlabFood, slab.build, base=Base.FREE),
        Family("crustacean", crustacean.Crustacean, crustacean.build, base=Base.FREE),
        Family("stacked", stacked.Stacked, stacked.build, base=Base.FREE),
        Family("utensil", utensil.Utensil, utensil.build, base=Base.FREE),
        Family("dish_rack", dish_rack.DishRack, dish_rack.build, base=Base.FREE),
        Family("vessel", vessel.Vessel, vessel.build, base=Base.FREE),
        Family("vessel_lid", vessel_fittings.SingleLid, vessel_fittings.build_lid, base=Base.FREE),
        Family("blender_jug", appliance_vessels.BlenderJug, appliance_vessels.build_blender_jug, base=Base.FREE),
        Family("kettle", kettle.Kettle, appliance_vessels.build_electric_kettle, base=Base.FREE),
        Family("board", boards.Board, boards.build_board, base=Base.FREE),
        Family("pocket_tray", boards.PocketTray, boards.build_pocket_tray, base=Base.FREE),
        Family("package", package.Package, package.build, base=Base.FREE),
        Family("block", block.Block, block.build, base=Base.FREE),
    )
}
