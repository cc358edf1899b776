"""Forms of movable objects in a kitchen; registry/objects/ lists what is made of them."""

from __future__ import annotations

from typing import Any

from casa_assets.families.kit.assemble import Family
from casa_assets.families.objects.containers import container
from casa_assets.families.objects.food import bodies, dough, slab, stacked
from casa_assets.families.objects.grown import cluster, produce
from casa_assets.families.objects.packages import block, package
from casa_assets.families.objects.tools import utensil
from casa_assets.families.objects.vessels import fittings, fixtures, flat, vessel

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
