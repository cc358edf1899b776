"""The model of a kitchen that its page shows in 3D: a script file in its folder, the viewer in the shared folder."""

from __future__ import annotations

from pathlib import Path

from casa_assets.export.gltf import EVERYTHING, scene_glb
from casa_assets.model.kitchen.scene import Scene
from casa_assets.pipeline.kitchens.scene_files import SHARED
from casa_assets.pipeline.viewer.model_files import SUFFIX, ModelFiles, put_model, put_viewer, viewer_name


def put_scene_model(folder: Path, scene: Scene) -> None:
    """Write the model of a scene into its folder, and the viewer beside the files that scenes share."""
    put_viewer(folder.parent / SHARED)
    put_model(folder, scene.id, scene_glb(scene, EVERYTHING))


def find_scene_model(folder: Path) -> ModelFiles | None:
    """What the page in the folder of a scene names to show it; None where there is no model."""
    found = min(folder.glob(f"*{SUFFIX}"), default=None)
    if found is None:
        return None
    return ModelFiles(found.name.removesuffix(SUFFIX), found.name, f"../{SHARED}/{viewer_name()}")
