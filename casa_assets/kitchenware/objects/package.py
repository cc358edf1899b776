"""Packages of food with print on them: cartons, bricks, bags, pouches, tubs, wrapped bars and blocks."""

from __future__ import annotations

from enum import StrEnum
from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from casa_assets.ext.arrays import Floats
from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.records import Pose, Vec2
from casa_assets.ext.solids import ROOT, AssetBuilder, Solid, box_shape
from casa_assets.kitchenware.objects import package_forms
from casa_assets.kitchenware.objects.closures import LID, LID_GRIP, swing_up
from casa_assets.kitchenware.objects.wrapping import LYING_ALONG, LYING_BACK

Metres = Annotated[float, Field(gt=0, le=0.5)]
Small = Annotated[float, Field(ge=0, le=0.1)]
Share = Annotated[float, Field(ge=0, le=1)]

# Kind of package: GABLE a carton folded to a ridge above; BRICK a brick of drink with a straw; BLOCK a block wrapped in
# paper or foil, its ends folded; PILLOW a bag or wrapper of film with a crimped strip at both ends; POUCH a bag that
# stands; TWIST a sweet in twisted paper; ROLL of foil or film.
Shape = StrEnum("Shape", "CARTON GABLE BRICK BLOCK PAPER_BAG PILLOW POUCH TWIST TUB ROLL")

# How the upright package lies: BACK on its back, its upper end away from the viewer; ALONG along x, its back up.
Rest = StrEnum("Rest", "STANDS BACK ALONG")


class Package(Params):
    """Parameters of a package; lengths in metres, of the upright package, its front to -y."""

    shape: Shape = Field(description="kind of package")
    rest: Rest = Field(Rest.STANDS, description="how it lies")
    width: Metres = Field(description="of bags that of the empty bag, m")
    depth: Metres = Field(description="of bags that of the full bag, m")
    height: Metres = Field(description="m")
    front: float = Field(0.36, ge=0.1, le=0.9, description="share of the picture's width, as in the label's recipe")
    side: float = Field(0.14, ge=0, le=0.4, description="the same on each adjacent side")
    lower: float = Field(0.04, ge=0, le=0.4, description="share of the picture's height on the lower end")
    upper: float = Field(0.04, ge=0, le=0.4, description="the same on the upper end")
    along: bool = Field(False, description="the picture's width runs along the height; each side shows all of it")
    edge: Small = Field(0.0012, description="radius of upright edges, m")
    bulge: Small = Field(0.0015, description="of the sides, m")
    dents: Small = Field(0.0004, description="depth of the sides' unevenness, m")
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    flap: float = Field(0.1, ge=-1, le=1, description="where flaps meet, by half the depth; near 1: a single flap")
    window: float = Field(0.0, ge=0, le=0.8, description="height of a pane in a carton's front, by the height")
    window_wide: Share = Field(0.7, description="width of the pane, by the width")
    window_finish: FinishId = Field("pasta_dry", description="what is seen through the pane")
    opens: bool = Field(False, description="a carton's upper end is a lid that swings up over a hollow down to `fill`")
    spout: Small = Field(0.0, description="above 0, a carton has a sheet metal spout at its side")
    roof: float = Field(0.15, ge=0, le=0.5, description="of a gable or a paper bag's folds, by the height")
    fin: Small = Field(0.012, description="height of the ridge's seam; width of the ends of twisted paper, m")
    cap_radius: Small = Field(0.0, description="of a screw cap on a gable or a pouch, m; 0: none")
    straw: Small = Field(0.0, description="how far a straw projects from a brick, m; 0: in a wrapper on the back")
    seam: bool = Field(False, description="a flap of the seam at the back")
    roll: Small = Field(0.0, description="half the thickness of a paper bag's rolled end, m; 0: a folded end")
    tie: bool = Field(False, description="the roll has a strip of tin")
    bare: Share = Field(0.0, description="share of a wrapped block at its upper end that is unwrapped")
    rows: int = Field(0, ge=0, le=8, description="segments of the block if it is a tablet, else 0")
    columns: int = Field(0, ge=0, le=12, description="segments of a tablet")
    liner: Small = Field(0.0, description="how far foil projects from the paper of a bare block, m")
    crimp: Small = Field(0.012, description="height of a sealed strip, or of twisted paper at each end, m")
    teeth: bool = Field(True, description="the strip has a serrated edge")
    pleats: float = Field(0.1, ge=0, le=0.5, description="depth of the folds")
    full: float = Field(3.0, ge=1, le=12, description="bluntness of the ends of the filled part")
    round_by: float = Field(2.2, ge=1.2, le=12, description="bluntness of its sides")
    sag: float = Field(0.0, ge=-0.9, le=0.9, description="how much deeper the back is than half the depth, by that")
    zip_line: bool = Field(False, description="a pouch has a zip")
    profile: tuple[Vec2, ...] = Field(
        ((0.8, 0.0), (1.0, 1.0)),
        min_length=2,
        max_length=14,
        description="(width, height) of a tub from foot to flange, shares",
    )
    curved: bool = Field(False, description="the profile of a tub is a smooth curve")
    corner: float = Field(1.0, ge=0.1, le=1, description="radius of a tub's corners by half the width; 1: round")
    flange: float = Field(0.003, ge=0, le=0.012, description="how far it projects, m")
    flutes: int = Field(0, ge=0, le=24, description="upright ones of a tub")
    lid_rise: Small = Field(0.0006, description="height of a tub's lid, m; from 3 mm on it is of plastic")
    tongue: Small = Field(0.008, description="length of a tongue to pull the lid off, m")
    tongue_turn: float = Field(-0.8, ge=-3.2, le=3.2, description="direction of the tongue, rad")
    fill: Share = Field(0.85, description="share of the height that is filled, if the content can be seen")
    heft: float = Field(400.0, gt=5, le=3000, description="mass of the whole per volume of its body, kg/m^3")
    skin: FinishId
    fitting: FinishId = Field("plastic_white", description="of cap, straw or tie")
    lid: FinishId = Field("foil_silver", description="of a tub")
    rim_finish: FinishId = Field("plastic_white", description="of a tub's flange")
    content: FinishId | None = Field(None, description="of a clear package, or of a bare block")

    @model_validator(mode="after")
    def _can_open(self) -> Package:
        if self.opens and (self.shape is not Shape.CARTON or self.rest is not Rest.STANDS or self.spout > 0):
            raise ValueError(f"a carton without a spout that stands is expected to open, got a {self.shape}")
        return self


# Collision shapes of an open carton's walls are so thick, metres; its lid turns so far, rad.
WALL, LID_SWING = 0.002, 1.9
POSES = {Rest.STANDS: Pose(), Rest.BACK: LYING_BACK, Rest.ALONG: LYING_ALONG}


def build(builder: AssetBuilder, p: Package) -> None:
    """Build the asset: it rests on z = 0."""
    parts = package_forms.FORMS[p.shape](p)
    everything = np.concatenate([part.solid.points for part in parts])
    pose = POSES[p.rest]
    at = Pose(position=(0.0, 0.0, -float(pose.apply(everything)[:, 2].min()))) @ pose
    colliders = [solid.transformed(at) for solid in _colliders(p, parts[0].solid, everything)]
    for k, part in enumerate(parts):
        solid = part.solid.transformed(at)
        if part.swings:
            low, high = solid.bounds
            hinge = (0.0, float(high[1]), float(low[2]))
            builder.link(LID, hinge)
            placed, density = solid.translated(*(-v for v in hinge)), "cardboard_flap"
            builder.add(LID, placed, part.finish, label=part.label, name="lid", collider=LID_GRIP, density=density)
            swing_up(builder, (-1.0, 0.0, 0.0), LID_SWING)
            continue
        if k == 0:
            solid = solid.with_colliders_of(*colliders)
        elif part.collider and not solid.shapes:
            solid = solid.with_hull_collider()
        touched = k == 0 or part.collider
        builder.add(ROOT, solid, part.finish, label=part.label, collider=touched, density=part.density)


def _colliders(p: Package, body: Solid, everything: Floats) -> list[Solid]:
    low, high = body.bounds
    match p.shape:
        case Shape.CARTON if p.opens:
            level, top, t = p.fill * p.height, package_forms.lid_seam(p), WALL
            (x0, y0, _), (x1, y1, _) = low, high
            below = box_shape((x0, y0, 0.0), (x1, y1, level))
            # The lid swings past the back, which bulges less up here.
            y1 = p.depth / 2
            walls = [
                ((x0, y0, level), (x0 + t, y1, top)), ((x1 - t, y0, level), (x1, y1, top)),
                ((x0 + t, y0, level), (x1 - t, y0 + t, top)), ((x0 + t, y1 - t, level), (x1 - t, y1, top)),
            ]  # fmt: skip
            return [body.with_shapes(below, *(box_shape(a, b) for a, b in walls))]
        case Shape.CARTON | Shape.BRICK | Shape.BLOCK:
            top = high[2] if p.bare > 0 else p.height
            return [body.with_shapes(box_shape((low[0], low[1], 0.0), (high[0], high[1], top)))]
        case Shape.GABLE | Shape.PAPER_BAG:
            wall = p.height * (1.0 - p.roof) - p.fin
            upper = Solid(body.points[body.points[:, 2] > wall - 0.001], body.faces[:0]).with_hull_collider()
            return [body.with_shapes(box_shape((low[0], low[1], 0.0), (high[0], high[1], wall))), upper]
        case Shape.TWIST:
            # Boxes do not roll; all of them reach down to what it lies on, its front.
            edges = (low[2], p.crimp, p.height - p.crimp, high[2])
            within = [body.points[(body.points[:, 2] >= a) & (body.points[:, 2] <= b)] for a, b in pairwise(edges)]
            boxes = [
                box_shape((q[:, 0].min(), low[1], a), (q[:, 0].max(), q[:, 1].max(), b))
                for q, (a, b) in zip(within, pairwise(edges), strict=True)
            ]
            return [body.with_shapes(*boxes)]
        case Shape.TUB:
            return [Solid(everything, body.faces[:0]).with_hull_collider()]
    return [body.with_hull_collider()]
