"""Forms of objects that stand about in a kitchen and can be moved; registry/objects/ says what is made of them."""

from __future__ import annotations

from typing import Any

from casa_assets.families.objects import produce
from casa_assets.families.parametric_model import ParametricModel

FORMS: dict[str, ParametricModel[Any]] = {form.name: form for form in (produce.FORM,)}
