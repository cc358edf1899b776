"""Scene -> all files of a kitchen: its fixtures, its arena and its description."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from lxml import etree

from casa_assets.addons.robocasa.writers import entries
from casa_assets.addons.robocasa.writers.kitchens import description
from casa_assets.addons.robocasa.writers.kitchens.description import Placed
from casa_assets.formats import mjcf
from casa_assets.formats.mjcf import kitchen
from casa_assets.formats.values import ROBOSUITE_GROUPS, VIEWER_GROUPS, numbers
from casa_assets.model.asset.asset import Asset
from casa_assets.model.files import Files
from casa_assets.model.kitchen.scene import Scene

FIXTURES, KITCHENS = "fixtures", "kitchens"
MODEL = "model.xml"
ARENA_FILE = "arena.xml"
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
            ARENA_FILE: arena(scene, description.excluded_bodies(scene, fixtures)),
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


def arena(scene: Scene, exclusions: Iterable[tuple[str, str]]) -> bytes:
    """Return the sky, lights and cameras of a kitchen, and pairs of fixture bodies that never collide.

    From fixtures RoboCasa merges only bodies and assets; from the arena it also merges `<contact>`.

    Args:
        exclusions: pairs of body names, as they are after RoboCasa has merged the fixtures.
    """
    root = etree.Element("mujoco", {"model": scene.id})
    etree.SubElement(root, "compiler", {"angle": "radian", "autolimits": "true"})
    kitchen.add_sky(etree.SubElement(root, "asset"), scene)
    world = etree.SubElement(root, "worldbody")
    kitchen.add_lights_and_cameras(world, scene)
    # Even light from all sides. In scene.xml it is the headlight's, which RoboCasa does not merge.
    light = world.find("light")
    if light is None:
        down = {"name": "ambient", "dir": "0 0 -1", "diffuse": "0 0 0", "specular": "0 0 0", "castshadow": "false"}
        light = etree.SubElement(world, "light", down)
    light.set("ambient", numbers(scene.ambient))
    pairs = etree.SubElement(root, "contact")
    for first, second in exclusions:
        etree.SubElement(pairs, "exclude", {"name": f"{first}__{second}", "body1": first, "body2": second})
    return etree.tostring(root, encoding="us-ascii", pretty_print=True)
