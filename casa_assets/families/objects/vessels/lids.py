"""Lids of vessels: a dome or a flat cover with a knob, a bow or a tab."""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Annotated

import numpy as np
from pydantic import Field

from casa_assets.families.family import FinishId, Params
from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.objects.closed_surface import ellipsoid
from casa_assets.families.objects.opening import LID_GRIP
from casa_assets.families.objects.vessels.fittings import arch, knob, rim_bead
from casa_assets.families.objects.vessels.surface import Plan, patched, round_plan, surface
from casa_assets.families.parametric_model import ParametricModel
from casa_assets.model.asset.asset import Base

# Radius of the raised edge of a lid to drink through, metres.
SIP_EDGE = 0.0028


class KnobForm(StrEnum):
    """Form of the part by which a lid is lifted."""

    NONE = "none"
    BALL = "ball"
    FLAT = "flat"  # a wide disc on a neck
    CONE = "cone"  # tall
    BOW = "bow"  # a strap


@dataclass(frozen=True)
class Lid:
    """A lid; lengths in metres.

    Attributes:
        radius: half its width along x. rise: height of its top over its rim. dome: 2 round, more for flat tops with
            steep sides. thick: of its sheet. skirt: how far its rim reaches down outside. sip: it has a raised edge and
            a hole to drink from, as a lid of a paper cup.
        bead: radius of a ring of metal round it, 0 for none.
        knob, knob_size: what it is lifted by, and its radius or half length.
        finish, knob_finish, bead_finish: finishes.
    """

    radius: float
    rise: float
    dome: float
    thick: float
    skirt: float
    sip: bool
    bead: float
    knob: KnobForm
    knob_size: float
    finish: str
    knob_finish: str
    bead_finish: str


def add_lid(builder: AssetBuilder, lid: Lid, plan: Plan, z: float, link: str = ROOT) -> None:
    """Add a lid whose rim lies at height z; `plan` is the outline of the vessel seen from above.

    On a separate link it can be lifted: its collision shapes are then above its rim, and its grip is LID_GRIP.
    """
    flat = replace(plan, lip=0.0, lip_rise=0.0, facets=0, flutes=0, weave=0.0, around=min(plan.around, 40))
    flat = replace(flat, half_x=lid.radius, half_y=plan.half_y + lid.radius - plan.half_x, height=1.0)
    if plan.corner is not None:
        flat = replace(flat, corner=plan.corner + lid.radius - plan.half_x)
    s = np.concatenate([[0.0], np.linspace(0.2, 1.0, 6)])
    dome = 1 - s**lid.dome
    inset = lid.thick * (1.2 if lid.skirt > 0 else 1.0)
    top = np.stack([s * (lid.radius - 0.4 * lid.thick), z + lid.thick + (lid.rise - lid.thick) * dome], axis=1)
    below = np.stack([s * (lid.radius - inset), z + max(lid.rise - lid.thick, 0.0) * dome], axis=1)[[0, 2, 4, 5, 6]]
    edge = [(lid.radius, z - lid.skirt), (lid.radius, z + 0.6 * lid.thick)]
    if lid.skirt > 0:
        edge = [(lid.radius - 0.6 * lid.thick, z - lid.skirt), *edge]
    # Its top shows what the picture has between the foot and the rim of a vessel.
    v = [np.linspace(0.9, 0.6, len(below)), np.linspace(0.46, 0.44, len(edge)), np.linspace(0.43, 0.24, len(top))]
    body = surface(np.concatenate([below, np.array(edge), top[::-1]]), np.concatenate(v), flat)
    is_loose = link != ROOT
    low = z if is_loose else -np.inf
    above = np.column_stack([body.points[:, :2], body.points[:, 2].clip(low)])
    body = body.with_colliders_of(replace(body, points=above).with_hull_collider())
    grip = LID_GRIP if is_loose and lid.knob is KnobForm.NONE else "lid"
    builder.add(link, body, lid.finish, label="lid", name="lid", collider=grip)
    if lid.bead > 0:
        ring = rim_bead(flat.ring(lid.radius, z + 0.3 * lid.thick), lid.bead)
        builder.add(link, patched(ring), lid.bead_finish, label="lid", collider=False)
    if lid.sip:
        _add_sip(builder, lid, flat, z + lid.rise, link)
    _add_knob(builder, lid, z + lid.rise, link)


def _add_sip(builder: AssetBuilder, lid: Lid, plan: Plan, top: float, link: str) -> None:
    """Add the raised edge of a lid to drink through, and the hole in it at the front."""
    edge = rim_bead(plan.ring(0.8 * lid.radius, top + 0.2 * SIP_EDGE), SIP_EDGE)
    builder.add(link, patched(edge), lid.finish, label="lid", collider=False, density=0.0)
    hole = ellipsoid((0.32 * lid.radius, 0.12 * lid.radius, 0.0016), 16, 5).translated(y=-0.62 * lid.radius, z=top)
    builder.add(link, patched(hole), "soil", label="hole", collider=False, density=0.0)


def _add_knob(builder: AssetBuilder, lid: Lid, top: float, link: str) -> None:
    """Add what the lid is lifted by; its foot is in the lid."""
    size = lid.knob_size
    if lid.knob is KnobForm.NONE:
        return
    if lid.knob is KnobForm.BOW:
        part = arch(size, top - 0.004, top + 0.75 * size, 0.35 * size, 0.18 * size, 0.6)
    else:
        shape = {KnobForm.BALL: (1.0, 1.7, 0.5), KnobForm.FLAT: (1.0, 1.0, 0.45), KnobForm.CONE: (0.8, 2.4, 0.55)}
        wide, tall, slim = shape[lid.knob]
        part = knob(wide * size, tall * size, slim).translated(z=top - 0.0006)
    grip = "knob" if link == ROOT else LID_GRIP
    builder.add(link, patched(part), lid.knob_finish, label="knob", name="knob", collider=grip)


class SingleLid(Params):
    """Parameters of a lid that lies by itself; lengths in metres.

    Attributes: as of `Lid`; width is its diameter.
    """

    width: Annotated[float, Field(ge=0.06, le=0.4)]
    rise: Annotated[float, Field(ge=0.004, le=0.12)]
    dome: Annotated[float, Field(ge=1, le=12)] = 2.5
    thick: Annotated[float, Field(ge=0.0006, le=0.01)] = 0.003
    skirt: Annotated[float, Field(ge=0, le=0.03)] = 0.0
    bead: Annotated[float, Field(ge=0, le=0.006)] = 0.0
    knob: KnobForm = KnobForm.BALL
    knob_size: Annotated[float, Field(ge=0.006, le=0.06)] = 0.015
    skin: FinishId
    knob_finish: FinishId = "plastic_black"
    bead_finish: FinishId = "stainless_polished"


def build(builder: AssetBuilder, p: SingleLid) -> None:
    """Build the asset: it lies on z = 0, its rim below."""
    finishes = (p.skin, p.knob_finish, p.bead_finish)
    lid = Lid(p.width / 2, p.rise, p.dome, p.thick, p.skirt, False, p.bead, p.knob, p.knob_size, *finishes)
    low = max(p.skirt, p.bead - 0.3 * p.thick)
    add_lid(builder, lid, replace(round_plan(p.width / 2, 40), height=p.rise), low)


FORM = ParametricModel("vessel_lid", SingleLid, build, base=Base.FREE)
