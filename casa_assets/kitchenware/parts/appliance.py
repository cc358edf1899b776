"""Look of large appliances: forms and finishes of their fronts, and pulls."""

from __future__ import annotations

from enum import StrEnum

import numpy as np
from pydantic import Field

from casa_assets.ext.families import FinishId, Params
from casa_assets.ext.solids import Placed, box, box_shape, rectangle, rod, tube
from casa_assets.kitchenware.parts.fronts import FrontKind
from casa_assets.kitchenware.parts.handles import Handle, collider_box, grip_capsule

# Pulls of large appliances: stouter than those of cabinets, along x on the plane y = 0, standing out to -y.

AppliancePull = StrEnum("AppliancePull", "TUBE PRO BLADE BOW BOXED LEDGE LATCH")

LATCH_LENGTH = 0.2  # metres; a latch has one length and lies across

# Shape of a front: FLAT folded sheet with sharp edges; SOFT edges of about a centimetre; ROUND edges as round as a bun:
# the fifties; PANEL a cabinet's front is hung on it; GLASS a pane in a frame of metal.
ApplianceFront = StrEnum("ApplianceFront", "FLAT SOFT ROUND PANEL GLASS")

ApplianceKick = StrEnum("ApplianceKick", "GRILLE PLINTH FEET")


def appliance_pull(kind: AppliancePull, length: float) -> Handle:
    """A pull of a length in metres; its first collision shape is what a hand takes."""
    return _MAKERS[kind](length)


def _post_boxes(at: float, reach: float, width: float, height: float) -> tuple[Placed, ...]:
    return tuple(collider_box(x, -reach, 0.0, width, height) for x in (-at, at))


def _tube(length: float) -> Handle:
    radius, reach, at = 0.0105, 0.05, length / 2 - 0.04
    grip = rod(radius, length, 0.002, "x").translated(y=-reach)
    posts = [rod(0.008, reach, 0.001, "y").translated(x, -reach / 2) for x in (-at, at)]
    roses = [rod(0.012, 0.004, 0.001, "y").translated(x, -0.002) for x in (-at, at)]
    shapes = (grip_capsule(length, radius, -reach), *_post_boxes(at, reach - radius, 0.02, 0.02))
    return Handle((grip, *posts, *roses), shapes)


def _pro(length: float) -> Handle:
    radius, reach, at = 0.0145, 0.056, length / 2 - 0.055
    grip = rod(radius, length, 0.003, "x").translated(y=-reach)
    rings = [rod(radius + 0.0025, 0.007, 0.0012, "x").translated(s * (length / 2 - 0.014), -reach) for s in (-1, 1)]
    posts = [box((0.03, reach, 0.026), (x, -reach / 2, 0.0), 0.006, 3) for x in (-at, at)]
    plates = [box((0.05, 0.005, 0.04), (x, -0.0025, 0.0), 0.002) for x in (-at, at)]
    shapes = (grip_capsule(length, radius, -reach), *_post_boxes(at, reach - radius, 0.04, 0.034))
    return Handle((grip, *rings, *posts, *plates), shapes)


def _blade(length: float) -> Handle:
    reach, thickness, at = 0.048, 0.009, length / 2 - 0.05
    grip = box((length, thickness, 0.03), (0.0, -reach, 0.0), 0.002, 2)
    posts = [box((0.016, reach, 0.016), (x, -reach / 2, 0.0), 0.0015) for x in (-at, at)]
    shape = box_shape((-length / 2, -reach - thickness / 2, -0.015), (length / 2, -reach + thickness / 2, 0.015))
    return Handle((grip, *posts), (shape, *_post_boxes(at, reach - thickness, 0.016, 0.016)))


def _bow(length: float) -> Handle:
    reach, h = 0.056, length / 2 - 0.012
    steps = np.linspace(-1.0, 1.0, 17)
    path = [(float(s) * h, float(-reach * (1 - abs(s) ** 5)) if abs(s) < 0.999 else 0.0, 0.0) for s in steps]
    grip = tube(path, rectangle(0.016, 0.026, 0.007, 3))
    plates = [box((0.026, 0.005, 0.034), (s * h, -0.0025, 0.0), 0.002, 2) for s in (-1, 1)]
    inner = 0.62 * h
    shapes = [box_shape((-inner, -reach - 0.008, -0.013), (inner, -reach + 0.012, 0.013))]
    for s in (-1, 1):
        for a, b, near, far in ((0.62, 0.84, 0.5, 1.06), (0.84, 1.0, 0.0, 0.72)):
            ends = sorted((s * a * h, s * b * h))
            shapes.append(box_shape((ends[0], -far * reach, -0.013), (ends[1], -near * reach, 0.013)))
    return Handle((grip, *plates), tuple(shapes))


def _boxed(length: float) -> Handle:
    thickness, reach = 0.018, 0.05
    h = length / 2 - thickness / 2
    path = [(-h, 0.0, 0.0), (-h, -reach, 0.0), (h, -reach, 0.0), (h, 0.0, 0.0)]
    grip = tube(path, rectangle(thickness, thickness, 0.003, 2))
    t = thickness / 2
    shape = box_shape((-length / 2, -reach - t, -t), (length / 2, -reach + t, t))
    return Handle((grip,), (shape, *_post_boxes(h, reach - thickness / 2, thickness, thickness)))


def _ledge(length: float) -> Handle:
    reach, thickness = 0.03, 0.006
    web = box((length, reach, 0.005), (0.0, -reach / 2, 0.0), 0.001)
    hook = box((length, thickness, 0.02), (0.0, -reach + thickness / 2, 0.0076), 0.0018, 2)
    shapes = (
        box_shape((-length / 2, -reach, -0.0024), (length / 2, -reach + thickness, 0.0176)),
        box_shape((-length / 2, -reach + thickness, -0.0025), (length / 2, 0.0, 0.0025)),
    )
    return Handle((web, hook), shapes)


def _latch(length: float) -> Handle:
    h, reach = LATCH_LENGTH / 2, 0.046
    plate = box((2 * h, 0.009, 0.044), (0.0, -0.0045, 0.0), 0.0088, 4)
    post = rod(0.017, reach - 0.006, 0.003, "y").translated(0.62 * h, -(reach - 0.006) / 2)
    steps = np.linspace(-1.0, 1.0, 9)
    path = [(float(0.94 * s * h), float(-reach + 0.008 * s * s), 0.0) for s in steps]
    lever = tube(path, rectangle(0.016, 0.03, 0.0075, 4))
    shapes = (
        box_shape((-0.94 * h, -reach - 0.008, -0.015), (0.94 * h, -reach + 0.015, 0.015)),
        box_shape((0.62 * h - 0.017, -reach + 0.015, -0.017), (0.62 * h + 0.017, 0.0, 0.017)),
        box_shape((-h, -0.009, -0.022), (h, 0.0, 0.022)),
    )
    return Handle((lever, plate, post), shapes)


_MAKERS = dict(zip(AppliancePull, (_tube, _pro, _blade, _bow, _boxed, _ledge, _latch), strict=True))


class ApplianceLook(Params):
    """Style of large appliances: form and finish of the fronts, the pull, and the base below the doors."""

    form: ApplianceFront = Field(ApplianceFront.FLAT, description="of the front")
    pull: AppliancePull = Field(AppliancePull.TUBE, description="kind of pull")
    kick: ApplianceKick = Field(ApplianceKick.GRILLE, description="kind of plinth")
    front: FrontKind = Field(FrontKind.SHAKER, description="kind of cabinet front of the form `panel`")
    face: FinishId = Field("stainless_brushed", description="finish of the fronts")
    lower: FinishId | None = Field(None, description="finish of the lower or left front; null: as `face`")
    body: FinishId = Field("enamel_grey", description="finish of sides and back")
    metal: FinishId = Field("stainless_polished", description="finish of pulls")
    trim: FinishId = Field("plastic_grey_light", description="finish of shelf edges and rails inside")
    share: float = Field(0.5, ge=0.2, le=0.9, description="of the height of a door that its pull takes")
    badge: bool = Field(True, description="a plate without a name")
    display: bool = Field(False, description="a touch panel in the front")

    @property
    def thick(self) -> float:
        """Thickness of a door, metres."""
        return {ApplianceFront.ROUND: 0.07, ApplianceFront.PANEL: 0.068}.get(self.form, 0.056)


# Hinges about x of flaps, heads and oven doors: a spring carries the weight, friction holds the link in place.
