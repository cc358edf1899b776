"""scene.usda -> fact table of a scene, by two readers that share no code: MuJoCo and UsdPhysics."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np
from pxr import Usd, UsdGeom, UsdLux, UsdPhysics

from casa_assets.checks.package.facts import PoseFacts, ProgramTexts
from casa_assets.checks.readers import usd_facts, usd_words
from casa_assets.checks.readers.mujoco_facts import ROOT_BODY, four, free_bodies, short_name, three
from casa_assets.checks.scene.formats.facts import CameraFacts, LightFacts, PlacementFacts, SceneFacts
from casa_assets.model.asset.asset import Base
from casa_assets.model.pose import Pose
from casa_assets.model.record import Vec3

LAYER = "casa:layer"


class SceneReading(usd_facts.StageReading):
    """What OpenUSD alone reads of the stage of a scene, read once for the tables of both readers."""

    @cached_property
    def poses(self) -> tuple[PoseFacts, ...]:
        """Named poses of all bodies."""
        return usd_words.poses(self.stage, scene=True)

    @cached_property
    def words(self) -> dict[str, ProgramTexts]:
        """Name of a placement -> what programs read of it."""
        found = self.stage.GetDefaultPrim().GetChildren()
        return {prim.GetName(): usd_words.words_below(prim) for prim in found if prim.GetPrimAtPath(ROOT_BODY)}

    @cached_property
    def cameras(self) -> tuple[CameraFacts, ...]:
        """Cameras, by name."""
        return _cameras(self.stage)

    @cached_property
    def lights(self) -> tuple[LightFacts, ...]:
        """Lights, by name."""
        return _lights(self.stage)


def mujoco_facts(path: Path) -> SceneFacts:
    """The table of a scene.usda as MuJoCo imports it. Raises ValueError where it does not."""
    loaded = usd_facts.imported(path)
    if loaded.model is None:
        raise ValueError(loaded.error)
    return facts_of_import(loaded.model, SceneReading(usd_facts.opened(path)))


def facts_of_import(model: mujoco.MjModel, read: SceneReading) -> SceneFacts:
    """The table of a stage and of what MuJoCo imported from it."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    names = {short_name(model.body(i).name): i for i in range(1, model.nbody)}
    stand = {n: Pose(position=three(data.xpos[b]), quaternion=four(data.xquat[b])) for n, b in names.items()}
    free = set(free_bodies(model))
    welded = {name: stand[name] for name, body in names.items() if body not in free}
    things = usd_facts.facts_of_import(model, read).replace(poses=read.poses)
    return SceneFacts(
        gravity=three(model.opt.gravity),
        placements=tuple(_placements(read, stand, welded)),
        cameras=read.cameras,
        lights=read.lights,
        things=things,
    )


def pxr_facts(stage: Usd.Stage) -> SceneFacts:
    """The table of a scene.usda as UsdPhysics parses it. Raises ValueError where it holds what no scene has."""
    return facts_of_stage(SceneReading(stage))


def facts_of_stage(read: SceneReading) -> SceneFacts:
    """The same of a stage that is read for other tables too."""
    stage = read.stage
    things, welded = usd_facts.facts_of_stage(read)
    cache = UsdGeom.XformCache()
    bodies = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    rows = usd_words.rigid_all([cache.GetLocalToWorldTransform(prim) for prim in bodies])
    stand = {
        short_name(str(prim.GetPath())): Pose(position=position, quaternion=quaternion)
        for prim, position, quaternion in zip(bodies, *rows, strict=True)
    }
    return SceneFacts(
        gravity=_gravity(stage),
        placements=tuple(_placements(read, stand | welded, welded)),
        cameras=read.cameras,
        lights=read.lights,
        # A scene has no base of its own.
        things=things.replace(base=Base.FIXED, poses=read.poses),
    )


def _placements(read: SceneReading, stand: dict[str, Pose], welded: dict[str, Pose]) -> Iterator[PlacementFacts]:
    """Sorted by name. Raises ValueError where physics knows nothing of one."""
    for prim in sorted(read.stage.GetDefaultPrim().GetChildren(), key=lambda p: p.GetName()):
        name = prim.GetName()
        if name not in read.words:
            continue
        if name not in stand:
            raise ValueError(f"placement {name!r} has no body {ROOT_BODY!r}")
        layer = prim.GetAttribute(LAYER).Get()
        yield PlacementFacts(
            name=name,
            asset=Usd.ModelAPI(prim).GetAssetName(),
            layer=str(layer or ""),
            base=Base.FIXED if name in welded else Base.FREE,
            position=stand[name].position,
            quaternion=stand[name].quaternion,
            words=read.words[name],
        )


def _gravity(stage: Usd.Stage) -> Vec3:
    """Gravity of the one physics scene. Raises ValueError where there is not one."""
    scenes = [UsdPhysics.Scene(p) for p in stage.Traverse() if p.IsA(UsdPhysics.Scene)]
    if len(scenes) != 1:
        raise ValueError(f"there are {len(scenes)} physics scenes, not one")
    strength = float(scenes[0].GetGravityMagnitudeAttr().Get())
    return three(np.array(scenes[0].GetGravityDirectionAttr().Get(), dtype=np.float64) * strength)


def _cameras(stage: Usd.Stage) -> tuple[CameraFacts, ...]:
    found, cache = [], UsdGeom.XformCache()
    for prim in (p for p in stage.Traverse() if p.IsA(UsdGeom.Camera)):
        lens, pose = UsdGeom.Camera(prim), usd_words.rigid(cache.GetLocalToWorldTransform(prim))
        high, focal = lens.GetVerticalApertureAttr().Get(), lens.GetFocalLengthAttr().Get()
        fov = math.degrees(2 * math.atan(high / 2 / focal))
        place = {"position": pose.position, "quaternion": pose.quaternion}
        found.append(CameraFacts(name=prim.GetName(), fov_y_deg=fov, **place))
    return tuple(sorted(found, key=lambda camera: camera.name))


def _lights(stage: Usd.Stage) -> tuple[LightFacts, ...]:
    """Distant lights and balls; the dome is no light of the scene's own."""
    found, cache = [], UsdGeom.XformCache()
    for prim in stage.Traverse():
        distant = prim.IsA(UsdLux.DistantLight)
        if not distant and not prim.IsA(UsdLux.SphereLight):
            continue
        shaping = UsdLux.ShapingAPI(prim) if prim.HasAPI(UsdLux.ShapingAPI) else None
        kind = "directional" if distant else "point" if shaping is None else "spot"
        pose = usd_words.rigid(cache.GetLocalToWorldTransform(prim))
        color = np.array(UsdLux.LightAPI(prim).GetColorAttr().Get(), dtype=np.float64)
        found.append(
            LightFacts(
                name=prim.GetName(),
                kind=kind,
                position=pose.position,
                # Lights of USD shine along their -z.
                direction=three(np.zeros(3) if kind == "point" else -pose.rotation[:, 2]),
                tint=three(color / max(float(color.max()), 1e-12)),
                castshadow=bool(UsdLux.ShadowAPI(prim).GetShadowEnableAttr().Get()),
                cone_deg=float(shaping.GetShapingConeAngleAttr().Get()) if shaping is not None else 0.0,
            )
        )
    return tuple(sorted(found, key=lambda light: light.name))
