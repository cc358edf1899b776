"""Forms of movable objects in a kitchen; registry/objects/ lists what is made of them."""

from __future__ import annotations

from typing import Any

from casa_assets.ext.families import Family
from casa_assets.ext.records import Base
from casa_assets.kitchenware.fixtures import dish_rack, kettle
from casa_assets.kitchenware.objects import (
    block,
    bodies,
    cluster,
    container,
    dough_and_slab,
    flat,
    package,
    produce,
    stacked,
    utensil,
    vessel,
    vessel_fittings,
)

FORMS: dict[str, Family[Any]] = {
    form.name: form
    for form in (
        Family("dough", dough_and_slab.Dough, dough_and_slab.build_dough, base=Base.FREE),
        Family("cluster", cluster.Cluster, cluster.build, base=Base.FREE),
        Family("container", container.Container, container.build_container, base=Base.FREE),
        Family("produce", produce.Produce, produce.build, base=Base.FREE),
        Family("slab", dough_and_slab.SlabFood, dough_and_slab.build_slab, base=Base.FREE),
        Family("crustacean", bodies.Crustacean, bodies.build, base=Base.FREE),
        Family("stacked", stacked.Stacked, stacked.build, base=Base.FREE),
        Family("utensil", utensil.Utensil, utensil.build, base=Base.FREE),
        Family("dish_rack", dish_rack.DishRack, dish_rack.build, base=Base.FREE),
        Family("vessel", vessel_fittings.Vessel, vessel.build_vessel, base=Base.FREE),
        Family("vessel_lid", vessel_fittings.SingleLid, vessel_fittings.build, base=Base.FREE),
        Family("blender_jug", flat.BlenderJug, flat.build_blender_jug, base=Base.FREE),
        Family("kettle", kettle.Kettle, flat.build_electric_kettle, base=Base.FREE),
        Family("board", flat.Board, flat.build_board, base=Base.FREE),
        Family("pocket_tray", flat.PocketTray, flat.build_pocket_tray, base=Base.FREE),
        Family("package", package.Package, package.build_package, base=Base.FREE),
        Family("block", block.Block, block.build, base=Base.FREE),
    )
}
