"""Small scenes made of the assets of the tests, and where things in them should stand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from enum import StrEnum
from functools import cache
from pathlib import Path
from typing import Any

from casa_assets.asset.lightweight import light_scene
from casa_assets.checks.readers.facts import asset_facts
from casa_assets.formats.mjcf import kitchen as mjcf
from casa_assets.formats.usd import kitchen as usd
from casa_assets.mesh.inertia import ready_to_simulate
from casa_assets.model.asset.asset import Base, JointValue, Keyframe
from casa_assets.model.issue import Files
from casa_assets.model.kitchen.scene import Camera, Layer, Light, LightKind, LightScene, Placement, Scene, StartStates
from casa_assets.model.pose import Pose
from tests.support.asset.articulated_assets import drawer_unit, grill, microwave
from tests.support.asset.assets import ball, rigid_mug, textured_box, write_to

QUARTER = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
TILTED = (math.cos(0.3), math.sin(0.3), 0.0, 0.0)


class Weight(StrEnum):
    FULL = "full"
    LIGHT = "light"


def in_form(scene: Scene, weight: Weight) -> Scene | LightScene:
    return scene if weight is Weight.FULL else light_scene(scene)


def at(x: float, y: float, z: float, quaternion: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)) -> Pose:
    return Pose(position=(x, y, z), quaternion=quaternion)


@cache
def corner() -> Scene:
    """A fixed oven twice (one turned and ajar), a grill with named poses twice, a free oven, a driven drawer, mugs."""
    oven, barbecue, unit = microwave(), grill(), drawer_unit()
    loose = microwave(Base.FREE).replace(id="oven_9876543210")
    mug, orange, carton = rigid_mug(), ball(), textured_box()
    # As a fixture that hangs: its root does not stand at the origin of the asset.
    raised = unit.replace(links=(unit.root.replace(pose=at(0.0, 0.01, 0.2)), *unit.links[1:]))
    ajar = (JointValue(joint="microjoint", value=-1.0),)
    pulled = (JointValue(joint="drawer_joint", value=0.125),)
    turned_on = (JointValue(joint="knob_joint", value=2.0), JointValue(joint="rack_joint", value=0.1))
    narrow = {"castshadow": False, "cone_deg": 30.0}
    scene = Scene(
        id="corner",
        assets=(oven, barbecue, raised, loose, mug, orange, carton),
        placements=(
            Placement(name="oven", asset=oven.id, pose=at(1.0, -2.0, 0.9, QUARTER), joints=ajar),
            Placement(name="second_oven", asset=oven.id, pose=at(-1.25, 2.0, 0.9)),
            Placement(name="grill", asset=barbecue.id, pose=at(2.0, 0.5, 0.9, QUARTER), joints=turned_on),
            Placement(name="other_grill", asset=barbecue.id, pose=at(2.0, 1.5, 0.9)),
            Placement(name="unit", asset=raised.id, pose=at(0.0, -1.0, 0.0, QUARTER), joints=pulled),
            Placement(name="loose_oven", asset=loose.id, pose=at(-2.0, -2.0, 0.5, QUARTER), joints=ajar),
            Placement(name="mug", asset=mug.id, pose=at(0.0, 0.0, 1.0, QUARTER)),
            Placement(name="tilted_mug", asset=mug.id, pose=at(0.3, 0.0, 1.0, TILTED)),
            Placement(name="orange", asset=orange.id, pose=at(0.6, 0.0, 1.0)),
            Placement(name="wall", asset=carton.id, pose=at(0.0, 3.0, 0.0), layer=Layer.ROOM),
            Placement(name="ceiling", asset=carton.id, pose=at(0.0, 0.0, 2.5), layer=Layer.CEILING),
        ),
        cameras=(Camera(name="door", pose=at(0.0, -3.0, 1.6, TILTED), fov_y_deg=60.0),),
        lights=(
            Light(name="sun", position=(1.0, -3.0, 2.4), direction=(0.2, 0.5, -1.0), color=(0.6, 0.58, 0.5)),
            Light(name="bulb", kind=LightKind.POINT, position=(0.0, 0.0, 2.0), direction=(0.0, 0.0, -1.0)),
            Light(name="spot", kind=LightKind.SPOT, position=(1.0, 0.0, 2.0), direction=(0.0, 0.3, -1.0), **narrow),
        ),
        ambient=(0.3, 0.31, 0.32),
    )
    return ready_to_simulate(scene)


def put(files: Files, root: Path, scene: Scene) -> Path:
    """Files on disk as a pipeline puts them: the scene in a folder of its own beside the shared one; that folder."""
    own = {path: data for path, data in files.entries.items() if not path.startswith("assets/")}
    shared = {path: data for path, data in files.entries.items() if path.startswith("assets/")}
    write_to(Files.of(shared), root)
    return write_to(Files.of(own), root / scene.id)


def written(scene: Scene, root: Path) -> Path:
    put(usd.write(scene), root, scene)
    return put(mjcf.write(scene), root, scene)


def body(place: str, link: str) -> str:
    return place if link == "object" else f"{place}__{link}"


def expected(scene: Scene, key: str) -> dict[str, Pose]:
    """World poses of all bodies in a pose, by the maths of the fact tables, which no writer shares."""
    found = {}
    for place in scene.placements:
        asset = scene.asset_of[place.name]
        keys = {k.name: k for k in asset.keyframes} | {"start": Keyframe(name="start", joints=place.joints)}
        chosen = keys.get(key, Keyframe(name="closed"))
        posed = asset.replace(keyframes=(chosen.replace(name="asked"),))
        world_from_root = place.pose @ asset.root.pose
        for link, frame in asset_facts(posed)["poses"]["asked"].items():
            found[body(place.name, link)] = world_from_root @ Pose(**frame)
    return found


def start_states(scene: str, joints: Sequence[Mapping[str, Any]], qpos: Any, **more: Any) -> StartStates:
    """Start states of a scene, one for each row of `qpos`."""
    count = len(qpos)
    known = {"key": "k", "mujoco": "4.0.0", "seed": 0, "limits": (0.001, 0.005), "envelope": []}
    rows = {"notes": [{"placed": {}, "parked": "box"}] * count, "depth": [0] * count, "motion": [0] * count}
    base = {"scene": scene, "scene_xml": "0" * 64, "joints": joints, "qpos": qpos, "base": [[0, 0, 0]] * count}
    return StartStates.model_validate(known | rows | base | more)
