"""Parameters of vessels: their profile, handles, spout, lid, holes and finishes."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

from pydantic import Field

from casa_assets.families.family import FinishId, Params
from casa_assets.families.objects.vessels.lids import KnobForm
from casa_assets.model.record import Vec2

Metres = Annotated[float, Field(gt=0, le=0.7)]
Length = Annotated[float, Field(ge=0, le=0.4)]
Share = Annotated[float, Field(ge=0, le=1)]


class HandleForm(StrEnum):
    """Where a hand takes it."""

    NONE = "none"
    EAR = "ear"  # the handle of a mug
    EARS = "ears"  # two of them
    LONG = "long"  # the handle of a pan, in one piece
    GRIP = "grip"  # the same with a grip of another finish
    LOOPS = "loops"  # level loops on both sides
    LONG_LOOP = "long_loop"  # a long grip, and a level loop across
    ARCH = "arch"  # over the top


class Vessel(Params):
    """Parameters of a vessel; lengths in metres.

    Attributes:
        profile: the outside from the edge of the foot to the rim, (radius, height), relative to half the width and to
            the height. soft: a smooth curve runs through these points; otherwise corners are rounded by `rounding`.
        width, height: of the body. across: the width in y relative to that in x. corner: radius of the corners seen
            from above, relative to half the smaller width; 1 for round or oval.
        wall: its thickness. floor: thickness of the floor. stem: share of the height that is below the floor of the
            inside.
        fillet: radius between floor and wall inside. foot: height of a hollow under the foot.
        facets, flutes, flute_depth, twist, fluted_from: as in `Plan`. weave, stakes, rows: strands of a basket.
        lip, lip_width, lip_rise, lip_from: of a spout drawn out of the rim, as in `Plan`.
        bead: radius of a wire around the rim.
        handle: kind of handle. handle_reach: how far it projects; the length of a long one; the height of an arch.
            handle_top, handle_low: ends of an ear, relative to the height. handle_width, handle_thick: of its section.
            handle_square: 1 for round, less for corners. handle_sag: of an ear. handle_rise: of a long one, rad.
            handle_hole: radius of a hole in its end.
        spout: how far a tubular spout projects. spout_from, spout_to: heights of its ends, relative to the height.
            spout_radius: at the wall. spout_tip: radius at its tip. spout_curve: 0 straight, 1 bent.
        lid: it has a lid on it. lid_opens: the lid can be lifted off, and the vessel is hollow below it. lid_rise,
            lid_dome, lid_over: its height, its shape, how far it reaches over the rim. lid_skirt: how far it reaches
            down outside. lid_thick: of its sheet. lid_sip: it has a raised edge and a hole to drink from. lid_bead:
            radius of a ring of metal around it. knob, knob_size: the part by which it is lifted.
        hole: radius of holes in its wall, 0 for no holes. hole_gap: distance between two. holes_from, holes_to: lowest
            and highest, relative to the height.
        wires: number of wires of a sieve, from its middle to its rim; its wall is then gauze.
        content: filling level, relative to the height. marks: lines of a measure. sleeve: a band of card around the
            middle.
        matter: share of the wall's volume that is solid material.
        skin, rim_finish, handle_finish, grip_finish, lid_finish, knob_finish, lid_bead_finish, content_finish,
            mark_finish: finishes. skin may be a picture for the whole vessel; its height runs from the middle of the
            underside (0) over the rim (0.5) to the middle of the inside (1).
    """

    profile: Annotated[tuple[Vec2, ...], Field(min_length=2, max_length=20)]
    soft: bool = True
    rounding: Length = 0.004
    width: Metres
    height: Metres
    across: Annotated[float, Field(ge=0.3, le=1)] = 1.0
    corner: Share = 1.0
    wall: Annotated[float, Field(ge=0.0006, le=0.02)] = 0.004
    floor: Annotated[float, Field(ge=0.0006, le=0.04)] = 0.005
    stem: Share = 0.0
    fillet: Length = 0.006
    foot: Annotated[float, Field(ge=0, le=0.03)] = 0.0
    facets: Annotated[int, Field(ge=0, le=20)] = 0
    flutes: Annotated[int, Field(ge=0, le=40)] = 0
    flute_depth: Annotated[float, Field(ge=0, le=0.3)] = 0.03
    twist: Annotated[float, Field(ge=-3, le=3)] = 0.0
    fluted_from: Share = 0.0
    weave: Annotated[float, Field(ge=0, le=0.01)] = 0.0
    stakes: Annotated[int, Field(ge=8, le=48)] = 32
    rows: Annotated[int, Field(ge=3, le=20)] = 8
    lip: Length = 0.0
    lip_width: Annotated[float, Field(ge=0.1, le=1.5)] = 0.4
    lip_rise: Annotated[float, Field(ge=-0.05, le=0.1)] = 0.0
    lip_from: Annotated[float, Field(ge=0, le=0.95)] = 0.55
    bead: Annotated[float, Field(ge=0, le=0.02)] = 0.0
    handle: HandleForm = HandleForm.NONE
    handle_reach: Length = 0.03
    handle_top: Annotated[float, Field(ge=0, le=1.2)] = 0.85
    handle_low: Share = 0.2
    handle_width: Metres = 0.014
    handle_thick: Metres = 0.008
    handle_square: Annotated[float, Field(ge=0.3, le=1.2)] = 0.8
    handle_sag: Annotated[float, Field(ge=-0.5, le=0.5)] = 0.0
    handle_rise: Annotated[float, Field(ge=-0.3, le=0.9)] = 0.15
    handle_hole: Annotated[float, Field(ge=0, le=0.012)] = 0.0
    spout: Length = 0.0
    spout_from: Share = 0.3
    spout_to: Annotated[float, Field(ge=0, le=1.4)] = 0.9
    spout_radius: Metres = 0.016
    spout_tip: Metres = 0.008
    spout_curve: Share = 0.6
    lid: bool = False
    lid_opens: bool = False
    lid_rise: Length = 0.02
    lid_dome: Annotated[float, Field(ge=1, le=12)] = 2.5
    lid_over: Annotated[float, Field(ge=-0.03, le=0.02)] = 0.002
    lid_skirt: Length = 0.0
    lid_thick: Annotated[float, Field(ge=0.0006, le=0.01)] = 0.003
    lid_sip: bool = False
    lid_bead: Annotated[float, Field(ge=0, le=0.006)] = 0.0
    knob: KnobForm = KnobForm.BALL
    knob_size: Metres = 0.012
    hole: Annotated[float, Field(ge=0, le=0.02)] = 0.0
    hole_gap: Metres = 0.02
    holes_from: Share = 0.2
    holes_to: Share = 0.85
    wires: Annotated[int, Field(ge=0, le=40)] = 0
    content: Share = 0.0
    marks: Annotated[int, Field(ge=0, le=12)] = 0
    sleeve: bool = False
    matter: Annotated[float, Field(ge=0.05, le=1)] = 1.0
    skin: FinishId
    rim_finish: FinishId = "stainless_brushed"
    handle_finish: FinishId | None = None
    grip_finish: FinishId = "plastic_black"
    lid_finish: FinishId | None = None
    knob_finish: FinishId | None = None
    lid_bead_finish: FinishId = "stainless_polished"
    content_finish: FinishId = "coffee_dark"
    mark_finish: FinishId = "plastic_red"
