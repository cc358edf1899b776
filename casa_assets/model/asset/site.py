"""Named points (sites) and volumes (regions) of a link; they touch nothing and weigh nothing."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import field_validator, model_validator

from casa_assets.model.asset.material import Positive
from casa_assets.model.pose import Pose
from casa_assets.model.record import Id, MixedCaseId, Record, Vec3, Vec4


class Site(Record):
    """A named, massless place in a link without contacts: the place of a mug, a flame, a stream of water.

    Attributes:
        kind: a sphere of `radius` (metres), or a box or a cylinder about z of the full `size` (metres).
        color: linear RGBA. Runtimes show a flame or a stream by raising its alpha.
    """

    name: Id
    link: Id = "object"
    pose: Pose = Pose()
    kind: Literal["sphere", "box", "cylinder"] = "sphere"
    radius: Positive = 0.005
    size: Vec3 | None = None
    color: Vec4 = (1.0, 0.033, 0.033, 0.6)

    @model_validator(mode="after")
    def _sized(self) -> Self:
        if (self.kind == "sphere") != (self.size is None):
            raise ValueError(f"site {self.name!r}: a sphere has a radius, a box or cylinder a size")
        if self.size is not None and min(self.size) <= 0:
            raise ValueError(f"site {self.name!r}: size {self.size} must be positive")
        return self


class Region(Record):
    """A named volume in a link: an interior, a shelf, the bounding box. Box (full size) or cylinder about z."""

    name: MixedCaseId
    link: Id = "object"
    pose: Pose = Pose()
    kind: Literal["box", "cylinder"] = "box"
    size: Vec3

    @field_validator("size")
    @classmethod
    def _positive(cls, size: Vec3) -> Vec3:
        if min(size) <= 0:
            raise ValueError(f"region size {size} must be positive")
        return size
