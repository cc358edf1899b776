"""The code of a family: the type of its parameters, and the function that builds a member."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic

import numpy as np

from casa_assets.families.family import AvailableFinishes, P, Supplies
from casa_assets.families.kit.assemble import assemble
from casa_assets.families.kit.asset_builder import AssetBuilder
from casa_assets.model.asset.asset import Asset, Base


@dataclass(frozen=True)
class ParametricModel(Generic[P]):
    """Code of a family.

    Attributes:
        name: such as `microwave`; registry/families/<name>.yaml holds its title, category and presets.
        params: the type of its parameters.
        add_parts: adds links, joints, sites and regions of a member to an empty builder; no randomness.
        sample: draws a member, if the rules under `sample:` of the family's file cannot express it.
        contract: id in registry/contracts/, if `add_parts` does not choose it.
        base: FREE if a member is a movable object.
    """

    name: str
    params: type[P]
    add_parts: Callable[[AssetBuilder, P], None]
    sample: Callable[[np.random.Generator, AvailableFinishes], P] | None = None
    contract: str | None = None
    base: Base = Base.FIXED

    def build(self, params: P, supplies: Supplies) -> Asset:
        """The asset of a member's numbers."""
        builder = AssetBuilder(supplies, self.base)
        builder.contract = self.contract
        self.add_parts(builder, params)
        return assemble(builder, self.name, params)
