"""Forms of movable objects in a kitchen; registry/objects/ lists what is made of them."""

from __future__ import annotations

from typing import Any

from casa_assets.ext.families import Family
from casa_assets.kitchenware.objects.containers import container
from casa_assets.kitchenware.objects.food import bodies, dough, slab, stacked
from casa_assets.kitchenware.objects.grown import cluster, produce
from casa_assets.kitchenware.objects.packages import block, package
from casa_assets.kitchenware.objects.tools import utensil
from casa_assets.kitchenware.objects.vessels import fittings, fixtures, flat, vessel

FORMS: dict[str, Family[Any]] = {
    form.name: form
    for form in (
        dough.FORM,
        cluster.FORM,
        container.FORM,
        produce.FORM,
        slab.FORM,
        bodies.FORM,
        stacked.FORM,
        utensil.FORM,
        fixtures.DISH_RACK,
        vessel.FORM,
        fittings.FORM,
        fixtures.BLENDER_JUG,
        fixtures.ELECTRIC_KETTLE,
        flat.BOARD,
        flat.POCKET_TRAY,
        package.FORM,
        block.FORM,
    )
}
