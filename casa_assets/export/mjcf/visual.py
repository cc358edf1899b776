"""Visual -> geom that is seen and weighs, touches and stops nothing."""

from __future__ import annotations

from lxml import etree

from casa_assets.export.mjcf.mesh import MeshFile
from casa_assets.model.asset.asset import Visual

# Ref: robosuite, geoms of group 1 are drawn.
GROUP = 1
# Ref: mujoco_menagerie, geoms of group 2 are seen; the viewer shows groups 0 to 2.
VIEWER_GROUP = 2


def add(body: etree._Element, visual: Visual, file: MeshFile, material: str, group: int, prefix: str = "") -> None:
    """`<geom>` below `<body>`; `material` is the name of a `<material>`, `prefix` the begin of its own."""
    attributes = {
        "name": prefix + visual.name,
        "type": "mesh",
        "mesh": file.name,
        "material": material,
        "group": str(group),
        "contype": "0",
        "conaffinity": "0",
        "mass": "0",
    }
    etree.SubElement(body, "geom", attributes)
