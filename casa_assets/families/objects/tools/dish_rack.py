"""Dish racks as objects: those of the fixtures' family, with a region for each plate."""

from __future__ import annotations

from casa_assets.families.fixtures.kitchenware.dish_rack import DishRack, build
from casa_assets.families.parametric_model import ParametricModel
from casa_assets.model.asset.asset import Base

FORM = ParametricModel("dish_rack", DishRack, build, base=Base.FREE)
