"""Reduce the MJCF and the USD of a whole scene to one table of facts each."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np
from pxr import Usd, UsdGeom, UsdLux, UsdPhysics

from casa_assets.checks.package.facts import AssetFacts, PoseFacts, ProgramTexts
from casa_assets.checks.readers import mujoco_facts, mujoco_load, usd_facts
from casa_assets.checks.readers.mujoco_facts import ROOT_BODY, facts_of_model, four, free_bodies, short_name, three
from casa_assets.model.asset.asset import Base
from casa_assets.model.pose import Pose
from casa_assets.model.record import Record, Vec3, Vec4

# Facts ----------------------------------------------------------------------------------------------------------------
# Fact table of a scene, which both formats are reduced to.


class PlacementFacts(Record):
    """One copy of an asset.

    Attributes:
        asset: id. layer: thing, room or ceiling. base: whether it floats.
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
    position: Vec3
    direction: Vec3
    tint: Vec3
    castshadow: bool
    cone_deg: float


class SceneFacts(Record):
    """Facts that one format states about a scene.

    Attributes:
        gravity: m/s^2.
        placements, cameras, lights: sorted by name.
        things: bodies, exclusions, places, looks and poses of all placements under their names in the scene, `cup` and
            `cup__handle`. Bodies are in the frame of the root of their placement, poses are world_from_body. Base and
            words are empty here: they belong to placements.
    """

    gravity: Vec3
    placements: tuple[PlacementFacts, ...]
    cameras: tuple[CameraFacts, ...] = ()
    lights: tuple[LightFacts, ...] = ()
    things: AssetFacts


# Scene mjcf -----------------------------------------------------------------------------------------------------------
# scene.xml -> fact table of a scene, by way of the model that MuJoCo compiles from it.

# MuJoCo's cutoff of a light that shines to all sides, degrees.
ALL_SIDES_DEG = 180.0
# Texts that every placement has.
ASSET, MJCF_LAYER = "asset", "layer"
# Texts that name joints and geoms, which in the file begin with the name of the placement.
NAMING = ("label__", "grip__", "behind__", "state__")


def facts_of_mjcf(path: Path) -> SceneFacts:
    """The table of a scene.xml. Raises ValueError where it does not compile, or names no body for a placement."""
    loaded = mujoco_load.load_asset_file(path)
    if loaded.model is None:
        raise ValueError(f"{path.name} does not compile: {loaded.error}")
    return facts_of_scene_model(loaded.model)


def facts_of_scene_model(model: mujoco.MjModel) -> SceneFacts:
    """The table of a compiled scene.xml."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return SceneFacts(
        gravity=three(model.opt.gravity),
        placements=tuple(_mjcf_placements(model, data)),
        cameras=_mjcf_cameras(model),
        lights=_mjcf_lights(model),
        things=facts_of_model(model, base=Base.FIXED, words=ProgramTexts(classes=()), scene=True),
    )


def _mjcf_placements(model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[PlacementFacts]:
    """Sorted by name."""
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


def _mjcf_cameras(model: mujoco.MjModel) -> tuple[CameraFacts, ...]:
    found = []
    for i in range(model.ncam):
        place = {"position": three(model.cam_pos[i]), "quaternion": four(model.cam_quat[i])}
        found.append(CameraFacts(name=model.camera(i).name, fov_y_deg=float(model.cam_fovy[i]), **place))
    return tuple(sorted(found, key=lambda camera: camera.name))


def _light_kind(model: mujoco.MjModel, light: int) -> str:
    """`directional`, `spot`, or `point`, which is written as a spot whose cone holds all directions."""
    kinds = mujoco.mjtLightType
    if model.light_type[light] == kinds.mjLIGHT_DIRECTIONAL:
        return "directional"
    is_cone = model.light_type[light] == kinds.mjLIGHT_SPOT and model.light_cutoff[light] < ALL_SIDES_DEG
    return "spot" if is_cone else "point"


def _mjcf_lights(model: mujoco.MjModel) -> tuple[LightFacts, ...]:
    found = []
    for i in range(model.nlight):
        kind = _light_kind(model, i)
        color = model.light_diffuse[i] / max(float(model.light_diffuse[i].max()), 1e-12)
        found.append(
            LightFacts(
                name=model.light(i).name,
                kind=kind,
                position=three(model.light_pos[i]),
                direction=three(np.zeros(3) if kind == "point" else model.light_dir[i]),
                tint=three(color),
                castshadow=bool(model.light_castshadow[i]),
                cone_deg=float(model.light_cutoff[i]) if kind == "spot" else 0.0,
            )
        )
    return tuple(sorted(found, key=lambda light: light.name))


# Scene usd ------------------------------------------------------------------------------------------------------------
# scene.usda -> fact table of a scene, by two readers that share no code: MuJoCo and UsdPhysics.

USD_LAYER = "casa:layer"


class SceneReading(usd_facts.StageReading):
    """What OpenUSD alone reads of the stage of a scene, read once for the tables of both readers."""

    @cached_property
    def poses(self) -> tuple[PoseFacts, ...]:
        """Named poses of all bodies."""
        return usd_facts.poses(self.stage, scene=True)

    @cached_property
    def words(self) -> dict[str, ProgramTexts]:
        """Name of a placement -> what programs read of it."""
        found = self.stage.GetDefaultPrim().GetChildren()
        return {prim.GetName(): usd_facts.words_below(prim) for prim in found if prim.GetPrimAtPath(ROOT_BODY)}

    @cached_property
    def cameras(self) -> tuple[CameraFacts, ...]:
        """Cameras, by name."""
        return _usd_cameras(self.stage)

    @cached_property
    def lights(self) -> tuple[LightFacts, ...]:
        """Lights, by name."""
        return _usd_lights(self.stage)


def facts_of_usd_by_mujoco(path: Path) -> SceneFacts:
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
        placements=tuple(_usd_placements(read, stand, welded)),
        cameras=read.cameras,
        lights=read.lights,
        things=things,
    )


def facts_of_usd_by_pxr(stage: Usd.Stage) -> SceneFacts:
    """The table of a scene.usda as UsdPhysics parses it. Raises ValueError where it holds what no scene has."""
    return facts_of_stage(SceneReading(stage))


def facts_of_stage(read: SceneReading) -> SceneFacts:
    """The same of a stage that is read for other tables too."""
    stage = read.stage
    things, welded = usd_facts.facts_of_stage(read)
    cache = UsdGeom.XformCache()
    bodies = [prim for prim in stage.Traverse() if prim.HasAPI(UsdPhysics.RigidBodyAPI)]
    rows = usd_facts.rigid_all([cache.GetLocalToWorldTransform(prim) for prim in bodies])
    stand = {
        short_name(str(prim.GetPath())): Pose(position=position, quaternion=quaternion)
        for prim, position, quaternion in zip(bodies, *rows, strict=True)
    }
    return SceneFacts(
        gravity=_gravity(stage),
        placements=tuple(_usd_placements(read, stand | welded, welded)),
        cameras=read.cameras,
        lights=read.lights,
        # A scene has no base of its own.
        things=things.replace(base=Base.FIXED, poses=read.poses),
    )


def _usd_placements(read: SceneReading, stand: dict[str, Pose], welded: dict[str, Pose]) -> Iterator[PlacementFacts]:
    """Sorted by name. Raises ValueError where physics knows nothing of one."""
    for prim in sorted(read.stage.GetDefaultPrim().GetChildren(), key=lambda p: p.GetName()):
        name = prim.GetName()
        if name not in read.words:
            continue
        if name not in stand:
            raise ValueError(f"placement {name!r} has no body {ROOT_BODY!r}")
        layer = prim.GetAttribute(USD_LAYER).Get()
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
    """Gravity of the one physics scene. Raises ValueError if there is not exactly one."""
    scenes = [UsdPhysics.Scene(p) for p in stage.Traverse() if p.IsA(UsdPhysics.Scene)]
    if len(scenes) != 1:
        raise ValueError(f"there are {len(scenes)} physics scenes, not one")
    strength = float(scenes[0].GetGravityMagnitudeAttr().Get())
    return three(np.array(scenes[0].GetGravityDirectionAttr().Get(), dtype=np.float64) * strength)


def _usd_cameras(stage: Usd.Stage) -> tuple[CameraFacts, ...]:
    found, cache = [], UsdGeom.XformCache()
    for prim in (p for p in stage.Traverse() if p.IsA(UsdGeom.Camera)):
        lens, pose = UsdGeom.Camera(prim), usd_facts.rigid(cache.GetLocalToWorldTransform(prim))
        high, focal = lens.GetVerticalApertureAttr().Get(), lens.GetFocalLengthAttr().Get()
        fov = math.degrees(2 * math.atan(high / 2 / focal))
        place = {"position": pose.position, "quaternion": pose.quaternion}
        found.append(CameraFacts(name=prim.GetName(), fov_y_deg=fov, **place))
    return tuple(sorted(found, key=lambda camera: camera.name))


def _usd_lights(stage: Usd.Stage) -> tuple[LightFacts, ...]:
    """Distant lights and balls; the dome is no light of the scene's own."""
    found, cache = [], UsdGeom.XformCache()
    for prim in stage.Traverse():
        distant = prim.IsA(UsdLux.DistantLight)
        if not distant and not prim.IsA(UsdLux.SphereLight):
            continue
        shaping = UsdLux.ShapingAPI(prim) if prim.HasAPI(UsdLux.ShapingAPI) else None
        kind = "directional" if distant else "point" if shaping is None else "spot"
        pose = usd_facts.rigid(cache.GetLocalToWorldTransform(prim))
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
