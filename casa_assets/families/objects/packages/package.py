"""Packages of food: cartons, bricks, bags, pouches, tubs, wrapped bars and blocks, with print on them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum
from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from casa_assets.core.numeric import Floats
from casa_assets.families.family import FinishId, Params
from casa_assets.families.kit.assemble import Family
from casa_assets.families.kit.asset_builder import ROOT, AssetBuilder
from casa_assets.families.kit.solids.solid import Solid, box_shape
from casa_assets.families.objects.containers.closures import LID, LID_GRIP, swing_up
from casa_assets.families.objects.packages.bags import pillow, pouch, twist
from casa_assets.families.objects.packages.boxes import brick, carton, gable, lid_seam, paper_bag, wrapped_block
from casa_assets.families.objects.packages.tubs import Part, roll, tub
from casa_assets.families.objects.packages.wrapping import LYING_ALONG, LYING_BACK
from casa_assets.model.asset.asset import Base
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec2

Metres = Annotated[float, Field(gt=0, le=0.5)]
Small = Annotated[float, Field(ge=0, le=0.1)]
Share = Annotated[float, Field(ge=0, le=1)]


class Shape(StrEnum):
    """Kind of package."""

    CARTON = "carton"
    GABLE = "gable"  # a carton folded to a ridge above
    BRICK = "brick"  # a brick of drink with a straw
    BLOCK = "block"  # a block wrapped in paper or foil, its ends folded
    PAPER_BAG = "paper_bag"
    PILLOW = "pillow"  # a bag or wrapper of film with a crimped strip at both ends
    POUCH = "pouch"  # a bag that stands
    TWIST = "twist"  # a sweet in twisted paper
    TUB = "tub"
    ROLL = "roll"  # of foil or film


class Rest(StrEnum):
    """How a package lies; all its dimensions are those of the upright package."""

    STANDS = "stands"
    BACK = "back"  # on its back, its upper end away from the viewer
    ALONG = "along"  # its height along x, its back up


class Package(Params):
    """Parameters of a package; lengths in metres, of the upright package, its front to -y.

    Attributes:
        shape, rest: kind of package, and how it lies.
        width, depth, height: overall; of bags, width is that of the empty bag and depth that of the full one.
        front, side: shares of the picture's width on the front and on each adjacent side, as in the label's recipe.
        lower, upper: shares of the picture's height on the lower and on the upper end, likewise.
        along: the picture's width runs along the height; each side shows all of it.
        edge: radius of upright edges. bulge: of the sides. dents: depth of their unevenness. seed: of random details.
        flap: where the flaps of a carton meet, relative to half the depth; near 1 there is a single flap.
        window, window_wide: height and width of a pane in a carton's front, shares; window_finish is seen through it.
        opens: the upper end of a carton is a lid that swings up; below it the carton is empty, down to `fill` of the
            height.
        spout: above 0, a carton has a sheet metal spout at its side.
        roof: share of the height of a gable, or of the folds of a paper bag. fin: height of the ridge's seam; of
            twisted paper, the width of its ends. cap_radius: of a screw cap on a gable or a pouch, 0 for no cap.
        straw: how far a straw projects from a brick; 0 for a straw in a wrapper on the back.
        seam: a flap of the seam at the back. roll: half the thickness of the rolled end of a paper bag, 0 for a folded
            end. tie: the roll has a strip of tin.
        bare: share of a wrapped block at its upper end that is unwrapped; content is its finish; rows and columns are
            its segments if it is a tablet; liner: how far foil projects from the paper there.
        crimp: height of a sealed strip, or of twisted paper at each end. teeth: the strip has a serrated edge. pleats:
            depth of the folds. full: bluntness of the ends of the filled part; round_by: the same of its sides. sag:
            how much deeper the back is than half the depth, as a share of that; 0 if front and back are equally deep.
            zip_line: a pouch has a zip.
        profile: (width, height) of a tub from foot to flange, shares. curved: it is a smooth curve. corner: radius of a
            tub's corners relative to half the width, 1 for a round tub. flange: how far it projects. flutes: number of
            upright ones. lid_rise: height of the lid; from 3 mm on it is made of plastic. tongue, tongue_turn: length
            and direction of a tongue to pull it off. fill: share of the height that is filled, if the content can be
            seen.
        heft: mass of the whole per volume of its body, kg/m^3.
        skin, fitting, lid, rim_finish, content, window_finish: finishes of the package, of its cap, straw or tie, of a
            tub's lid, of its flange, of the content of a clear one, and of what is behind a window.
    """

    shape: Shape
    rest: Rest = Rest.STANDS
    width: Metres
    depth: Metres
    height: Metres
    front: Annotated[float, Field(ge=0.1, le=0.9)] = 0.36
    side: Annotated[float, Field(ge=0, le=0.4)] = 0.14
    lower: Annotated[float, Field(ge=0, le=0.4)] = 0.04
    upper: Annotated[float, Field(ge=0, le=0.4)] = 0.04
    along: bool = False
    edge: Small = 0.0012
    bulge: Small = 0.0015
    dents: Small = 0.0004
    seed: Annotated[int, Field(ge=0, le=9999)] = 0
    flap: Annotated[float, Field(ge=-1, le=1)] = 0.1
    window: Annotated[float, Field(ge=0, le=0.8)] = 0.0
    window_wide: Share = 0.7
    window_finish: FinishId = "pasta_dry"
    opens: bool = False
    spout: Small = 0.0
    roof: Annotated[float, Field(ge=0, le=0.5)] = 0.15
    fin: Small = 0.012
    cap_radius: Small = 0.0
    straw: Small = 0.0
    seam: bool = False
    roll: Small = 0.0
    tie: bool = False
    bare: Share = 0.0
    rows: Annotated[int, Field(ge=0, le=8)] = 0
    columns: Annotated[int, Field(ge=0, le=12)] = 0
    liner: Small = 0.0
    crimp: Small = 0.012
    teeth: bool = True
    pleats: Annotated[float, Field(ge=0, le=0.5)] = 0.1
    full: Annotated[float, Field(ge=1, le=12)] = 3.0
    round_by: Annotated[float, Field(ge=1.2, le=12)] = 2.2
    sag: Annotated[float, Field(ge=-0.9, le=0.9)] = 0.0
    zip_line: bool = False
    profile: Annotated[tuple[Vec2, ...], Field(min_length=2, max_length=14)] = ((0.8, 0.0), (1.0, 1.0))
    curved: bool = False
    corner: Annotated[float, Field(ge=0.1, le=1)] = 1.0
    flange: Annotated[float, Field(ge=0, le=0.012)] = 0.003
    flutes: Annotated[int, Field(ge=0, le=24)] = 0
    lid_rise: Small = 0.0006
    tongue: Small = 0.008
    tongue_turn: Annotated[float, Field(ge=-3.2, le=3.2)] = -0.8
    fill: Share = 0.85
    heft: Annotated[float, Field(gt=5, le=3000)] = 400.0
    skin: FinishId
    fitting: FinishId = "plastic_white"
    lid: FinishId = "foil_silver"
    rim_finish: FinishId = "plastic_white"
    content: FinishId | None = None

    @model_validator(mode="after")
    def _can_open(self) -> Package:
        if self.opens and (self.shape is not Shape.CARTON or self.rest is not Rest.STANDS or self.spout > 0):
            raise ValueError(f"a carton without a spout that stands is expected to open, got a {self.shape}")
        return self

    @property
    def density(self) -> float:
        """kg/m^3 of the body, which weighs all."""
        return self.heft

    def rng(self) -> np.random.Generator:
        """The generator of what is random in its form."""
        return np.random.Generator(np.random.PCG64(self.seed))


SHAPES: Mapping[Shape, Callable[[Package], list[Part]]] = {
    Shape.CARTON: carton,
    Shape.GABLE: gable,
    Shape.BRICK: brick,
    Shape.BLOCK: wrapped_block,
    Shape.PAPER_BAG: paper_bag,
    Shape.PILLOW: pillow,
    Shape.POUCH: pouch,
    Shape.TWIST: twist,
    Shape.TUB: tub,
    Shape.ROLL: roll,
}
# Collision shapes of an open carton's walls are so thick, metres; its lid turns so far, rad.
WALL, LID_SWING = 0.002, 1.9
POSES = {Rest.STANDS: Pose(), Rest.BACK: LYING_BACK, Rest.ALONG: LYING_ALONG}


def build(builder: AssetBuilder, p: Package) -> None:
    """Build the asset: it rests on z = 0."""
    parts = SHAPES[p.shape](p)
    everything = np.concatenate([part.solid.points for part in parts])
    pose = POSES[p.rest]
    lowest = float(pose.apply(everything)[:, 2].min())
    at = Pose(position=(0.0, 0.0, -lowest)) @ pose
    colliders = [solid.transformed(at) for solid in _colliders(p, parts[0].solid, everything)]
    for k, part in enumerate(parts):
        solid = part.solid.transformed(at)
        if part.swings:
            _lid(builder, part, solid)
            continue
        if k == 0:
            solid = solid.with_colliders_of(*colliders)
        elif part.collider and not solid.shapes:
            solid = solid.with_hull_collider()
        touched = k == 0 or part.collider
        builder.add(ROOT, solid, part.finish, label=part.label, collider=touched, density=part.density)


def _lid(builder: AssetBuilder, part: Part, solid: Solid) -> None:
    """The lid of a carton, on a hinge at its back."""
    low, high = solid.bounds
    hinge = (0.0, float(high[1]), float(low[2]))
    builder.link(LID, hinge)
    placed = solid.translated(*(-v for v in hinge))
    builder.add(LID, placed, part.finish, label=part.label, name="lid", collider=LID_GRIP, density="cardboard_flap")
    swing_up(builder, (-1.0, 0.0, 0.0), LID_SWING)


def _colliders(p: Package, body: Solid, everything: Floats) -> list[Solid]:
    """Collision shapes of the body, standing: boxes where it has flat sides, else hulls."""
    low, high = body.bounds
    match p.shape:
        case Shape.CARTON if p.opens:
            level, top, t = p.fill * p.height, lid_seam(p), WALL
            (x0, y0, _), (x1, y1, _) = low, high
            below = box_shape((x0, y0, 0.0), (x1, y1, level))
            # The lid swings past the back, which bulges less up here.
            y1 = p.depth / 2
            walls = [
                ((x0, y0, level), (x0 + t, y1, top)),
                ((x1 - t, y0, level), (x1, y1, top)),
                ((x0 + t, y0, level), (x1 - t, y0 + t, top)),
                ((x0 + t, y1 - t, level), (x1 - t, y1, top)),
            ]
            return [body.with_shapes(below, *(box_shape(a, b) for a, b in walls))]
        case Shape.CARTON | Shape.BRICK | Shape.BLOCK:
            top = high[2] if p.bare > 0 else p.height
            shape = box_shape((low[0], low[1], 0.0), (high[0], high[1], top))
            return [body.with_shapes(shape)]
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


FORM = Family("package", Package, build, base=Base.FREE)
