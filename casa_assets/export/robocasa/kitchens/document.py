"""Scene -> all files of a kitchen: its fixtures, its arena and its description."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from casa_assets.export import mjcf
from casa_assets.export.mujoco_values import ROBOSUITE_GROUPS, VIEWER_GROUPS
from casa_assets.export.robocasa import entries
from casa_assets.export.robocasa.kitchens import arena, description
from casa_assets.export.robocasa.kitchens.description import Placed
from casa_assets.model.asset.asset import Asset
from casa_assets.model.files import Files
from casa_assets.model.kitchen.scene import Scene

FIXTURES, KITCHENS = "fixtures", "kitchens"
MODEL = "model.xml"
CEILING = "ceiling"


def write_kitchen(scene: Scene, fixtures: tuple[Placed, ...], tasks: Sequence[str] = ()) -> Files:
    """Return `kitchen.json`, `arena.xml` and `layout.yaml` of a scene.

    Args:
        fixtures: result of `fixtures_of`.
        tasks: atomic tasks of RoboCasa v1.0 that the kitchen affords.
    """
    facts = {**description.describe(scene, fixtures, FIXTURES), "tasks": list(tasks)}
    return Files.of(
        {
            description.FILE: entries.json_bytes(facts),
            # JSON is YAML.
            description.LAYOUT_FILE: entries.json_bytes(description.layout(fixtures)),
            arena.FILE: arena.write(scene, description.excluded_bodies(scene, fixtures)),
        }
    )


def write_fixture(asset: Asset) -> Files:
    """Return `model.xml` of a centred fixture with its meshes and images.

    A ceiling and the outer faces of walls are in a group that robosuite's cameras do not show, so that the cameras see
    into the room from outside.
    """
    visuals = VIEWER_GROUPS.shell if asset.labels.category == CEILING else ROBOSUITE_GROUPS.visuals
    groups = replace(ROBOSUITE_GROUPS, visuals=visuals, shell=VIEWER_GROUPS.shell)
    files: Mapping[str, bytes] = mjcf.write(asset, groups).entries
    return Files.of(
        {path: data for path, data in files.items() if path == MODEL or path.startswith(("meshes/", "textures/"))}
    )
