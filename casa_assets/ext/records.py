"""Records and errors: poses, shapes, materials, bases, registry rows."""

from __future__ import annotations

from casa_assets.model.asset.asset import (
    TEST_SHARE,
    Base,
    Collider,
    Exclusion,
    Inertial,
    JointKind,
    Link,
    Region,
    Site,
    Split,
    Visual,
    split_of,
)
from casa_assets.model.asset.asset import Joint as AssetJoint
from casa_assets.model.asset.behavior import Condition, EffectKind
from casa_assets.model.asset.parts import Box, Capsule, Cylinder, Hull, Mesh, Shape, Sphere, joint_positions
from casa_assets.model.issue import Files, Severity
from casa_assets.model.kitchen.scene import OUTER_FACE
from casa_assets.model.pose import Pose
from casa_assets.model.record import Id, Record, Vec2, Vec3, Vec4, Vec5, without_blanks
from casa_assets.model.registry.category import Affordance, Category, Portion, RestingPose
from casa_assets.model.registry.rows import HexColor, Surface, TextureRecipe

__all__ = [
    "Affordance",
    "Base",
    "Box",
    "Capsule",
    "Category",
    "Collider",
    "Condition",
    "Cylinder",
    "EffectKind",
    "Exclusion",
    "Files",
    "HexColor",
    "Hull",
    "Id",
    "Inertial",
    "AssetJoint",
    "joint_positions",
    "JointKind",
    "Link",
    "Mesh",
    "OUTER_FACE",
    "Portion",
    "Pose",
    "Record",
    "Region",
    "RestingPose",
    "Severity",
    "Shape",
    "Site",
    "Sphere",
    "Split",
    "split_of",
    "Surface",
    "TEST_SHARE",
    "TextureRecipe",
    "Vec2",
    "Vec3",
    "Vec4",
    "Vec5",
    "Visual",
    "without_blanks",
]
