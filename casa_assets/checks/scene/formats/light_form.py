"""Files of a scene next to its `scene.xml`, each read once; motion of the light form compared with the full one."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Protocol

import mujoco
import numpy as np
from pxr import Tf, Usd

from casa_assets.checks.check import Measurement, Problem, not_run
from casa_assets.checks.motion.simulation import reset_to_start
from casa_assets.checks.package.usd import Diagnostics
from casa_assets.checks.readers.mujoco_facts import Loaded, load_asset_file
from casa_assets.checks.readers.quiet import quiet
from casa_assets.checks.readers.usd_facts import imported
from casa_assets.checks.scene.motion.rest import Settled, farthest, settle
from casa_assets.checks.scene.subject import SceneSubject

# Files ----------------------------------------------------------------------------------------------------------------
# The files of a scene beside its `scene.xml`: USD, and the light form; each read once.

USD_FILE, NESTED_FILE, LIGHT_FILE = "scene.usda", "scene_nested.usda", "scene_light.xml"


class PassedLayers(Protocol):
    """Memory of layers of assets that passed SimReady's rules, by a digest of their content."""

    def has(self, digest: str) -> bool:
        """True if a layer of that digest passed."""

    def add(self, digests: Collection[str]) -> None:
        """Remember layers that passed."""


@dataclass(frozen=True, eq=False)
class SceneFiles:
    """Files in the same folder as `scene.xml`, each read once; a subject is equal to itself alone.

    Attributes:
        scene_subject: the scene and its `scene.xml`, which the others are compared with.
        passed_layers: layers that need not be checked by SimReady's rules again; None: all are checked.
    """

    scene_subject: SceneSubject
    passed_layers: PassedLayers | None = None

    @property
    def usd(self) -> Path:
        """The root layer."""
        return self.scene_subject.root / USD_FILE

    @property
    def nested(self) -> Path:
        """The layer that refers to the root layer and nests the bodies."""
        return self.scene_subject.root / NESTED_FILE

    @property
    def light(self) -> Path:
        """The light form: primitive shapes, without pictures."""
        return self.scene_subject.root / LIGHT_FILE

    @cached_property
    def composed(self) -> tuple[Usd.Stage | None, tuple[str, ...]]:
        """The stage, or None if it does not exist or open, and the errors and warnings of USD while it composes."""
        return _composed(self.usd)

    @cached_property
    def composed_nested(self) -> tuple[Usd.Stage | None, tuple[str, ...]]:
        """The same of the layer with nested bodies."""
        return _composed(self.nested)

    @cached_property
    def imported(self) -> Loaded:
        """The stage as MuJoCo's own reader has it."""
        with quiet():
            return imported(self.usd)

    @cached_property
    def imported_nested(self) -> Loaded:
        """The same with nested bodies."""
        with quiet():
            return imported(self.nested)

    @cached_property
    def light_form(self) -> Loaded:
        """The light form compiled, with MuJoCo's warnings."""
        return load_asset_file(self.light)


def _composed(path: Path) -> tuple[Usd.Stage | None, tuple[str, ...]]:
    """The stage of a file, None if it does not exist or open, and what USD says while it composes."""
    with quiet():
        diagnostics = Diagnostics()
        try:
            stage = Usd.Stage.Open(str(path)) if path.is_file() else None
        except Tf.ErrorException as error:
            return None, (" ".join(str(error).split()),)
        return stage, tuple(diagnostics.take())


# Light form -----------------------------------------------------------------------------------------------------------
# Find differences in motion between the light form of a scene and the full one.

# Fields of MjModel with a row per joint, dof or body that are the same in both forms.
JOINT_FIELDS = ("jnt_type", "jnt_range", "jnt_axis", "jnt_pos", "jnt_stiffness")
DOF_FIELDS = ("dof_damping", "dof_frictionloss", "dof_armature")
BODY_FIELDS = ("body_mass", "body_inertia", "body_ipos")
MAX_LISTED = 20
UNREADABLE = "MuJoCo cannot read scene_light.xml"


def mechanism_is_the_same(files: SceneFiles) -> Measurement:
    """SCN021: differences in joints, bodies and poses between the light form and the full one."""
    full, light = files.scene_subject.loaded.model, files.light_form
    name = files.light.name
    if full is None:
        return not_run("MuJoCo cannot read scene.xml, which the light form is held against")
    if light.model is None:
        return Measurement(1.0, ((name, light.error),))
    problems = [(name, f"MuJoCo warns: {warning}") for warning in light.warnings]
    meshes, pictures = int(light.model.nmesh), int((light.model.mat_texid >= 0).sum())
    if meshes:
        problems.append((name, f"has {meshes} meshes; use boxes, cylinders and spheres"))
    if pictures:
        problems.append((name, f"has {pictures} materials with pictures; use plain colours"))
    problems += _differences(full, light.model)
    return Measurement(float(len(problems)), tuple(problems[:MAX_LISTED]))


def no_penetration_after_settling(files: SceneFiles, limit: float) -> Measurement:
    """SCN022: deepest penetration in the light form at the start and after 1 s, metres."""
    settled = settled_scene(files)
    if settled is None:
        return not_run(UNREADABLE)
    return settled.deepest(limit, "in the light form; see the shapes that stand for it there")


def loose_things_stay_put(files: SceneFiles, limit: float) -> Measurement:
    """SCN028: largest distance that a free-standing object moves in 5 s in the light form, metres."""
    settled = settled_scene(files)
    if settled is None:
        return not_run(UNREADABLE)
    advice = " in the light form; the shapes that stand for it there do not stand"
    return farthest(settled.drift, limit, advice, MAX_LISTED)


@lru_cache(maxsize=1)
def settled_scene(files: SceneFiles) -> Settled | None:
    """Simulate the light form for 5 s, once; None if it does not load."""
    model = files.light_form.model
    if model is None:
        return None
    data = mujoco.MjData(model)
    reset_to_start(model, data)
    mujoco.mj_forward(model, data)
    return settle(data)


def _differences(full: mujoco.MjModel, light: mujoco.MjModel) -> Iterator[Problem]:
    """Names of joints, bodies that move and poses that only one has, and numbers of them that differ."""
    for kind, word, field in ((mujoco.mjtObj.mjOBJ_JOINT, "joints", "njnt"), (mujoco.mjtObj.mjOBJ_KEY, "keys", "nkey")):
        full_names, light_names = (
            [str(mujoco.mj_id2name(model, kind, i)) for i in range(getattr(model, field))] for model in (full, light)
        )
        if full_names != light_names:
            only_one = [n for n in [*full_names, *light_names] if (n in full_names) != (n in light_names)]
            yield word, f"are others, or in another order, than in the full form: {', '.join(only_one[:5])}"
            return
    full_bodies, light_bodies = (np.flatnonzero(model.body_weldid != 0) for model in (full, light))
    if [full.body(b).name for b in full_bodies] != [light.body(b).name for b in light_bodies]:
        yield "bodies", f"{len(full_bodies)} move in the full form, {len(light_bodies)} in the light one"
        return
    for field in (*JOINT_FIELDS, *DOF_FIELDS, "key_qpos"):
        yield from _number_differences(field, getattr(full, field), getattr(light, field))
    for field in BODY_FIELDS:
        yield from _number_differences(field, getattr(full, field)[full_bodies], getattr(light, field)[light_bodies])


def _number_differences(field: str, full: np.ndarray, light: np.ndarray) -> Iterator[Problem]:
    off = ~np.isclose(full, light, rtol=1e-6, atol=1e-9)
    if off.any():
        yield field, f"differs in {int(off.sum())} numbers, by at most {np.abs(full - light)[off].max():.3g}"
