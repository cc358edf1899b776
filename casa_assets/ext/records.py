"""Records and errors: poses, shapes, materials, bases, registry rows."""

from __future__ import annotations

from casa_assets.model.asset.asset import Base
from casa_assets.model.asset.behavior import Condition, EffectKind
from casa_assets.model.asset.parts import Capsule, Cylinder, Hull, Mesh, Sphere
from casa_assets.model.issue import Severity
from casa_assets.model.kitchen.scene import OUTER_FACE
from casa_assets.model.pose import Pose
from casa_assets.model.record import Id, Record, Vec2, Vec3, Vec4, Vec5, without_blanks
from casa_assets.model.registry.category import Portion
from casa_assets.model.registry.rows import HexColor, Surface, TextureRecipe

__all__ = [
    "Base",
    "Capsule",
    "Condition",
    "Cylinder",
    "EffectKind",
    "HexColor",
    "Hull",
    "Id",
    "Mesh",
    "OUTER_FACE",
    "Portion",
    "Pose",
    "Record",
    "Severity",
    "Sphere",
    "Surface",
    "TextureRecipe",
    "Vec2",
    "Vec3",
    "Vec4",
    "Vec5",
    "without_blanks",
]
