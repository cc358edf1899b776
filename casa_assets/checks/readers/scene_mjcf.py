"""scene.xml -> fact table of a scene, by way of the model that MuJoCo compiles from it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np

from casa_assets.checks.package.facts import ProgramTexts
from casa_assets.checks.readers import mjcf_facts, mujoco_load
from casa_assets.checks.readers.mujoco_facts import facts_of_model, four, free_bodies, three
from casa_assets.checks.scene.formats.facts import CameraFacts, LightFacts, PlacementFacts, SceneFacts
from casa_assets.model.asset.asset import Base

# MuJoCo's cutoff of a light that shines to all sides, degrees.
ALL_SIDES_DEG = 180.0
# Texts that every placement has.
ASSET, LAYER = "asset", "layer"
# Texts that name joints and geoms, which in the file begin with the name of the placement.
NAMING = ("label__", "grip__", "behind__", "state__")


def facts(path: Path) -> SceneFacts:
    """The table of a scene.xml. Raises ValueError where it does not compile, or names no body for a placement."""
    loaded = mujoco_load.load_asset_file(path)
    if loaded.model is None:
        raise ValueError(f"{path.name} does not compile: {loaded.error}")
    return facts_of(loaded.model)


def facts_of(model: mujoco.MjModel) -> SceneFacts:
    """The table of a compiled scene.xml."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return SceneFacts(
        gravity=three(model.opt.gravity),
        placements=tuple(_placements(model, data)),
        cameras=_cameras(model),
        lights=_lights(model),
        things=facts_of_model(model, base=Base.FIXED, words=ProgramTexts(classes=()), scene=True),
    )


def _placements(model: mujoco.MjModel, data: mujoco.MjData) -> Iterator[PlacementFacts]:
    """Sorted by name."""
    said = _grouped(mjcf_facts.texts(model))
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
            layer=texts.get(LAYER, ""),
            base=Base.FREE if body in free else Base.FIXED,
            position=three(data.xpos[body]),
            quaternion=four(data.xquat[body]),
            words=mjcf_facts.words(plain, set(geoms.get(name, {})), set(joints.get(name, {}))),
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


def _cameras(model: mujoco.MjModel) -> tuple[CameraFacts, ...]:
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


def _lights(model: mujoco.MjModel) -> tuple[LightFacts, ...]:
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
