"""Forms of objects that stand about in a kitchen and can be moved; registry/objects/ says what is made of them."""

from __future__ import annotations

from typing import Any

from casa_assets.families.objects import (
    block,
    board,
    cluster,
    container,
    dough,
    package,
    pocket_tray,
    produce,
    slab_food,
    stacked,
    utensil,
    vessel,
    vessel_lids,
)
from casa_assets.families.parametric_model import ParametricModel

FORMS: dict[str, ParametricModel[Any]] = {
    form.name: form
    for form in (
        dough.FORM,
        cluster.FORM,
        container.FORM,
        produce.FORM,
        slab_food.FORM,
        stacked.FORM,
        utensil.FORM,
        vessel.FORM,
        vessel_lids.FORM,
        board.FORM,
        pocket_tray.FORM,
        package.FORM,
        block.FORM,
    )
}
