"""Electric kettles as objects: those of the fixtures' family, with fewer collision shapes."""

from __future__ import annotations

from casa_assets.families.fixtures.small import kettle
from casa_assets.families.fixtures.small.kettle import Kettle, KettleForm, KettleHandle
from casa_assets.families.kit.asset_builder import AssetBuilder
from casa_assets.families.parametric_model import ParametricModel
from casa_assets.model.asset.asset import Base

# Bodies that are wide below and narrow above need two rows of staves, the others one.
ROUND = frozenset({KettleForm.RETRO, KettleForm.BELL})


def build(builder: AssetBuilder, p: Kettle) -> None:
    """Build the asset: its bottom is at z = 0, its handle towards +x and its spout towards -x."""
    if p.form in ROUND and p.grip is KettleHandle.LOOP:  # a loop takes a shape more than two rows of staves leave
        kettle.build(builder, p, 10, (0.0, 1.0), (0.1, 0.25, 0.5, 0.75))
    elif p.form in ROUND:
        kettle.build(builder, p, 7, (0.0, 0.5, 1.0))
    else:
        kettle.build(builder, p, 8, (0.0, 1.0))


FORM = ParametricModel("kettle", Kettle, build, base=Base.FREE)
