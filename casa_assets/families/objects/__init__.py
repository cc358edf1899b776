"""Forms of movable objects in a kitchen; registry/objects/ lists what is made of them."""

from __future__ import annotations

from typing import Any

from casa_assets.families.objects.containers import container
from casa_assets.families.objects.food import crustacean, dough, slab, stacked
from casa_assets.families.objects.grown import cluster, produce
from casa_assets.families.objects.packages import block, package
from casa_assets.families.objects.tools import dish_rack, utensil
from casa_assets.families.objects.vessels import blender_jug, board, electric_kettle, lids, pocket_tray, vessel
from casa_assets.families.parametric_model import ParametricModel

FORMS: dict[str, ParametricModel[Any]] = {
    form.name: form
    for form in (
        dough.FORM,
        cluster.FORM,
        container.FORM,
        produce.FORM,
        slab.FORM,
        crustacean.FORM,
        stacked.FORM,
        utensil.FORM,
        dish_rack.FORM,
        vessel.FORM,
        lids.FORM,
        blender_jug.FORM,
        electric_kettle.FORM,
        board.FORM,
        pocket_tray.FORM,
        package.FORM,
        block.FORM,
    )
}
