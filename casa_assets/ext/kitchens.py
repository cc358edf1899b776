"""Records of kitchens: scenes, placements, robots, numbers of contracts; names of their files."""

from __future__ import annotations

from casa_assets.asset.lightweight import light_scene
from casa_assets.model.kitchen.choices import JointWord
from casa_assets.model.kitchen.files import BATCH_FILE, BATCH_JSON, ROBOTS_JSON, SCENE_JSON
from casa_assets.model.kitchen.robot import (
    Arm,
    Following,
    Hand,
    JointReach,
    Legs,
    Miss,
    Robot,
    RobotCertificate,
    SceneRobots,
)
from casa_assets.model.kitchen.scene import (
    FREE_JOINT,
    FREE_WIDTH,
    BatchScene,
    EngineSizes,
    Layer,
    LightScene,
    PlacedJoint,
    PlacedLink,
    Placement,
    Scene,
    StateJoint,
    WorldCollider,
)
from casa_assets.model.kitchen.scene import StartStates as StoredStates
from casa_assets.model.registry.contract import MIN_SURFACE_M, PLATE_DEPTH_M, SHELF_HEIGHTS_M, RobocasaRelease
from casa_assets.model.written_formats import BatchFile

__all__ = [
    "Arm",
    "BATCH_FILE",
    "BATCH_JSON",
    "BatchFile",
    "BatchScene",
    "EngineSizes",
    "Following",
    "FREE_JOINT",
    "FREE_WIDTH",
    "Hand",
    "JointReach",
    "JointWord",
    "Layer",
    "Legs",
    "light_scene",
    "LightScene",
    "MIN_SURFACE_M",
    "Miss",
    "PlacedJoint",
    "PlacedLink",
    "Placement",
    "PLATE_DEPTH_M",
    "RobocasaRelease",
    "Robot",
    "RobotCertificate",
    "ROBOTS_JSON",
    "Scene",
    "SCENE_JSON",
    "SceneRobots",
    "SHELF_HEIGHTS_M",
    "StateJoint",
    "StoredStates",
    "WorldCollider",
]
