"""Reduce the MJCF and the USD of a whole scene to one table of facts each."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from functools import cached_property
from typing import Annotated, Any

import mujoco
import numpy as np
from pxr import Usd, UsdGeom, UsdLux, UsdPhysics

from casa_assets.checks.readers import mujoco_facts, usd_facts
from casa_assets.checks.readers.facts import (
    ROOT_BODY,
    AssetFacts,
    PoseFacts,
    ProgramTexts,
    Sorted,
    four,
    short_name,
    three,
)
from casa_assets.checks.readers.mujoco_facts import facts_of_model, free_bodies
from casa_assets.model.asset.asset import Base
from casa_assets.model.pose import Pose
from casa_assets.model.record import Record, Vec3, Vec4

# Facts ----------------------------------------------------------------------------------------------------------------


class PlacementFacts(Record):
    """One copy of an asset.

    Attributes:
        asset: id.
        layer: thing, room or ceiling.
        base: whether it floats.
        position, quaternion: world_from_root as physics finds it, every joint at zero.
        words: with the names that things have in the asset.
    """

    name: str
    asset: str
    layer: str
    base: Base
    position: Vec3
    quaternion: Vec4
    words: ProgramTexts


class CameraFacts(Record):
    """A camera: world_from_camera, looking along -z with y up, and its vertical field of view."""

    name: str
    position: Vec3
    quaternion: Vec4
    fov_y_deg: float


class LightFacts(Record):
    """A light, without its brightness, of which the formats have different notions.

    Attributes:
        kind: directional, point or spot.
        direction: unit vector along which it shines, zero where it shines to all sides.
        tint: its colour, the largest share 1.
        cone_deg: of a spot, else 0.
    """

    name: str
    kind: str
    castshadow: bool
    position: Vec3
    direction: Vec3
    tint: Vec3
    cone_deg: float


class SceneFacts(Record):
    """Facts that one format states about a scene.

    Attributes:
        gravity: m/s^2.
        things: bodies, exclusions, places, looks and poses of all placements under their names in the scene, `cup` and
            `cup__handle`. Bodies are in the frame of the root of their placement, poses are world_from_body. Base and
            words are empty here: they belong to placements.
    """

    gravity: Vec3
    placements: Annotated[tuple[PlacementFacts, ...], Sorted]
    cameras: Annotated[tuple[CameraFacts, ...], Sorted] = ()
    lights: Annotated[tuple[LightFacts, ...], Sorted] = ()
    things: AssetFacts


# Scene mjcf -----------------------------------------------------------------------------------------------------------
# scene.xml -> fact table of a scene, by way of the model that MuJoCo compiles from it.

# MuJoCo's cutoff of a light that shines to all sides, degrees.
ALL_SIDES_DEG = 180.0
# Texts that every placement has.
ASSET, MJCF_LAYER = "asset", "layer"
# Texts that name joints and geoms, which in the file begin with the name of the placement.
NAMING = ("label__", "grip__", "behind__", "state__")


def facts_of_scene_model(model: mujoco.MjModel) -> SceneFacts:
    """The table of a compiled scene.xml. Raises ValueError where it names no body for a placement."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return SceneFacts(
        gravity=three(model.opt.gravity),
        placements=_mjcf_placements(model, data),
        cameras=[
            CameraFacts(name=camera.name, position=camera.pos, quaternion=camera.quat, fov_y_deg=float(camera.fovy[0]))
            for camera in map(model.camera, range(model.ncam))
        ],
        lights=[_mjcf_light(model.light(i)) for i in range(model.nlight)],
        things=facts_of_model(model, base=Base.FIXED, words=ProgramTexts(), scene=True),
    )


def _mjcf_placements(model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[PlacementFacts]:
    said = _grouped(mujoco_facts.texts(model))
    geoms = _grouped({model.geom(i).name: "" for i in range(model.ngeom)})
    joints = _grouped({model.joint(i).name: "" for i in range(model.njnt)})
    bodies = {model.body(i).name: i for i in range(1, model.nbody)}
    free = set(free_bodies(model))
    for name, texts in sorted(said.items()):
        if name not in bodies:
            raise ValueError(f"there are texts of {name!r}, which is no body")
        body = bodies[name]
        plain = {key: _stripped(name, key, text) for key, text in texts.items()}
        yield PlacementFacts(
            name=name,
            asset=texts.get(ASSET, ""),
            layer=texts.get(MJCF_LAYER, ""),
            base=Base.FREE if body in free else Base.FIXED,
            position=three(data.xpos[body]),
            quaternion=four(data.xquat[body]),
            words=mujoco_facts.words(plain, set(geoms.get(name, {})), set(joints.get(name, {}))),
        )


def _grouped(named: dict[str, str]) -> dict[str, dict[str, str]]:
    """`cup__base` -> `cup` -> `base`."""
    found: dict[str, dict[str, str]] = {}
    for name, value in named.items():
        head, _, tail = name.partition("__")
        if tail:
            found.setdefault(head, {})[tail] = value
    return found


def _stripped(placement: str, key: str, text: str) -> str:
    """The text with the names that things have in the asset; a name of another placement becomes none that there is."""
    if not key.startswith(NAMING):
        return text
    prefix, words = f"{placement}__", text.split()
    named = words[:1] if key.startswith("state__") else words
    plain = [word.removeprefix(prefix) if word.startswith(prefix) else f"?{word}" for word in named]
    return " ".join([*plain, *words[len(named) :]])


def _mjcf_light(light: Any) -> LightFacts:
    """`light`: its view in the model. A point light is written as a spot whose cone holds all directions."""
    kinds, cutoff = mujoco.mjtLightType, float(light.cutoff[0])
    is_directional = light.type[0] == kinds.mjLIGHT_DIRECTIONAL
    is_cone = light.type[0] == kinds.mjLIGHT_SPOT and cutoff < ALL_SIDES_DEG
    return LightFacts(
        name=light.name,
        kind="directional" if is_directional else "spot" if is_cone else "point",
        castshadow=bool(light.castshadow[0]),
        position=three(light.pos),
        direction=three(light.dir) if is_directional or is_cone else (0.0, 0.0, 0.0),
        tint=three(light.diffuse / max(float(light.diffuse.max()), 1e-12)),
        cone_deg=cutoff if is_cone else 0.0,
    )


# Scene usd ------------------------------------------------------------------------------------------------------------
# scene.usda -> fact table of a scene, by two readers that share no code: MuJoCo and UsdPhysics.

USD_LAYER = "casa:layer"


class SceneReading(usd_facts.StageReading):
    """What OpenUSD alone reads of the stage of a scene, read once for the tables of both readers."""

    @cached_property
    def poses(self) -> list[PoseFacts]:
        """Named poses of all bodies."""
        return usd_facts.poses(self.stage, scene=True)

    @cached_property
    def words(self) -> dict[str, ProgramTexts]:
        """Name of a placement -> what programs read of it."""
        found = self.stage.GetDefaultPrim().GetChildren()
        return {prim.GetName(): usd_facts.words(prim) for prim in found if prim.GetPrimAtPath(ROOT_BODY)}

    @cached_property
    def lights_and_cameras(self) -> tuple[list[LightFacts], list[CameraFacts]]:
        """Distant lights and balls (the dome belongs to all of the scene), and cameras."""
        cache, prims = UsdGeom.XformCache(), list(self.stage.Traverse())
        kinds = (UsdLux.DistantLight, UsdLux.SphereLight)
        lights = [_usd_light(prim, cache) for prim in prims if any(map(prim.IsA, kinds))]
        return lights, [_usd_camera(prim, cache) for prim in prims if prim.IsA(UsdGeom.Camera)]

    def table(self, things: AssetFacts, gravity: Vec3, roots: dict[str, Pose], welded: Collection[str]) -> SceneFacts:
        """Table of the scene.

        Args:
            things: bodies of all placements, as one of the readers has them, like `gravity`.
            roots: names of placements, and of other bodies -> world_from_root.
            welded: placements that are fixed to the world.
        Raises:
            ValueError: physics knows nothing of a placement.
        """
        placements = []
        lights, cameras = self.lights_and_cameras
        for prim in self.stage.GetDefaultPrim().GetChildren():
            name = prim.GetName()
            if name not in self.words:
                continue
            if name not in roots:
                raise ValueError(f"placement {name!r} has no body {ROOT_BODY!r}")
            placements.append(
                PlacementFacts(
                    name=name,
                    asset=Usd.ModelAPI(prim).GetAssetName(),
                    layer=str(prim.GetAttribute(USD_LAYER).Get() or ""),
                    base=Base.FIXED if name in welded else Base.FREE,
                    position=roots[name].position,
                    quaternion=roots[name].quaternion,
                    words=self.words[name],
                )
            )
        return SceneFacts(
            gravity=gravity,
            placements=placements,
            cameras=cameras,
            lights=lights,
            things=things.replace(base=Base.FIXED, poses=self.poses),
        )


def facts_of_import(model: mujoco.MjModel, read: SceneReading) -> SceneFacts:
    """The table of a stage and of what MuJoCo imported from it."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    names = {short_name(model.body(i).name): i for i in range(1, model.nbody)}
    roots = {n: Pose(position=three(data.xpos[b]), quaternion=four(data.xquat[b])) for n, b in names.items()}
    free = set(free_bodies(model))
    welded = [name for name, body in names.items() if body not in free]
    return read.table(usd_facts.facts_of_import(model, read), three(model.opt.gravity), roots, welded)


def facts_of_stage(read: SceneReading) -> SceneFacts:
    """The table of a stage as UsdPhysics parses it. Raises ValueError where it holds what no scene has."""
    stage = read.stage
    things, welded = usd_facts.facts_of_stage(read)
    cache = UsdGeom.XformCache()
    bodies = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    rows = usd_facts.rigid_all([cache.GetLocalToWorldTransform(prim) for prim in bodies])
    roots = {
        short_name(str(prim.GetPath())): Pose(position=position, quaternion=quaternion)
        for prim, position, quaternion in zip(bodies, *rows, strict=True)
    }
    scenes = [UsdPhysics.Scene(p) for p in stage.Traverse() if p.IsA(UsdPhysics.Scene)]
    if len(scenes) != 1:
        raise ValueError(f"there are {len(scenes)} physics scenes, not one")
    strength = float(scenes[0].GetGravityMagnitudeAttr().Get())
    gravity = np.array(scenes[0].GetGravityDirectionAttr().Get(), dtype=np.float64) * strength
    return read.table(things, three(gravity), roots | welded, welded)


def _usd_camera(prim: Usd.Prim, cache: UsdGeom.XformCache) -> CameraFacts:
    lens, pose = UsdGeom.Camera(prim), usd_facts.rigid(cache.GetLocalToWorldTransform(prim))
    high, focal = lens.GetVerticalApertureAttr().Get(), lens.GetFocalLengthAttr().Get()
    fov = math.degrees(2 * math.atan(high / 2 / focal))
    return CameraFacts(name=prim.GetName(), position=pose.position, quaternion=pose.quaternion, fov_y_deg=fov)


def _usd_light(prim: Usd.Prim, cache: UsdGeom.XformCache) -> LightFacts:
    shaping = UsdLux.ShapingAPI(prim) if prim.HasAPI(UsdLux.ShapingAPI) else None
    kind = "directional" if prim.IsA(UsdLux.DistantLight) else "point" if shaping is None else "spot"
    pose = usd_facts.rigid(cache.GetLocalToWorldTransform(prim))
    color = np.array(UsdLux.LightAPI(prim).GetColorAttr().Get(), dtype=np.float64)
    return LightFacts(
        name=prim.GetName(),
        kind=kind,
        castshadow=bool(UsdLux.ShadowAPI(prim).GetShadowEnableAttr().Get()),
        position=pose.position,
        # Lights of USD shine along their -z.
        direction=three(np.zeros(3) if kind == "point" else -pose.rotation[:, 2]),
        tint=three(color / max(float(color.max()), 1e-12)),
        cone_deg=float(shaping.GetShapingConeAngleAttr().Get()) if shaping is not None else 0.0,
    )
