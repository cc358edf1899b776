"""Scene -> arena.xml: sky, lights and cameras of a kitchen, and pairs of fixture bodies that never collide.

From fixtures RoboCasa merges only bodies and assets; from the arena it also merges `<contact>`.
"""

from __future__ import annotations

from collections.abc import Iterable

from lxml import etree

from casa_assets.export.mjcf import shapes
from casa_assets.export.mjcf.scene import kitchen
from casa_assets.model.kitchen.scene import Scene

FILE = "arena.xml"


def write(scene: Scene, exclusions: Iterable[tuple[str, str]]) -> bytes:
    """Return the arena of a scene; the same scene gives the same bytes.

    Args:
        exclusions: pairs of body names, as they are after RoboCasa has merged the fixtures.
    """
    root = etree.Element("mujoco", {"model": scene.id})
    etree.SubElement(root, "compiler", {"angle": "radian", "autolimits": "true"})
    kitchen.add_sky(etree.SubElement(root, "asset"), scene)
    world = etree.SubElement(root, "worldbody")
    kitchen.add_lights_and_cameras(world, scene)
    _add_ambient(world, scene)
    pairs = etree.SubElement(root, "contact")
    for first, second in exclusions:
        etree.SubElement(pairs, "exclude", {"name": f"{first}__{second}", "body1": first, "body2": second})
    return etree.tostring(root, encoding="us-ascii", pretty_print=True)


def _add_ambient(world: etree._Element, scene: Scene) -> None:
    """Add even light from all sides. In scene.xml it is the headlight's, which RoboCasa does not merge."""
    light = world.find("light")
    if light is None:
        down = {"name": "ambient", "dir": "0 0 -1", "diffuse": "0 0 0", "specular": "0 0 0", "castshadow": "false"}
        light = etree.SubElement(world, "light", down)
    light.set("ambient", shapes.numbers(scene.ambient))
