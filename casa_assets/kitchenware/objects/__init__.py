"""Forms of movable objects in a kitchen; registry/objects/ lists what is made of them."""

from __future__ import annotations

from typing import Any

from casa_assets.ext.families import Family
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
        dough_and_slab.DOUGH_FORM, cluster.FORM, container.CONTAINER_FORM, produce.FORM, dough_and_slab.SLAB_FORM,
        bodies.FORM, stacked.FORM, utensil.FORM, flat.DISH_RACK, vessel.VESSEL_FORM, vessel_fittings.FORM,
        flat.BLENDER_JUG, flat.ELECTRIC_KETTLE, flat.BOARD, flat.POCKET_TRAY, package.PACKAGE_FORM, block.FORM,
)
}  # fmt: skip
